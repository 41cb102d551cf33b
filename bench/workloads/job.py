#!/usr/bin/env python3
"""Whole jobs, from a file to a file, wall seconds and peak memory.

  sizes    oriented points by size and budget: points/s end to end and per stage, peak memory against
           the budget, what was predicted against what was measured; every mesh is closed, with
           2V - 2 chi triangles. --full: 0.1, 1, 10 and 100 million points at 2GiB and 512MiB; the
           rate of 100M is at least 0.9 times that of 10M
  open3d   the program against Open3D (load, ball pivoting, write) on 1M oriented points: at least 10 times
  budget   10M points with --memory 1GiB: at least 700,000 points/s, peak memory under the budget,
           the share of each stage

Jobs alternate within a comparison; figures are medians (of one run beyond 30M points). Open3D's seconds
leave out the start of its interpreter and the import; the program's are those of the whole process. The
exit status is 1 when a target is missed.

usage: bench/workloads/job.py [sizes|open3d|budget]... [--points N,N] [--memory 2GiB,512MiB] [--order ordered,shuffled]
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

PARTS = ("sizes", "open3d", "budget")
SIZES = [100_000, 1_000_000]
FULL_SIZES = [100_000, 1_000_000, 10_000_000, 100_000_000]
SIZE_COLUMNS = ["variant", "points", "seconds", "relative_half_range", "points_per_second", "of_10M_rate",
                "peak_memory_mib", "chunks", "closed"]
FORECAST_COLUMNS = ["variant", "points", "memory_predicted_mib", "memory_measured_mib", "disk_predicted_mib",
                    "disk_measured_mib", "disk_seen_mib", "seconds_predicted", "seconds"]
MIB = 1 << 20


class Bench:
    """What the parts have in common."""

    def __init__(self, options, work, clouds, samples):
        self.options, self.work, self.clouds, self.samples = options, work, clouds, samples

    def job(self, points, memory, order="ordered"):
        def call():
            cloud = self.clouds.torus(points, order)
            words = ["--memory", memory] if memory else []
            return whole_jobs.job(self.options, self.work, cloud, points, *words)()
        return self.samples.kept(f"{points} points, {order}, {memory}", call)

    def repeats(self, points):
        return 1 if points > 30_000_000 else self.options.repeats


def forecast_of(results):
    report = results[0]["report"]
    predicted, measured = report.get("predicted") or {}, report.get("measured") or {}

    def mib(facts, key):
        return facts.get(key, 0) / MIB or "-"

    return {"memory_predicted_mib": mib(predicted, "peak_memory_bytes"),
            "memory_measured_mib": mib(measured, "peak_memory_bytes"),
            "disk_predicted_mib": mib(predicted, "disk_bytes"), "disk_measured_mib": mib(measured, "disk_bytes"),
            "disk_seen_mib": max(r["disk_seen_bytes"] for r in results) / MIB,
            "seconds_predicted": predicted.get("seconds", 0) or "-"}


def size_rows(bench, options):
    sizes = options.points or (FULL_SIZES if options.full else SIZES)
    budgets = (options.memory or ("2GiB,512MiB" if options.full else "2GiB")).split(",")
    wanted = {f"{points:,} points, {order}, {memory}": (points, order, memory) for points in sizes
              for order in options.order.split(",") for memory in budgets}
    print(f"\nsizes: {len(wanted)} jobs", flush=True)
    results = whole_jobs.alternate(
        {name: bench.job(points, memory, order) for name, (points, order, memory) in wanted.items()},
        {name: bench.repeats(points) for name, (points, _, _) in wanted.items()})
    rows = []
    for name, (points, order, memory) in wanted.items():
        row = whole_jobs.row_of(f"{memory} {order}", points, results[name])
        peaks = {stage: most / MIB for stage, most in
                 whole_jobs.stage_medians(results[name], "peak_memory_bytes").items()}
        rows.append({**row, "part": "sizes", "memory": memory, "order": order, **forecast_of(results[name]),
                     "stage_seconds": whole_jobs.stage_medians(results[name]), "stage_peak_mib": peaks})
    for row in rows:
        same = [r for r in rows if r["points"] == 10_000_000 and r["variant"] == row["variant"]]
        row["of_10M_rate"] = row["points_per_second"] / same[0]["points_per_second"] if same else "-"
    return rows


def stage_table(rows):
    """A row per stage, a column per job: seconds, millions of points a second, peak memory."""
    names = list(dict.fromkeys(stage for row in rows for stage in row["stage_seconds"]))
    label = {id(row): f"{row['points'] / 1e6:g}M {row['variant']}" for row in rows}
    table = []
    for name in names:
        line = {"stage": name}
        for row in rows:
            seconds = row["stage_seconds"].get(name)
            if seconds is not None:
                rate = f", {row['points'] / seconds / 1e6:.3g} M/s" if seconds >= 0.01 else ""
                peak = row["stage_peak_mib"].get(name, 0.0)
                line[label[id(row)]] = f"{seconds:.2f} s{rate}" + (f", {peak:,.0f} MiB" if peak else "")
        table.append(line)
    return harness.table(table, ["stage", *label.values()])


def size_targets(rows):
    targets = {}
    for row in rows:
        name = f"{row['points'] / 1e6:g}M {row['variant']}"
        budget = whole_jobs.parse_bytes(row["memory"]) / MIB
        peak = row["peak_memory_mib"]
        targets[f"{name}: peak MiB"] = (peak, peak < budget, f"under {budget:,.0f}")
        targets[f"{name}: closed, 2V - 2 chi triangles"] = (row["closed"], row["closed"], "True")
        if row["points"] == 100_000_000 and row["of_10M_rate"] != "-":
            targets[f"{name}: rate over that of 10M"] = (row["of_10M_rate"], row["of_10M_rate"] >= 0.9, "at least 0.9")
    same = whole_jobs.one_digest(rows)
    targets["same bytes for any budget and order"] = (same, same, "True")
    return targets


def draw_sizes(options, rows):
    out = pathlib.Path(options.out)
    rates, peaks = {}, {}
    for row in rows:
        rates.setdefault(row["variant"], []).append((row["points"], row["points_per_second"]))
        peaks.setdefault(row["variant"], []).append((row["points"], row["peak_memory_mib"]))
    plots.line_plot(out / "job_rate.svg", "Whole jobs, two cores or what is there", "points", "points per second",
                    rates, log_x=True)
    plots.line_plot(out / "job_memory.svg", "Peak memory of whole jobs", "points", "MiB", peaks, log_x=True)


def part_sizes(bench, options):
    rows = size_rows(bench, options)
    print("\n" + harness.table(rows, SIZE_COLUMNS))
    print("\n" + harness.table(rows, FORECAST_COLUMNS))
    print("\n" + stage_table(rows))
    draw_sizes(options, rows)
    return rows, size_targets(rows)


def open3d_job(work, cloud, radius):
    words = [harness.peer_python(), harness.PEERS / "open3d_peer.py", cloud, "--radii", repr(radius), "--no-counts",
             "--mesh", work / "open3d.ply"]
    measured = harness.run(words)
    (work / "open3d.ply").unlink(missing_ok=True)
    facts = json.loads(measured["stdout"])
    seconds = facts["load_seconds"] + facts["kernel_seconds"] + facts["write_seconds"]
    return {**measured, "process_seconds": measured["wall_seconds"], "wall_seconds": seconds}


def part_open3d(bench, options):
    if interpreter.with_packages("open3d") is None:
        print("\nopen3d: not installed (python3-open3d), not measured")
        return [], {}
    points = (options.points or [1_000_000])[0]
    print(f"\nopen3d: {points:,} points", flush=True)
    cloud = bench.clouds.torus(points)
    peer = bench.samples.kept(f"Open3D {points}", lambda: open3d_job(bench.work, cloud, whole_jobs.radius(points)))
    runs = {"orbweave": bench.job(points, None), "Open3D": peer}
    results = whole_jobs.alternate(runs, {name: options.repeats for name in runs})
    ours = whole_jobs.row_of("orbweave", points, results["orbweave"])
    wall = harness.spread([r["wall_seconds"] for r in results["Open3D"]])
    theirs = {"variant": "Open3D", "points": points, "seconds": wall["median"], "wall": wall,
              "relative_half_range": wall["relative_half_range"], "points_per_second": points / wall["median"],
              "peak_memory_mib": max(r["peak_memory_bytes"] for r in results["Open3D"]) / MIB}
    rows = [{**ours, "part": "open3d"}, {**theirs, "part": "open3d"}]
    print("\n" + harness.table(rows, SIZE_COLUMNS[:5] + ["peak_memory_mib"]))
    ratio = theirs["seconds"] / ours["seconds"]
    return rows, {"times Open3D": (ratio, ratio >= 10.0, "at least 10")}


def part_budget(bench, options):
    points = (options.points or [10_000_000])[0]
    memory = (options.memory or "1GiB").split(",")[0]
    print(f"\nbudget: {points:,} points, {memory}", flush=True)
    results = whole_jobs.alternate({memory: bench.job(points, memory)}, {memory: options.repeats})[memory]
    seconds = whole_jobs.stage_medians(results)
    row = {**whole_jobs.row_of(memory, points, results), "part": "budget", "stage_seconds": seconds}
    shares = [{"stage": stage, "seconds": s, "share": s / row["seconds"]} for stage, s in seconds.items()]
    print("\n" + harness.table(shares, ["stage", "seconds", "share"]))
    rate, peak, budget = row["points_per_second"], row["peak_memory_mib"], whole_jobs.parse_bytes(memory) / MIB
    return [row], {"points per second": (rate, rate >= 700_000, "at least 700,000"),
                   "peak MiB": (peak, peak < budget, f"under {budget:,.0f}")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; none: all")
    parser.add_argument("--order", default="ordered", help="of the points in the file: ordered, shuffled or both by "
                        "ordered,shuffled")
    whole_jobs.add_options(parser)
    options = parser.parse_args()
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"unknown part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    work = whole_jobs.prepared(options)
    samples = whole_jobs.Samples(options, "job")
    rows, targets = [], {}
    with whole_jobs.Clouds(options, work) as clouds:
        bench = Bench(options, work, clouds, samples)
        for part in options.parts or PARTS:
            part_rows, part_targets = globals()[f"part_{part}"](bench, options)
            rows += part_rows
            targets.update({f"{part}: {name}": value for name, value in part_targets.items()})
    return whole_jobs.finish(options, "job", rows, targets, {}, samples)


if __name__ == "__main__":
    sys.exit(main())
