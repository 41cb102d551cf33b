#!/usr/bin/env python3
"""Peak memory of whole jobs by the number of points, at one budget: a flat line.

Oriented points of a torus, 1, 3 and 10 million (--full: 30 and 100 million as well), one run each; the
peak is that of the process (/usr/bin/time), with the most of every stage beside it. The slope is that of
the line through the peaks by least squares, in bytes per point, of the clouds that fill the budget (that
have 48 bytes per point for four fifths of it): smaller ones take what they are. It is a target where the
largest has at least three times the points of the smallest of them (--full). The exit status is 1 when a
peak passes the budget, the slope passes 1 byte per point, or a prediction is not 1 to 1.3 times the peak.

usage: bench/workloads/memory.py [--memory 512MiB] [--points 1M,3M,10M] [--full]
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("matplotlib")

import harness  # noqa: E402
import plots  # noqa: E402
import whole_jobs  # noqa: E402

SIZES = [1_000_000, 3_000_000, 10_000_000]
FULL_SIZES = SIZES + [30_000_000, 100_000_000]
MIB = 1 << 20
MOST_BYTES_PER_POINT = 1.0


def slope(pairs):
    """Of the line through (x, y) with the least squares."""
    mean_x = sum(x for x, _ in pairs) / len(pairs)
    mean_y = sum(y for _, y in pairs) / len(pairs)
    spread = sum((x - mean_x) ** 2 for x, _ in pairs)
    return sum((x - mean_x) * (y - mean_y) for x, y in pairs) / spread if spread > 0 else 0.0


def filling(rows):
    """Clouds that are about as large as the budget, or larger."""
    budget = whole_jobs.parse_bytes(rows[0]["memory"])
    return [row for row in rows if row["points"] * whole_jobs.CLOUD_BYTES >= 0.8 * budget]


def measure(options, work, samples):
    rows = []
    memory = options.memory or "512MiB"
    with whole_jobs.Clouds(options, work) as clouds:
        for points in options.points or (FULL_SIZES if options.full else SIZES):
            def call(points=points):
                return whole_jobs.job(options, work, clouds.torus(points), points, "--memory", memory)()
            result = samples.kept(f"{points} points, {memory}", call)()
            report = result["report"]
            stages = {name: s["peak_memory_bytes"] / MIB for name, s in harness.stages(report).items()}
            rows.append({"points": points, "memory": memory, "peak_memory_mib": result["peak_memory_bytes"] / MIB,
                         "predicted_mib": report["predicted"]["peak_memory_bytes"] / MIB,
                         "fullest_stage": max(stages, key=stages.get), "seconds": result["wall_seconds"],
                         "stage_peak_mib": stages})
            print(f"  {points:,} points: {rows[-1]['peak_memory_mib']:.0f} MiB", flush=True)
    return rows


def targets_of(rows, bytes_per_point):
    budget = whole_jobs.parse_bytes(rows[0]["memory"]) / MIB
    peak = max(row["peak_memory_mib"] for row in rows)
    targets = {"largest peak, MiB": (peak, peak < budget, f"under {budget:,.0f}")}
    sizes = [row["points"] for row in filling(rows)]
    if sizes and max(sizes) >= 3 * min(sizes):
        targets["slope, bytes per point"] = (bytes_per_point, bytes_per_point <= MOST_BYTES_PER_POINT,
                                             f"at most {MOST_BYTES_PER_POINT:g}")
    for row in rows:
        ratio = row["predicted_mib"] / row["peak_memory_mib"]
        targets[f"{row['points'] / 1e6:g}M: predicted over measured"] = (ratio, 1.0 <= ratio <= 1.3, "1 to 1.3")
    return targets


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    whole_jobs.add_options(parser, repeats=1)
    options = parser.parse_args()
    work = whole_jobs.prepared(options)
    samples = whole_jobs.Samples(options, "memory")
    rows = measure(options, work, samples)
    print("\n" + harness.table(rows, ["points", "memory", "peak_memory_mib", "predicted_mib", "fullest_stage", "seconds"]))
    bytes_per_point = slope([(row["points"], row["peak_memory_mib"] * MIB) for row in filling(rows) or rows])
    budget = whole_jobs.parse_bytes(rows[0]["memory"]) / MIB
    plots.line_plot(pathlib.Path(options.out) / "memory.svg", f"Peak memory at {rows[0]['memory']}", "points", "MiB",
                    {"measured": [(row["points"], row["peak_memory_mib"]) for row in rows],
                     "predicted": [(row["points"], row["predicted_mib"]) for row in rows],
                     "budget": [(row["points"], budget) for row in rows]}, log_x=True)
    return whole_jobs.finish(options, "memory", rows, targets_of(rows, bytes_per_point),
                             {"slope_bytes_per_point": bytes_per_point}, samples)


if __name__ == "__main__":
    sys.exit(main())
