"""A job that goes through every stage in a second: raw scans with poses, outliers, merging, smoothing, thinning,
estimated and propagated normals, two ball radii, holes, a mesh, a picture and a report. What kills, damage and limits
are tried on."""
import hashlib
import json
import math
import os
import re
import signal
import subprocess
import time

import trial

POINTS, CHUNKS = 1_500, 16
JOB = """[input]
files = ["scan_*.ply"]
poses = "scan.conf"
[partition]
memory = "1GiB"
chunk_points = {chunk}
[cleaning]
outlier_sigma = 6.0
merge_tolerance = {merge:.6g}
smooth_radius = {smooth:.6g}
thin_to_spacing = {thin:.6g}
[normals]
source = "estimate"
orientation = "propagate"
[reconstruct]
ball_radii = [{radius:.6g}, {radius2:.6g}]
[fill]
neighborhood = 1.5
[output]
mesh = "mesh.ply"
report = "mesh.report.json"
picture = "mesh.png"
[run]
threads = 2
work_dir = "work"
"""
COMMAND = ["run", "job.toml", "--progress", "none"]
OUTPUTS = {"mesh.ply", "mesh.tiles", "mesh.png", "mesh.report.json", "mesh.report.html"}
TILES = ["--set", "output.tiles=true"]
MAP_TILES = [*TILES, "--set", "output.tile_size=0.25"]
START, REMOVAL = "start", "removal"
LOG_STAGE = re.compile(r" info (.+): (?:begins|ends)\b")


def write(program, directory, points=POINTS, seed=1, radius=1.0):
    """Scans, poses and job file; with another seed another job, with another radius an earlier version of it."""
    trial.succeed([program, "generate", "torus", "--points", str(points), "--noise", "0.2", "--scans", "3", "--seed",
                   str(seed), "--misregistration", "0.5", "--separate", "-o", "scan.ply"], directory)
    gap = math.sqrt(4 * math.pi ** 2 * 0.4 / points)
    (directory / "job.toml").write_text(JOB.format(
        chunk=points // CHUNKS, merge=0.1 * gap, smooth=3 * gap, thin=0.4 * gap, radius=0.8 * gap * radius,
        radius2=1.3 * gap * radius))
    return sorted(os.listdir(directory))


def outputs_in(directory):
    """{name: digest} of the outputs that are there, tiles one by one, the report by what does not change."""
    found = {}
    for name in sorted(OUTPUTS):
        path = directory / name
        if path.is_dir():
            found.update({f"{name}/{tile}": content for tile, content in trial.contents(path).items()})
        elif path.name.endswith(".html") and path.exists():
            found[name] = "there"
        elif path.name.endswith(".json") and path.exists():
            found[name] = unchanging(json.loads(path.read_text()))
        elif path.exists():
            found[name] = trial.digest(path)
    return found


def not_whole(found, expected):
    """Of the outputs found, those that are something else than expected; part files do not count."""
    return [name for name in found if found[name] != expected.get(name) and not name.split("/")[-1].startswith(".")]


def unchanging(report):
    """What of a report is the same for every run."""
    holes = [{key: value for key, value in hole.items() if key != "seconds"} for hole in report["holes"]]
    kept = {key: report[key] for key in ("input", "partition", "radii", "mesh")}
    return hashlib.sha256(json.dumps([kept, holes], sort_keys=True).encode()).hexdigest()


def log_text(directory):
    """Of the job whose work directory there is called "work"; empty where there is none."""
    try:
        return (directory / "work" / "orbweave.log").read_text(errors="replace")
    except OSError:
        return ""


class Undisturbed:
    """What a job gives that nothing disturbs, and how long its stages take, by name and in their order."""

    def __init__(self, program, directory, arguments=()):
        trial.succeed([program, *COMMAND, *arguments], directory)
        self.outputs = outputs_in(directory)
        report = json.loads((directory / "mesh.report.json").read_text())
        self.seconds = {START: 0.08, **{stage["name"]: stage["seconds"] for stage in report["stages"]}, REMOVAL: 0.02}
        trial.clear(directory, {name for name in os.listdir(directory)} - OUTPUTS)


def start(program, directory, arguments=()):
    return subprocess.Popen([program, *COMMAND, *arguments], cwd=directory, stdin=subprocess.DEVNULL,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=trial.ENVIRONMENT)


def has_come(directory, moment, begun):
    """Whether the run that began when the log had that length is at the moment."""
    if moment == START:
        return True
    if moment == REMOVAL:
        return (directory / "work" / "ended.json").exists()
    return moment in LOG_STAGE.findall(log_text(directory)[begun:])


def disturbed(program, directory, moment, delay, disturb, arguments=()):
    """A run; `disturb(process)` is called so many seconds after it came to the moment, unless it ended before.
    Returns its end, and whether it was disturbed."""
    begun, began = len(log_text(directory)), time.monotonic()
    process = start(program, directory, arguments)
    try:
        trial.wait_until(lambda: process.poll() is not None or has_come(directory, moment, begun), trial.WALL_SECONDS)
        trial.wait_until(lambda: process.poll() is not None, delay)
        reached = process.poll() is None
        if reached:
            disturb(process)
        out, err = process.communicate(timeout=trial.WALL_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        out, err = process.communicate()
        return trial.Ended(process.args, process.returncode, out, err, time.monotonic() - began, 0, True), True
    return trial.Ended(process.args, process.returncode, out, err, 0.0, 0, False), reached


def killed(program, directory, moment, delay, arguments=()):
    """A run that SIGKILL ends there; whether it did."""
    ended, _ = disturbed(program, directory, moment, delay, subprocess.Popen.kill, arguments)
    return ended.status == -signal.SIGKILL
