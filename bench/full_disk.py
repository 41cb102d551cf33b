#!/usr/bin/python3
"""A disk that fills up while a job runs, at every moment of it.

A job is run once in a directory in memory (tmpfs) to learn the most that it holds there. Then again and again: as soon
as its points are being binned, when the check of the room is over, the directory is made so small that 10% to 95% of
that fit. Every run has to end with exit status 4 and a message that names a file and the system's reason; then the
directory is enlarged, and the same command has to end with the same bytes, without leftovers.

Needs the right to mount. The exit status is 1 where a run ends otherwise, 77 where mounting is not allowed.

usage: bench/full_disk.py [--points N] [--raw] [--steps N]
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import harness

MEBIBYTE = 1 << 20


class Room:
    """A directory in memory that can be made smaller and larger."""

    def __init__(self, place, mebibytes):
        self.place = pathlib.Path(place)
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={mebibytes}m", "orbweave-room", str(place)],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print("SKIPPED: mounting is not allowed:", done.stderr.strip())
            sys.exit(77)

    def resize(self, size):
        subprocess.run(["mount", "-o", f"remount,size={max(size, 4096)}", str(self.place)],
                       capture_output=True, check=False)

    def remove(self):
        subprocess.run(["umount", str(self.place)], check=True)


def command(options, cloud, room, radius):
    words = [str(options.program), "reconstruct", str(cloud), "-o", str(room.place / "mesh.ply"), "--radii", str(radius),
             "--memory", "200MiB", "--work-dir", str(room.place / "work"), "--report", str(room.place / "report.json"),
             "--progress", "plain"]
    return words + (["--normals", "estimate"] if options.raw else [])


def used_bytes(place):
    return int(subprocess.run(["df", "--output=used", "-B1", str(place)], capture_output=True, text=True,
                              check=True).stdout.split()[-1])


def watch(process, room, action):
    """Calls `action` until the process has ended."""
    log = room.place / "work" / "orbweave.log"
    while process.poll() is None:
        action(log)
        time.sleep(0.002)
    return process.communicate()[1]


def run_whole(options, cloud, room, radius):
    most = 0

    def look(_):
        nonlocal most
        most = max(most, used_bytes(room.place))

    process = subprocess.Popen(command(options, cloud, room, radius), stderr=subprocess.PIPE, text=True)
    words = watch(process, room, look)
    if process.returncode != 0:
        sys.exit(words)
    report = json.loads((room.place / "report.json").read_text())
    return most, report, (room.place / "mesh.ply").read_bytes()


def run_into_full_disk(options, cloud, room, radius, limit):
    """Standard error and exit status of a run whose room shrinks once its points are being binned."""
    shrunk = False

    def shrink(log):
        nonlocal shrunk
        if shrunk or not log.exists() or "bin: begins" not in log.read_text(errors="replace"):
            return
        room.resize(limit)
        shrunk = True

    process = subprocess.Popen(command(options, cloud, room, radius), stderr=subprocess.PIPE, text=True)
    words = watch(process, room, shrink)
    return process.returncode, words.strip().splitlines()[-1] if words.strip() else ""


def last_stage(room):
    log = (room.place / "work" / "orbweave.log").read_text(errors="replace")
    begun = [line.split(" info ")[-1].split(":")[0] for line in log.splitlines() if ": begins" in line]
    return begun[-1] if begun else ""


def sweep(options, cloud, room, radius):
    plenty = 64 * MEBIBYTE + 1000 * options.points
    most, report, expected = run_whole(options, cloud, room, radius)
    (room.place / "mesh.ply").unlink()
    rows, failed = [], False
    for step in range(options.steps):
        share = 0.10 + 0.85 * step / max(1, options.steps - 1)
        status, words = run_into_full_disk(options, cloud, room, radius, int(share * most))
        stage = last_stage(room) if (room.place / "work").exists() else "all"
        parts = list(room.place.glob(".*.part"))
        room.resize(plenty)
        again = subprocess.run(command(options, cloud, room, radius), capture_output=True, text=True, check=False)
        same = again.returncode == 0 and (room.place / "mesh.ply").read_bytes() == expected
        good = status == 4 and str(room.place) in words and same and not parts and not (room.place / "work").exists()
        failed = failed or not good
        rows.append({"share": share, "status": status, "stage": stage, "message": words, "resumed": same, "good": good})
        print(f"{share:5.0%}  status {status}  in {stage:12}  {'same bytes' if same else 'OTHER BYTES'}  {words[-110:]}")
        (room.place / "mesh.ply").unlink(missing_ok=True)
    facts = {"most_bytes": most, "predicted": report["predicted"]["disk_bytes"],
             "measured": report["measured"]["disk_bytes"]}
    print(f"most held, as the file system says: {most}; measured by the run: {facts['measured']}; predicted: "
          f"{facts['predicted']}, {facts['predicted'] / most:.3f} of it")
    return rows, facts, failed or not most <= facts["predicted"] <= 1.25 * most


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=300_000)
    parser.add_argument("--raw", action="store_true", help="normals are estimated: passes over raw points, too")
    parser.add_argument("--steps", type=int, default=18)
    harness.add_common_options(parser)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="full-disk-", dir=harness.prepare(options)) as work:
        cloud = pathlib.Path(work) / "cloud.ply"
        harness.run([options.program, "generate", "torus", "--points", options.points, "-o", cloud])
        place = pathlib.Path(work) / "room"
        place.mkdir()
        room = Room(place, 64 + options.points // 1000)
        try:
            rows, facts, failed = sweep(options, cloud, room, 1.3 * harness.spacing("torus", options.points))
        finally:
            room.remove()
    harness.write_results(options, "full_disk_raw" if options.raw else "full_disk", rows,
                          {"points": options.points, **facts})
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
