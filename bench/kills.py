#!/usr/bin/python3
"""Kills a job of every stage at random moments, and lets the same command go on until it ends.

The job: raw scans with poses, outliers, merging, estimated and propagated normals, smoothing, thinning, three ball
radii, hole filling, a mesh, a picture and a report. In each round the command is killed (SIGKILL; with --gentle SIGTERM
or SIGINT) some six times, each time later in the job, and then goes on to the end. The moments are drawn from a seed and
spread evenly over the stages of an undisturbed run, the start and the removal of the work directory, at a random time
within each; every start but the first is a resumption, so kills fall on those as well.

After each round: mesh and picture have the bytes of the undisturbed run, the report the same mesh and holes, and the
directory holds nothing but what the undisturbed run leaves.

No work is repeated beyond what was in flight: results and documents that are committed when a run is killed are the
same files (the same inodes) when the next one is killed or ends, unless a later stage was complete by then and they
were removed as no longer needed. So what a kill costs are the results that were written and not yet named (part files,
counted), and at most one per thread that was being computed; `repeated_at_most` adds these up over all kills, beside the
chunks that one run needs. Mesh file and picture start over when they are killed, and so do counting and binning of
points that fit in memory (as they do here).

The exit status is 1 when one of these does not hold.

usage: bench/kills.py [--kills 200] [--seed 1] [--points N] [--gentle] [--full]
"""
import argparse
import hashlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import harness

THREADS = 2
POINTS, FULL_POINTS = 24_000, 2_000_000
JOB = """[input]
files = ["scan_*.ply"]
poses = "scan.conf"
[partition]
memory = "1GiB"
chunk_points = {chunk}
[prepare]
outlier_sigma = 6.0
merge_tolerance = {merge:.6g}
smooth_radius = {smooth:.6g}
thin_to_spacing = {thin:.6g}
[normals]
source = "estimate"
orientation = "propagate"
[reconstruct]
ball_radii = [{radius:.6g}, {radius2:.6g}, {radius3:.6g}]
[fill]
neighborhood = 1.5
[output]
mesh = "mesh.ply"
report = "mesh.report.json"
picture = "mesh.png"
[run]
threads = {threads}
work_dir = "work"
"""
RAW_STAGES = ["raw", "raw_outliers", "raw_merged", "raw_normals", "raw_smooth_1", "raw_smooth_2", "raw_thinned",
              "raw_patches"]
DOCUMENTS = {"partition.json.xxh3", "ended.json.xxh3", "moves.json.xxh3"}  # written last
START, REMOVAL = "start", "removal"
KILLS_PER_ROUND = 6
LOG_STAGE = re.compile(r" info (.+): (begins|ends)\b")


