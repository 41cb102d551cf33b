#!/usr/bin/python3
"""Whole jobs, from a file to a file, wall seconds and peak memory.

  open3d   the program against Open3D (load, ball pivoting, write) on 1M oriented points: at least 10 times
  budget   10M points with --memory 1GiB: at least 700,000 points/s, peak memory under the budget,
           the share of each stage
  threads  the same cloud with one thread and with two
  chunks   the same cloud as one chunk and as about 64

Programs alternate within a comparison; figures are medians. Open3D's seconds leave out the start of its
interpreter and the import; the program's are those of the whole process. The exit status is 1 when a
target is missed.

usage: bench/job.py [open3d|budget|threads|chunks]... [--points N] [--repeats N]
"""
import argparse
import hashlib
import json
import sys

import harness

BUDGET_BYTES = 1 << 30
PARTS = ("open3d", "budget", "threads", "chunks")


def smooth_cloud(options, work, points):
    cloud = harness.generated(options.program, work, options.shape, points)
    return cloud, 1.3 * harness.spacing(options.shape, points)


def sha256(path):
    digest = hashlib.sha256()
    with open(path, "rb") as stream:
        while block := stream.read(1 << 22):
            digest.update(block)
    return digest.hexdigest()


def job(options, work, cloud, radius, *arguments):
    """A callable that runs the job once and adds the digest of its mesh."""
    def call():
        mesh = work / "job.ply"
        result = harness.reconstruct(options.program, cloud, mesh,
                                     ["--radii", repr(radius), *arguments])
        result["sha256"] = sha256(mesh)
        return result
    return call


def open3d_job(work, cloud, radius):
    def call():
        words = [harness.PYTHON, harness.PEERS / "open3d_peer.py", cloud, "--radii", repr(radius),
                 "--no-counts", "--mesh", work / "open3d.ply"]
        measured = harness.run(words)
        facts = json.loads(measured["stdout"])
        seconds = facts["load_seconds"] + facts["kernel_seconds"] + facts["write_seconds"]
        return {**measured, "process_seconds": measured["wall_seconds"], "wall_seconds": seconds}
    return call


def row_of(part, variant, points, results):
    wall = harness.spread([r["wall_seconds"] for r in results])
    row = {"part": part, "variant": variant, "points": points, "seconds": wall["median"],
           "relative_half_range": wall["relative_half_range"],
           "points_per_second": points / wall["median"],
           "cpu_seconds": max(r["user_seconds"] + r["system_seconds"] for r in results),
           "peak_memory_mib": max(r["peak_memory_bytes"] for r in results) / (1 << 20), "wall": wall}
    if "report" in results[0]:
        row["chunks"] = results[0]["report"]["partition"]["chunks"]
        row["triangles"] = results[0]["report"]["mesh"]["triangles"]
        row["sha256"] = results[0]["sha256"]
        row["one_sha256"] = len({r["sha256"] for r in results}) == 1
    return row


def stage_rows(results):
    """Median seconds of each stage and its share of their sum."""
    names = list(harness.stages(results[0]["report"]))
    seconds = {name: harness.spread([harness.stages(r["report"])[name]["seconds"] for r in results])
               for name in names}
    total = sum(s["median"] for s in seconds.values()) or 1.0
    return [{"stage": name, "seconds": s["median"], "share": s["median"] / total}
            for name, s in seconds.items()]


def compare(options, work, part, points, runs, cloud_points=None):
    print(f"\n{part}: {' against '.join(runs)}, {points:,} points", flush=True)
    results = harness.alternate(runs, options.repeats)
    rows = [row_of(part, name, cloud_points or points, taken) for name, taken in results.items()]
    return rows, results


def part_open3d(options, work):
    points = options.points or 1_000_000
    cloud, radius = smooth_cloud(options, work, points)
    rows, _ = compare(options, work, "open3d", points,
                      {"orbweave": job(options, work, cloud, radius),
                       "Open3D": open3d_job(work, cloud, radius)})
    ratio = rows[1]["seconds"] / rows[0]["seconds"]
    return rows, {"times Open3D": (ratio, ratio >= 10.0, "at least 10")}, {}


def part_budget(options, work):
    points = options.points or 10_000_000
    cloud, radius = smooth_cloud(options, work, points)
    rows, results = compare(options, work, "budget", points,
                            {"1 GiB": job(options, work, cloud, radius, "--memory", "1GiB")})
    rate, peak = rows[0]["points_per_second"], rows[0]["peak_memory_mib"]
    shares = stage_rows(results["1 GiB"])
    print(harness.table(shares, ["stage", "seconds", "share"]))
    return rows, {"points per second": (rate, rate >= 700_000, "at least 700,000"),
                  "peak MiB": (peak, peak * (1 << 20) < BUDGET_BYTES, "under 1,024")}, {"stages": shares}


def part_threads(options, work):
    points = options.points or 2_000_000
    cloud, radius = smooth_cloud(options, work, points)
    runs = {f"{n} threads": job(options, work, cloud, radius, "--threads", n) for n in (1, 2)}
    rows, _ = compare(options, work, "threads", points, runs)
    ratio = rows[0]["seconds"] / rows[1]["seconds"]
    same = rows[0]["sha256"] == rows[1]["sha256"]
    return rows, {"speed-up, 2 threads over 1": (ratio, True, "reported"),
                  "same bytes": (same, same, "yes")}, {}


def part_chunks(options, work):
    points = options.points or 2_000_000
    cloud, radius = smooth_cloud(options, work, points)
    limits = {"one chunk": 10 ** 12, "many chunks": options.chunk_points or points // 40}
    runs = {name: job(options, work, cloud, radius, "--chunk-points", limit)
            for name, limit in limits.items()}
    rows, _ = compare(options, work, "chunks", points, runs)
    ratio = rows[1]["seconds"] / rows[0]["seconds"]
    same = rows[0]["sha256"] == rows[1]["sha256"]
    return rows, {f"cost of {rows[1]['chunks']} chunks over {rows[0]['chunks']}": (ratio, True, "reported"),
                  "same bytes": (same, same, "yes")}, {}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; none: all")
    parser.add_argument("--points", type=int, help="instead of each part's own number")
    parser.add_argument("--chunk-points", type=int, help="of the many chunks (default: points / 40)")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--shape", default="torus", choices=sorted(harness.AREAS))
    harness.add_common_options(parser)
    options = parser.parse_args()
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"unknown part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    work = harness.prepare(options)
    rows, targets, extra = [], {}, {}
    for part in options.parts or PARTS:
        part_rows, part_targets, part_extra = globals()[f"part_{part}"](options, work)
        rows += part_rows
        targets.update({f"{part}: {name}": value for name, value in part_targets.items()})
        extra.update(part_extra)
    print("\n" + harness.table(rows, ["part", "variant", "points", "seconds", "relative_half_range",
                                      "points_per_second", "cpu_seconds", "peak_memory_mib", "chunks"]))
    shown = [{"target": name, "value": value, "wanted": wanted, "holds": "yes" if holds else "NO"}
             for name, (value, holds, wanted) in targets.items()]
    print("\n" + harness.table(shown, ["target", "value", "wanted", "holds"]))
    harness.write_results(options, "job", rows, {"targets": shown, **extra})
    return 0 if all(holds for _, holds, _ in targets.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
