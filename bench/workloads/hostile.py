#!/usr/bin/env python3
"""CPU time per point on clouds that break plans, over their number of points: a density that changes by a factor of a
hundred, a tenth of stray points, points without a surface, sheets closer to each other than their points.

  patch      a sphere, 30% of the points in a patch about a halo wide
  spot       a sphere, 30% of the points in a ball of 1e-4 of the radius
  noise      points all over a cube, with normals of any direction
  layers     sheets of 10 x 10 points, a fiftieth of the points' distance apart, that face up and down in turn
  linenoise  a dense thread, and a tenth of the points anywhere about it
  lines      a wavy sheet in scan lines, ten times as far apart as the points on them

Each is reconstructed with automatic radii at each number of points, by all threads. The exit status is 1 where the CPU
microseconds per point of one kind differ by more than the factor 2 between sizes. Jobs that were refused within a second
do not count; those that end with status 3 later (no triangle can be formed) do. The CPU time of the start of the program,
measured with ten points, is taken off.

usage: bench/workloads/hostile.py [--points 20000,80000,320000,1280000] [--kinds patch,...] [--repeats N]
                                  [--limit SECONDS]
"""
import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
import numpy  # noqa: E402

POINTS = (20_000, 80_000, 320_000, 1_280_000)
GOLDEN_ANGLE = 2.399963229728653
MOST_RATIO = 2.0  # between sizes
REFUSAL_SECONDS = 1.0
COLUMNS = ["kind", "points", "status", "wall_seconds", "cpu_seconds", "cpu_us_per_point", "triangles",
           "peak_memory_mib"]


def sphere(points):
    i = numpy.arange(points)
    z = 1 - 2 * (i + 0.5) / points
    ring = numpy.sqrt(1 - z * z)
    places = numpy.stack([ring * numpy.cos(i * GOLDEN_ANGLE), ring * numpy.sin(i * GOLDEN_ANGLE), z], axis=1)
    return places, places


def joined(first, second):
    return tuple(numpy.concatenate(both) for both in zip(first, second))


def patch(points, random):
    crowd = 3 * points // 10
    places = numpy.concatenate([numpy.ones((crowd, 1)), random.normal(0, 0.01, (crowd, 2))], axis=1)
    places /= numpy.linalg.norm(places, axis=1, keepdims=True)
    return joined(sphere(points - crowd), (places, places))


def spot(points, random):
    crowd = 3 * points // 10
    places = random.normal(0, 1e-4, (crowd, 3)) + [1, 0, 0]
    return joined(sphere(points - crowd), (places, numpy.tile([1.0, 0, 0], (crowd, 1))))


def noise(points, random):
    normals = random.normal(0, 1, (points, 3))
    return random.random((points, 3)), normals / numpy.linalg.norm(normals, axis=1, keepdims=True)