class Job:
    """The job in its directory."""

    def __init__(self, options, directory):
        self.program = str(pathlib.Path(options.program).resolve())
        self.directory = directory
        self.work = directory / "work"
        self.log = self.work / "orbweave.log"
        points = options.points
        harness.run([self.program, "generate", "torus", "--points", points, "--noise", "0.2", "--scans", 5,
                     "--misregistration", "0.5", "--separate", "-o", directory / "scan.ply"])
        gap = harness.spacing("torus", points)
        (directory / "job.toml").write_text(JOB.format(
            chunk=max(500, points // 40), merge=0.1 * gap, smooth=3 * gap, thin=0.4 * gap, radius=0.8 * gap,
            radius2=1.3 * gap, radius3=2 * gap, threads=THREADS))
        self.inputs = set(os.listdir(directory))

    def start(self):
        return subprocess.Popen([self.program, "run", "job.toml", "--progress", "none"], cwd=self.directory,
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def outputs(self):
        """What the run left, beside its inputs: {name: SHA-256}, the report by what does not change."""
        found = {}
        for name in sorted(set(os.listdir(self.directory)) - self.inputs):
            path = self.directory / name
            if name == "mesh.report.html" or path.is_dir():
                found[name] = "there"
            elif name == "mesh.report.json":
                found[name] = unchanging(json.loads(path.read_text()))
            else:
                found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        return found

    def clear(self):
        """Outputs of the round before; a work directory is never there then."""
        for name in set(os.listdir(self.directory)) - self.inputs:
            path = self.directory / name
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    def results(self):
        """{(stage, file): inode} of what is committed, and the number of part files."""
        committed, parts = {}, 0
        for stage in self.work.iterdir() if self.work.is_dir() else ():
            if not stage.is_dir():
                continue
            for entry in os.scandir(stage):
                if entry.name.endswith(".h5") or entry.name in DOCUMENTS:
                    committed[stage.name, entry.name] = entry.stat().st_ino
                elif entry.name.endswith(".h5.part"):
                    parts += 1
        return committed, parts

    def may_go(self, stage):
        """Whether results of the stage are no longer needed: a later one is complete."""
        if not self.work.is_dir() or (self.work / "ended.json").exists():
            return True
        if stage.endswith("_cut"):  # counts and bins, until the points are sorted
            return any((self.work / name / "partition.json").exists() for name in (stage[:-len("_cut")], "points"))
        if not stage.startswith("raw"):
            return False
        later = RAW_STAGES[RAW_STAGES.index(stage) + 1:]
        return (self.work / "points" / "partition.json").exists() or any(
            (self.work / name / "ended.json").exists() for name in later)

    def log_text(self):
        try:
            return self.log.read_text()
        except FileNotFoundError:
            return ""


def unchanging(report):
    """What of a report is the same for every run."""
    holes = [{key: value for key, value in hole.items() if key != "seconds"} for hole in report["holes"]]
    kept = {key: report[key] for key in ("input", "partition", "radii", "mesh")}
    return hashlib.sha256(json.dumps([kept, holes], sort_keys=True).encode()).hexdigest()


def stages_in(text):
    """[(stage, "begins" or "ends")] of a log."""
    return LOG_STAGE.findall(text)


def undisturbed(job):
    """Durations by moment, and the chunks that each stage of the store needs."""
    began = time.monotonic()
    process = job.start()
    _, err = process.communicate()
    if process.returncode != 0:
        sys.exit(f"exit status {process.returncode}: {err}")
    total = time.monotonic() - began
    report = json.loads((job.directory / "mesh.report.json").read_text())
    listed = harness.stages(report)
    durations = {name: facts["seconds"] for name, facts in listed.items()}
    chunks = {name: facts["chunks"] for name, facts in listed.items() if facts["chunks"]}
    return durations, chunks, total


def has_come(job, moment, begun):
    """Whether the run that began with that much log is at the moment."""
    if moment == START:
        return True
    if moment == REMOVAL:
        return (job.work / "ended.json").exists()
    return (moment, "begins") in stages_in(job.log_text()[begun:])


def attempt(job, moment, fraction, duration, how):
    """One run, killed where it comes to the moment (None: nowhere). Returns exit status and messages."""
    begun = len(job.log_text())
    process = job.start()
    while moment is not None and process.poll() is None and not has_come(job, moment, begun):
        time.sleep(0.001)
    deadline = time.monotonic() + fraction * duration
    while moment is not None and process.poll() is None and time.monotonic() < deadline:
        time.sleep(min(0.002, max(0.0, deadline - time.monotonic())))
    if moment is not None and process.poll() is None:
        process.send_signal(how)
    out, err = process.communicate()
    return process.returncode, out + err


class Books:
    """What was committed at the last kill, what kills cost, and what was found wrong."""

    def __init__(self):
        self.before = {}
        self.parts = 0
        self.kills = 0
        self.problems = []

    def note_run(self, job, killed):
        """After a run: what is there now against what was there before it."""
        now, parts = job.results()
        for (stage, name), inode in self.before.items():
            if (stage, name) in now and now[stage, name] != inode:
                self.problems.append(f"{stage}/{name} was committed and made again")
            elif (stage, name) not in now and not job.may_go(stage):
                self.problems.append(f"{stage}/{name} was committed and is gone")
        if killed:
            self.parts += parts
            self.kills += 1
        self.before = now


def round_of(job, rng, options, reference, moments, books, counts):
    """Kills at the moments, one after the other, then runs to the end. Returns the number of kills."""
    durations, expected = reference
    kills, books.before = 0, {}
    for moment in [*moments, None]:
        how = signal.SIGKILL if not options.gentle else rng.choice([signal.SIGTERM, signal.SIGINT])
        status, text = attempt(job, moment, rng.random(), durations.get(moment, 0.0), how)
        killed = status == -how or (options.gentle and status == 130)  # -how: before it listens to signals
        books.note_run(job, killed)
        if not killed:
            break
        kills += 1
        counts[moment] = counts.get(moment, 0) + 1
    if status != 0:
        books.problems.append(f"exit status {status} after kills at {moments[:kills]}: {text.strip()}")
    found = job.outputs()
    if differing := {name for name in {*expected, *found} if expected.get(name) != found.get(name)}:
        books.problems.append(f"after kills at {moments[:kills]}: differing or left over: {sorted(differing)}")
    if status != 0 or differing:
        shutil.copytree(job.directory, job.directory.parent / f"failed-{len(books.problems)}", dirs_exist_ok=True)
    job.clear()
    return kills


def drawn(rng, order, plan):
    """The moments of a round: the next of the plan, in the order in which the job comes to them."""
    if len(plan) < KILLS_PER_ROUND:
        plan += rng.sample(order, len(order))
    taken = [plan.pop() for _ in range(KILLS_PER_ROUND)]
    starts = [moment for moment in taken if moment == START]
    moments = sorted((moment for moment in taken if moment != START), key=order.index)
    for start in starts:
        moments.insert(rng.randrange(len(moments) + 1), start)
    return moments


def measure(options, work):
    directory = work / f"kills-{options.points}-{os.getpid()}"
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir(parents=True)
    job = Job(options, directory)
    durations, chunks, total = undisturbed(job)
    expected = job.outputs()
    print(f"undisturbed: {total:.2f} s, {len(durations)} stages, {sum(chunks.values())} chunks in "
          f"{len(chunks)} stages", flush=True)
    if unexpected := set(expected) - {"mesh.ply", "mesh.png", "mesh.report.json", "mesh.report.html"}:
        sys.exit(f"the undisturbed run leaves {sorted(unexpected)}")
    job.clear()
    order = [START, *durations, REMOVAL]
    durations.update({START: 0.1, REMOVAL: 0.02})
    rng = random.Random(options.seed)
    books, counts, plan = Books(), {}, []
    kills = rounds = 0
    began = time.monotonic()
    while kills < options.kills:
        kills += round_of(job, rng, options, (durations, expected), drawn(rng, order, plan), books, counts)
        rounds += 1
        if rounds % 5 == 0:
            print(f"  {kills} kills in {rounds} rounds, {time.monotonic() - began:.0f} s, "
                  f"{len(books.problems)} problems", flush=True)
    shutil.rmtree(directory)
    return {"points": options.points, "signal": "SIGTERM, SIGINT" if options.gentle else "SIGKILL", "kills": kills,
            "rounds": rounds, "seconds_undisturbed": total, "seconds": time.monotonic() - began,
            "moments": counts, "chunks_needed": sum(chunks.values()), "parts_lost": books.parts,
            "repeated_at_most": books.parts + THREADS * books.kills, "problems": books.problems}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--points", type=int)
    parser.add_argument("--gentle", action="store_true", help="SIGTERM and SIGINT instead of SIGKILL")
    parser.add_argument("--full", action="store_true", help=f"{FULL_POINTS:,} points instead of {POINTS:,}")
    harness.add_common_options(parser)
    options = parser.parse_args()
    options.points = options.points or (FULL_POINTS if options.full else POINTS)
    row = measure(options, harness.prepare(options))
    name = "kills_gentle" if options.gentle else "kills"
    harness.write_results(options, name, [row])
    print(f"{row['kills']} kills in {row['rounds']} rounds; at {row['moments']}")
    print(f"chunks of one run {row['chunks_needed']:,}, of all rounds {row['chunks_needed'] * row['rounds']:,}; part files "
          f"lost {row['parts_lost']:,}, computed again at most {row['repeated_at_most']:,}")
    for problem in row["problems"]:
        print("PROBLEM: " + problem)
    return 1 if row["problems"] else 0


if __name__ == "__main__":
    sys.exit(main())
