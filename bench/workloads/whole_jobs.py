"""What the workloads of whole jobs share (job, threads, chunks, ranks, simulate, memory, compression): clouds of any size,
jobs with their disk watched, samples that outlive an interruption, targets. A measurement that was interrupted goes on with the
samples it has; --fresh measures all of them anew."""
import hashlib
import itertools
import json
import math
import mmap
import os
import pathlib
import re
import shutil
import signal
import sys
import tempfile
import threading

import harness
import stage_kinds

RADIUS_PER_SPACING = 1.3
CLOUD_BYTES = 48  # position and normal in double
# Most of a job's disk per point: points and chunk meshes in the work directory, the mesh (docs/disk.md).
JOB_BYTES = 170
UNITS = {"": 1, "KiB": 1 << 10, "MiB": 1 << 20, "GiB": 1 << 30, "TiB": 1 << 40}


def parse_bytes(text):
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([KMGT]iB|)", text)
    if not match:
        sys.exit(f"\"{text}\" is no size; wanted is a number with KiB, MiB, GiB or TiB")
    return int(float(match.group(1)) * UNITS[match.group(2)])


def numbers(text):
    """"1e6,10M" -> [1000000, 10000000]"""
    factors = {"k": 1_000, "M": 1_000_000, "G": 1_000_000_000}
    return [int(float(word.rstrip("kMG")) * factors.get(word[-1], 1)) for word in text.split(",")]


def add_options(parser, repeats=3):
    parser.add_argument("--points", type=numbers, help="instead of the workload's own, e.g. 1M or 1M,10M")
    parser.add_argument("--repeats", type=int, default=repeats)
    parser.add_argument("--memory", help="budget of the jobs, e.g. 2GiB")
    parser.add_argument("--full", action="store_true", help="the sizes that the targets are given for")
    parser.add_argument("--clouds", type=pathlib.Path, default=os.environ.get("ORBWEAVE_CLOUD_DIR"),
                        help="directory with ready clouds t<points>.ply, as written by \"orbweave generate torus\" "
                        "(default: ORBWEAVE_CLOUD_DIR); others are generated, and removed at the end")
    parser.add_argument("--keep-clouds", action="store_true", help="those that were generated stay in --work")
    parser.add_argument("--fresh", action="store_true", help="forget the samples of an interrupted measurement")
    harness.add_common_options(parser)


