#!/usr/bin/env python3
"""What partition costs: the same cloud as one chunk, as about 64 and as about 512.

By one thread, as one chunk is work for one: what is compared is what is computed. 64 chunks take at most 1.15 times
as long as one. Exit status 1 where the target is missed.

usage: bench/workloads/chunks.py [--points N] [--full] [--repeats N] [--memory 8GiB]      --full: 10M points
"""
import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("matplotlib")

import harness  # noqa: E402
import plots  # noqa: E402
import whole_jobs  # noqa: E402

WANTED = (1, 64, 512)
LEAST_POINTS = 500  # a chunk of fewer is mostly halo, in any job
MOST_TIMES = 1.15
CLOSE = 0.05  # of the wanted number of chunks: no other is looked for
COLUMNS = ["variant", "points", "chunks", "chunk_points", "seconds", "relative_half_range", "cpu_seconds",
           "reconstruct_seconds", "times_one_chunk", "peak_memory_mib"]


def chunks_with(options, job_file, chunk_points):
    words = [options.program, "plan", job_file, "--json", "--set", f"partition.chunk_points={chunk_points}"]
    return json.loads(harness.run(words)["stdout"])["partition"]["chunks"]


def chunk_points_for(options, work, cloud, points, wanted):
    """The limit whose number of chunks is closest to `wanted`, found by planning with at most ten. The octree halves
    its boxes, so the number jumps."""
    if wanted == 1:
        return points
    job_file = work / "chunks.toml"
    job_file.write_text(f"[input]\nfiles = [{json.dumps(str(pathlib.Path(cloud).resolve()))}]\n"
                        f"[reconstruct]\nball_radii = [{whole_jobs.radius(points)!r}]\n"
                        f"[output]\nmesh = {json.dumps(str(work / 'chunks.ply'))}\n", encoding="utf-8")
    low, high, found = LEAST_POINTS, points, {}
    for _ in range(10):
        middle = int((low * high) ** 0.5)
        found[middle] = chunks_with(options, job_file, middle)
        if abs(found[middle] - wanted) <= CLOSE * wanted:
            break
        low, high = (middle, high) if found[middle] > wanted else (low, middle)
    job_file.unlink()
    return min(found, key=lambda limit: abs(found[limit] - wanted))


def measured(options, work, samples, cloud, points, limits):
    runs = {}
    for wanted, limit in limits.items():
        job = whole_jobs.job(options, work, cloud, points, "--threads", 1, "--memory", options.memory or "8GiB",
                             "--chunk-points", limit)
        runs[f"about {wanted}"] = samples.kept(f"{points} points, {limit} per chunk, {options.memory}", job)
    return whole_jobs.alternate(runs, {name: options.repeats for name in runs})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    whole_jobs.add_options(parser)
    options = parser.parse_args()
    points = (options.points or [10_000_000 if options.full else 1_000_000])[0]
    work = whole_jobs.prepared(options)
    samples = whole_jobs.Samples(options, "chunks")
    with whole_jobs.Clouds(options, work) as clouds:
        cloud = clouds.torus(points)
        limits = {wanted: chunk_points_for(options, work, cloud, points, wanted) for wanted in WANTED}
        results = measured(options, work, samples, cloud, points, limits)
    rows = []
    for (name, taken), limit in zip(results.items(), limits.values()):
        seconds = whole_jobs.stage_medians(taken)
        rows.append({**whole_jobs.row_of(name, points, taken), "chunk_points": limit,
                     "reconstruct_seconds": seconds["reconstruct"], "stage_seconds": seconds})
    for row in rows:
        row["times_one_chunk"] = row["seconds"] / rows[0]["seconds"]
    print("\n" + harness.table(rows, COLUMNS))
    stages = [{"stage": stage, **{row["variant"]: row["stage_seconds"].get(stage, 0.0) for row in rows}}
              for stage in rows[0]["stage_seconds"]]
    print("\nseconds\n" + harness.table(stages, list(stages[0])))
    plots.line_plot(pathlib.Path(options.out) / "chunks.svg", f"One thread, {points:,} points, by chunks", "chunks",
                    "times the seconds of one chunk",
                    {"whole job": [(row["chunks"], row["times_one_chunk"]) for row in rows]}, log_x=True)
    times, one, same = rows[1]["times_one_chunk"], rows[0]["chunks"] == 1, whole_jobs.one_digest(rows)
    targets = {f"{rows[1]['chunks']} chunks over {rows[0]['chunks']}": (times, times <= MOST_TIMES, "at most 1.15"),
               f"{rows[2]['chunks']} chunks over {rows[0]['chunks']}": (rows[2]["times_one_chunk"], True, "reported"),
               "one chunk is one chunk": (one, one, "True"), "same bytes for any chunks": (same, same, "True")}
    return whole_jobs.finish(options, "chunks", rows, targets, {}, samples)


if __name__ == "__main__":
    sys.exit(main())
