#!/usr/bin/env python3
"""What compressing the work directory (run.compress) saves and costs: bytes per point of what the points and the
meshes of the chunks take there, the most that a job holds on disk, and seconds, with and without, alternating.

The exit status is 1 where the mesh is not the same, byte for byte, or the job does not hold less.

usage: bench/workloads/compression.py [--points N] [--full] [--repeats N] [--memory 1GiB]      --full: 10M points
"""
import argparse
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402
import harness  # noqa: E402
import whole_jobs  # noqa: E402

COLUMNS = ["variant", "points", "seconds", "relative_half_range", "cpu_seconds", "points_bytes", "mesh_bytes",
           "disk_bytes", "peak_memory_mib"]


def bytes_per_point(results, points):
    """Written by the stages that fill the store, and the most that the job held."""
    stages = harness.stages(results[0]["report"])
    disk = statistics.median(r["report"]["measured"]["disk_bytes"] for r in results)
    return {"points_bytes": stages["sort"]["bytes_written"] / points,
            "mesh_bytes": stages["reconstruct"]["bytes_written"] / points, "disk_bytes": disk / points}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    whole_jobs.add_options(parser)
    options = parser.parse_args()
    points = (options.points or [10_000_000 if options.full else 1_000_000])[0]
    memory = options.memory or "1GiB"
    work = whole_jobs.prepared(options)
    samples = whole_jobs.Samples(options, "compression")
    runs = {}
    with whole_jobs.Clouds(options, work) as clouds:
        for name, words in {"plain": (), "compressed": ("--compress",)}.items():
            job = whole_jobs.job(options, work, clouds.torus(points), points, "--memory", memory, *words)
            runs[name] = samples.kept(f"{name}, {points} points, {memory}", job)
        results = whole_jobs.alternate(runs, {name: options.repeats for name in runs})
    rows = [{**whole_jobs.row_of(name, points, results[name]), **bytes_per_point(results[name], points)}
            for name in runs]
    print("\n" + harness.table(rows, COLUMNS))
    plain, compressed = rows
    share = compressed["disk_bytes"] / plain["disk_bytes"]
    same = whole_jobs.one_digest(rows)
    targets = {"same bytes with and without": (same, same, "True"),
               "most on disk, compressed over plain": (share, share < 1.0, "under 1"),
               "CPU seconds, compressed over plain": (compressed["cpu_seconds"] / plain["cpu_seconds"], True,
                                                      "reported")}
    return whole_jobs.finish(options, "compression", rows, targets, {}, samples)


if __name__ == "__main__":
    sys.exit(main())