def layers(points, _):
    i = numpy.arange(points)
    level = i // 100
    places = numpy.stack([i % 10, i // 10 % 10, 0.02 * level], axis=1).astype(float)
    up = numpy.zeros((points, 3))
    up[:, 2] = numpy.where(level % 2, 1.0, -1.0)
    return places, up


def linenoise(points, random):
    i = numpy.arange(points)
    thread = numpy.stack([i * 1e-2, *random.normal(0, 1e-3, (2, points))], axis=1)
    stray = random.random((points, 3)) * [points * 1e-2, 1, 1]
    return numpy.where((i % 10 == 0)[:, None], stray, thread), numpy.tile([0.0, 0, 1], (points, 1))


def lines(points, random):
    on_line = int((10 * points) ** 0.5)
    x, y = numpy.meshgrid(numpy.arange(on_line), 10.0 * numpy.arange(points // on_line))
    x = x + random.uniform(-0.5, 0.5, (len(x), 1)) + random.normal(0, 0.1, x.shape)
    y = y + random.normal(0, 0.1, y.shape)
    turn = (9 * x + 4 * y) / on_line
    slope = 0.03 * numpy.cos(turn)
    normals = numpy.stack([-9 * slope, -4 * slope, numpy.ones_like(x)], axis=-1).reshape(-1, 3)
    places = numpy.stack([x, y, 0.03 * on_line * numpy.sin(turn)], axis=-1).reshape(-1, 3)
    return places, normals / numpy.linalg.norm(normals, axis=1, keepdims=True)


KINDS = {made.__name__: made for made in (patch, spot, noise, layers, linenoise, lines)}


def write_ply(path, places, normals):
    names = "".join(f"property double {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n{names}end_header\n"
    with open(path, "wb") as file:
        file.write(header.encode())
        numpy.concatenate([places, normals], axis=1).astype("<f8").tofile(file)


def timed_job(options, cloud, work):
    """Status, seconds and facts of one job; a status of None: it was ended after --limit seconds."""
    mesh = work / "hostile.ply"
    report = work / "hostile.json"
    report.unlink(missing_ok=True)
    with tempfile.NamedTemporaryFile("r", suffix=".time") as measured:
        words = ["/usr/bin/time", "-q", "-f", "%e %U %S %M", "-o", measured.name, "timeout", str(options.limit),
                 options.program, "reconstruct", cloud, "-o", mesh, "--report", report, "--work-dir",
                 work / "hostile.work", "--memory", options.memory, "--progress", "none"]
        status = subprocess.run([str(word) for word in words], stdin=subprocess.DEVNULL, capture_output=True,
                                check=False).returncode
        wall, user, system, peak_kib = measured.read().split()[-4:]
    shutil.rmtree(work / "hostile.work", ignore_errors=True)
    triangles = json.loads(report.read_text())["mesh"]["triangles"] if report.exists() else 0
    return {"status": None if status == 124 else status, "wall_seconds": float(wall),
            "cpu_seconds": float(user) + float(system), "triangles": triangles, "peak_memory_mib": int(peak_kib) / 1024}


def start_seconds(options, work):
    """CPU seconds of the program with hardly a point."""
    cloud = work / "hostile-start.ply"
    write_ply(cloud, *sphere(10))
    return statistics.median(timed_job(options, cloud, work)["cpu_seconds"] for _ in range(5))


def row_of(options, work, kind, points, start):
    cloud = work / f"hostile-{kind}-{points}.ply"
    write_ply(cloud, *KINDS[kind](points, numpy.random.default_rng(1)))
    runs = sorted((timed_job(options, cloud, work) for _ in range(options.repeats)), key=lambda run: run["cpu_seconds"])
    cloud.unlink()
    middle = runs[(len(runs) - 1) // 2]
    return {"kind": kind, "points": points, **middle,
            "cpu_us_per_point": 1e6 * max(middle["cpu_seconds"] - start, 0) / points}


def verdict(rows):
    """The factor between the sizes of one kind, and whether it is right. A job that was refused at once has no cost."""
    costs = [row["cpu_us_per_point"] for row in rows if row["status"] == 0 or row["wall_seconds"] > REFUSAL_SECONDS]
    ratio = max(costs) / min(costs) if costs else 1.0
    return ratio, all(row["status"] in (0, 3) for row in rows) and ratio <= MOST_RATIO


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    harness.add_common_options(parser)
    parser.add_argument("--points", default=",".join(map(str, POINTS)))
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--limit", type=float, default=300, help="seconds after which a job is ended")
    parser.add_argument("--memory", default="2GiB")
    options = parser.parse_args()
    work = harness.prepare(options)
    start = start_seconds(options, work)
    rows, right = [], True
    for kind in options.kinds.split(","):
        of_kind = [row_of(options, work, kind, int(points), start) for points in options.points.split(",")]
        ratio, within = verdict(of_kind)
        right &= within
        rows += of_kind
        print(harness.table(of_kind, COLUMNS))
        print(f"{kind}: {'within' if within else 'NOT within'} the factor {MOST_RATIO:g} between sizes: {ratio:.2f}\n")
    harness.write_results(options, "hostile", rows, {"start_cpu_seconds": start})
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())