def prepared(options):
    """Makes the directories; an end by SIGTERM cleans up like any other."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    return harness.prepare(options)


def radius(points):
    return RADIUS_PER_SPACING * harness.spacing("torus", points)


def require_disk(folder, wanted, what):
    free = shutil.disk_usage(folder).free
    if wanted > free:
        sys.exit(f"{what} takes up to {wanted / 1e9:.1f} GB in {folder}, where {free / 1e9:.1f} GB are free: "
                 "choose another --work or fewer --points")


class Clouds:
    """Tori of oriented points; in a with statement, removes those that it made."""

    def __init__(self, options, work):
        self.options, self.work, self.made = options, work, []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if not self.options.keep_clouds:
            for path in self.made:
                path.unlink(missing_ok=True)

    def torus(self, points, order="ordered"):
        """As generated, ring by ring ("ordered"), or with neighbours far apart in the file ("shuffled")."""
        ordered = self._ordered(points)
        if order == "ordered":
            return ordered
        shuffled = self.work / f"torus-{points}-shuffled.ply"
        if not shuffled.exists() or shuffled.stat().st_mtime < ordered.stat().st_mtime:
            require_disk(self.work, points * CLOUD_BYTES, f"a shuffled cloud of {points:,} points")
            shuffle(ordered, shuffled, points)
        self.made.append(shuffled)
        return shuffled

    def _ordered(self, points):
        ready = self.options.clouds and self.options.clouds / f"t{points}.ply"
        if ready and ready.exists():
            return ready
        path = self.work / f"torus-{points}-noise0.ply"
        if not path.exists():
            require_disk(self.work, points * CLOUD_BYTES, f"a cloud of {points:,} points")
        self.made.append(path)
        return harness.generated(self.options.program, self.work, "torus", points)


def shuffle(source, target, points):
    """Row i of the target is row i * step mod points of the source: all rows, consecutive ones far apart, the same
    on every machine."""
    step = int(points * (math.sqrt(5) - 1) / 2) | 1
    while math.gcd(step, points) != 1:
        step += 2
    part = target.with_suffix(".part")
    with open(source, "rb") as stream, open(part, "wb") as out, \
            mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as rows:
        begin = len(rows) - points * CLOUD_BYTES
        out.write(rows[:begin])
        for first in range(0, points, 1 << 18):
            places = (begin + i * step % points * CLOUD_BYTES for i in range(first, min(first + (1 << 18), points)))
            out.write(b"".join([rows[place:place + CLOUD_BYTES] for place in places]))
    part.rename(target)


class _DiskWatch:
    """Most that a directory held, looked at a few times a second. A file without a name is not seen."""

    def __init__(self, folder):
        self.folder, self.peak_bytes = folder, 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()

    def _watch(self):
        while not self._over.wait(0.2):
            held = 0
            for folder, _, names in os.walk(self.folder):
                for name in names:
                    try:
                        held += os.lstat(os.path.join(folder, name)).st_blocks * 512
                    except FileNotFoundError:
                        continue
            self.peak_bytes = max(self.peak_bytes, held)


def sha256(path):
    digest = hashlib.sha256()
    with open(path, "rb") as stream:
        while block := stream.read(1 << 22):
            digest.update(block)
    return digest.hexdigest()


KEPT = ("input", "partition", "radii", "mesh", "stages", "peak_memory_bytes", "predicted", "measured", "ranks", "traffic",
        "options")


def job(options, work, cloud, points, *arguments, launcher=()):
    """A callable that runs the job once, in a directory of its own that goes with it. Its result has the digest of
    the mesh, the most that was seen on the disk, and what KEPT names of the report."""
    def call():
        require_disk(work, points * JOB_BYTES, f"a job of {points:,} points")
        with tempfile.TemporaryDirectory(prefix="job-", dir=work) as folder:
            mesh = pathlib.Path(folder) / "mesh.ply"
            with _DiskWatch(folder) as watch:
                result = harness.reconstruct(options.program, cloud, mesh,
                                             ["--radii", repr(radius(points)), *arguments], launcher)
            result.update(sha256=sha256(mesh), disk_seen_bytes=watch.peak_bytes)
            result["report"] = {key: value for key, value in result["report"].items() if key in KEPT}
            return result
    return call


class Samples:
    """Results of single runs, kept in <out>/<name>.samples.json until the measurement is complete."""

    def __init__(self, options, name):
        self.path = pathlib.Path(options.out) / f"{name}.samples.json"
        facts = os.stat(options.program)
        self.program = f"{facts.st_size} bytes of {facts.st_mtime_ns}"
        self.known = {}
        if self.path.exists() and not options.fresh:
            self.known = json.loads(self.path.read_text(encoding="utf-8"))

    def kept(self, key, call):
        """`call`, but not again for results that are known."""
        turns = itertools.count(1)

        def once():
            name = f"{key}, run {next(turns)}, program {self.program}"
            if name not in self.known:
                self.known[name] = call()
                part = self.path.with_suffix(".part")
                part.write_text(json.dumps(self.known), encoding="utf-8")
                part.rename(self.path)
            return self.known[name]
        return once

    def forget(self):
        self.path.unlink(missing_ok=True)


def alternate(runs, repeats):
    """harness.alternate() with as many repeats as {name: number} says; the fewer runs lie amid the others."""
    rounds = max(repeats.values())
    results = {name: [] for name in runs}
    for turn in range(rounds):
        for name, call in runs.items():
            done = int(turn * repeats[name] / rounds + 0.5)
            if int((turn + 1) * repeats[name] / rounds + 0.5) > done:
                print(f"  {name}, run {done + 1} of {repeats[name]}", flush=True)
                results[name].append(call())
    return results


def closed(report):
    """What a closed mesh with consistent counts must be."""
    mesh = report["mesh"]
    expected = 2 * mesh["vertices"] - 2 * mesh["euler_characteristic"]
    return mesh["watertight"] and mesh["boundary_edges"] == 0 and mesh["triangles"] == expected


def row_of(variant, points, results):
    wall = harness.spread([r["wall_seconds"] for r in results])
    return {"variant": variant, "points": points, "seconds": wall["median"],
            "relative_half_range": wall["relative_half_range"], "points_per_second": points / wall["median"],
            "cpu_seconds": harness.spread([cpu_seconds(r) for r in results])["median"],
            "peak_memory_mib": max(r["peak_memory_bytes"] for r in results) / (1 << 20),
            "chunks": results[0]["report"]["partition"]["chunks"],
            "closed": all(closed(r["report"]) for r in results),
            "sha256": results[0]["sha256"], "one_sha256": len({r["sha256"] for r in results}) == 1, "wall": wall}


def cpu_seconds(result):
    return result["user_seconds"] + result["system_seconds"]


def outside_seconds(result):
    return result["wall_seconds"] - sum(s["seconds"] for s in result["report"]["stages"])


def stage_medians(results, measure="seconds"):
    """{stage: median}, in the order of the stages; what lies between them comes last."""
    names = list(harness.stages(results[0]["report"]))
    medians = {name: harness.spread([harness.stages(r["report"])[name][measure] for r in results])["median"]
               for name in names}
    if measure == "seconds":
        medians[stage_kinds.OUTSIDE] = harness.spread([outside_seconds(r) for r in results])["median"]
    return medians


def one_digest(rows):
    """Whether rows of the same points all have the same bytes."""
    digests = {}
    for row in rows:
        digests.setdefault(row["points"], set()).add(row["sha256"])
    return all(len(found) == 1 for found in digests.values()) and all(row["one_sha256"] for row in rows)


def finish(options, name, rows, targets, extra, samples):
    """Prints the targets, {words: (value, holds, wanted)}, writes the results; the exit status."""
    shown = [{"target": words, "value": value, "wanted": wanted, "holds": "yes" if holds else "NO"}
             for words, (value, holds, wanted) in targets.items()]
    print("\n" + harness.table(shown, ["target", "value", "wanted", "holds"]))
    harness.write_results(options, name, rows, {"targets": shown, **extra})
    samples.forget()
    return 0 if all(holds for _, holds, _ in targets.values()) else 1
