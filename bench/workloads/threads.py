#!/usr/bin/env python3
"""What threads bring: whole jobs with one thread, two, and as many as there are cores.

Strong scaling: the same points, speed-up end to end and per stage; at least 1.9 on two threads for stages that
compute (given two cores that are idle). Weak scaling: as many points per thread, seconds ideally the same. The serial
share, in percent of the seconds of one thread, two ways: by Amdahl from the seconds of one thread and of n, and from
the n-thread run alone, where a stage of s seconds and c CPU seconds was serial for (n s - c) / (n - 1) of them, waiting
for the disk included. Exit status 1 where a target is missed.

usage: bench/workloads/threads.py [--points N] [--full] [--repeats N] [--memory 2GiB]      --full: 10M points
"""
import argparse
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("matplotlib")

import harness  # noqa: E402
import plots  # noqa: E402
import stage_kinds  # noqa: E402
import whole_jobs  # noqa: E402

COLUMNS = ["variant", "points", "seconds", "relative_half_range", "points_per_second", "cpu_seconds",
           "peak_memory_mib", "chunks"]
WANTED_SPEED_UP = 1.9


def serial_by_seconds(one, many, threads):
    """Amdahl, 1967: T(n) = T(1) (s + (1 - s) / n), solved for s; percent."""
    return 100.0 * (threads * many / one - 1.0) / (threads - 1) if one > 0 else 0.0


def serial_by_cpu(seconds, cpu, threads):
    """Percent of the work of one thread, taken to be the CPU seconds and what was waited alone."""
    alone = max(0.0, (threads * seconds - cpu) / (threads - 1))
    work = alone + threads * max(0.0, seconds - alone)
    return 100.0 * alone / work if work > 0 else 0.0


def speed_ups(results, counts):
    """A row per stage and one for the whole: speed-up, serial share; of the largest count of threads."""
    most = counts[-1]
    seconds = {n: whole_jobs.stage_medians(results[f"{n} threads"]) for n in counts}
    cpu = whole_jobs.stage_medians(results[f"{most} threads"], "cpu_seconds")
    rows = []
    for stage in seconds[1]:
        row = {"stage": stage, "computes": "yes" if stage_kinds.kind_of(stage).computes else ""}
        row.update({f"seconds_{n}": seconds[n][stage] for n in counts})
        row.update({f"speed_up_{n}": seconds[1][stage] / max(seconds[n][stage], 1e-9) for n in counts[1:]})
        row["serial_percent_by_seconds"] = serial_by_seconds(seconds[1][stage], seconds[most][stage], most)
        if stage in cpu:
            row["serial_percent_by_cpu"] = serial_by_cpu(seconds[most][stage], cpu[stage], most)
        rows.append(row)
    return rows + [whole_row(results, counts)]


def whole_row(results, counts):
    most = counts[-1]
    wall = {n: harness.spread([r["wall_seconds"] for r in results[f"{n} threads"]])["median"] for n in counts}
    cpu = harness.spread([whole_jobs.cpu_seconds(r) for r in results[f"{most} threads"]])["median"]
    return {"stage": "whole job", "computes": "", **{f"seconds_{n}": wall[n] for n in counts},
            **{f"speed_up_{n}": wall[1] / wall[n] for n in counts[1:]},
            "serial_percent_by_seconds": serial_by_seconds(wall[1], wall[most], most),
            "serial_percent_by_cpu": serial_by_cpu(wall[most], cpu, most)}


def measured(options, work, samples, clouds, sizes):
    """sizes: {variant: (points, threads)}"""
    memory = options.memory or "2GiB"
    runs = {}
    # Chunks of one size for all: the automatic one follows from the number of threads.
    for name, (points, threads) in sizes.items():
        job = whole_jobs.job(options, work, clouds.torus(points), points, "--threads", threads, "--memory", memory,
                             "--chunk-points", max(points // 40, 5_000))
        runs[name] = samples.kept(f"{name}, {points} points, {memory}", job)
    return whole_jobs.alternate(runs, {name: options.repeats for name in runs})


def draw(options, rows, stages, counts):
    ideal = [(n, float(n)) for n in counts]
    lines = {"ideal": ideal}
    for row in stages:
        if row["computes"] or row["stage"] == "whole job":
            lines[row["stage"]] = [(1, 1.0)] + [(n, row[f"speed_up_{n}"]) for n in counts[1:]]
    weak = {row["threads"]: row["seconds"] for row in rows if row["scaling"] == "weak"}
    lines["weak: points per thread the same, rate over one thread's"] = [
        (n, n * weak[1] / weak[n]) for n in counts if n in weak]
    plots.line_plot(pathlib.Path(options.out) / "threads.svg", "Speed-up by threads", "threads", "speed-up", lines)


def targets_of(stages, rows, counts):
    targets = {}
    if 2 in counts:
        for row in stages:
            if row["computes"]:
                ratio = row["speed_up_2"]
                targets[f"{row['stage']}: speed-up on 2 threads"] = (ratio, ratio >= WANTED_SPEED_UP, "at least 1.9")
    whole = stages[-1]
    targets["serial share by seconds, percent"] = (whole["serial_percent_by_seconds"], True, "reported")
    targets["serial share by CPU seconds, percent"] = (whole["serial_percent_by_cpu"], True, "reported")
    same = whole_jobs.one_digest(rows)
    targets["same bytes for any number of threads"] = (same, same, "True")
    return targets


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=whole_jobs.numbers, help="counts instead of 1,2,<cores>")
    whole_jobs.add_options(parser)
    options = parser.parse_args()
    counts = sorted({1, *(options.threads or [2, os.cpu_count() or 2])})
    if len(counts) < 2:
        parser.error("nothing to compare with one thread")
    points = (options.points or [10_000_000 if options.full else 1_000_000])[0]
    work = whole_jobs.prepared(options)
    samples = whole_jobs.Samples(options, "threads")
    strong = {f"{n} threads": (points, n) for n in counts}
    weak = {f"{n} threads, {points // counts[-1] * n:,} points": (points // counts[-1] * n, n) for n in counts[:-1]}
    with whole_jobs.Clouds(options, work) as clouds:
        results = measured(options, work, samples, clouds, {**strong, **weak})
    rows = [{**whole_jobs.row_of(name, size, results[name]), "threads": n, "scaling": "strong"}
            for name, (size, n) in strong.items()]
    rows += [{**whole_jobs.row_of(name, size, results[name]), "threads": n, "scaling": "weak"}
             for name, (size, n) in weak.items()]
    rows.append({**rows[len(counts) - 1], "scaling": "weak"})
    stages = speed_ups(results, counts)
    print("\n" + harness.table(rows, ["scaling"] + COLUMNS) + "\n\n" + harness.table(stages, list(stages[0])))
    draw(options, rows, stages, counts)
    return whole_jobs.finish(options, "threads", rows, targets_of(stages, rows, counts), {"stages": stages}, samples)


if __name__ == "__main__":
    sys.exit(main())
