#!/usr/bin/env python3
"""How fast real raw scans are, each by the job file that is made for its kind: this program alone, or in turn with another.

Columns: wall and CPU seconds of the whole process, points per wall second, CPU microseconds per point of the passes from the file
to oriented points (`raw_us`), CPU seconds of ball pivoting and of the hole pass, the pass's share of all CPU time, wall
microseconds per loop of fewer than 50 edges (`loop_us`), loops filled of all, peak memory, what `orbweave plan` said before over
the seconds that the run took (`plan`), and the SHA-256 of the mesh. Numbers are medians, each by itself. --stages adds a
table of every stage.

A program of --before may fill loops with patches that cross the surface, and may keep crumbs, whose loops it fills as well. So
loops are compared under the same limits: `alike` are those that this program fills in one more run, in which patches may cross
(`fill.allow_intersections`). Fewer are a miss where more stay open, too.

The exit status is 1 where a target of the table at the top of the script is missed: a share, a loop or a forecast for any scan,
points per second for two of them, with --before also how many times as fast and whether as many loops are filled. The other
program plans nothing. Programs run in turn, so that a busy minute hits both.

usage: bench/workloads/scan_speed.py DATA_DIR [--before PROGRAM --before-root DIR] [--only NAME]... [--repeats N] [--stages]
"""
import argparse
import hashlib
import json
import pathlib
import re
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
from real_scans import SCANS, TERRAIN, add_scan_options, inputs_of  # noqa: E402

MOST_SHARE = 0.15  # of the hole pass in the CPU time of the job
MOST_LOOP_US = 200.0
PLAN_WITHIN = (0.7, 1.4)
LEAST_TIMES = 5.0  # as fast as the program of --before
LEAST_RATE = {"autzen": 300_000, "bunny, ten scans": 300_000}  # points per second
RATE_ALONE = {"bunny, ten scans"}  # whose times as fast are shown, but have no target
SMALL_LOOP_EDGES = 50
BESIDE = [("interchange crop, terrain", "photogrammetry/e102_interchange_crop_1.2M.ply.gz", TERRAIN)]
TIMED = ["autzen", "lone-star", "pine plot", "pueblito", "interchange crop", "lion", "building 182", "bunny, ten scans"]
RAW_STAGES = re.compile(r"raw|smooth|orient|thin")
COLUMNS = ["scan", "program", "wall_s", "cpu_s", "points_per_s", "raw_us", "pivot_cpu_s", "holes_cpu_s", "hole_share",
           "loop_us", "filled", "alike", "loops", "peak_mib", "plan", "mesh"]


def settings_of(options, config, files):
    """Words that give a job file the files of a scan."""
    own = {"input.files": json.dumps([str(file.resolve()) for file in files]),
           "output.mesh": str(pathlib.Path(options.work) / "speed-plan.ply"), "output.picture": ""}
    return [config] + [word for key, value in own.items() for word in ("--set", f"{key}={value}")]


def planned_seconds(options, config, files, extra):
    words = [options.program, "plan", *settings_of(options, harness.ROOT / config, files), "--json"]
    for setting in extra:
        words += ["--set", setting]
    return json.loads(harness.run(words)["stdout"])["seconds"]


def one_run(options, label, program, root, config, files, extra):
    mesh = pathlib.Path(options.work) / f"speed-{label}.ply"
    planned = planned_seconds(options, config, files, extra) if label == "now" else None
    result = harness.run_job(program, root / config, files, mesh, extra)
    report, cpu = result["report"], result["user_seconds"] + result["system_seconds"]
    stages = harness.stages(report)
    points = report["input"]["points_read"]
    raw = sum(stage["cpu_seconds"] for name, stage in stages.items() if RAW_STAGES.search(name))
    small = [hole.get("seconds", 0.0) for hole in report["holes"] if hole["edges"] < SMALL_LOOP_EDGES]
    holes_cpu = stages["holes"]["cpu_seconds"] if "holes" in stages else 0.0
    numbers = {"wall_s": result["wall_seconds"], "cpu_s": cpu, "points_per_s": points / result["wall_seconds"],
               "raw_us": 1e6 * raw / points, "pivot_cpu_s": stages["reconstruct"]["cpu_seconds"], "holes_cpu_s": holes_cpu,
               "hole_share": holes_cpu / cpu, "loop_us": 1e6 * statistics.mean(small) if small else 0.0,
               "peak_mib": result["peak_memory_bytes"] / 2**20}
    if planned is not None:
        numbers["plan"] = planned / result["wall_seconds"]
    facts = {"filled": sum(bool(hole["filled"]) for hole in report["holes"]), "loops": len(report["holes"]),
             "mesh": hashlib.sha256(mesh.read_bytes()).hexdigest()[:8], "points": points, "stages": stages}
    mesh.unlink()
    return {"numbers": numbers, "facts": facts}


def row_of(scan, label, runs):
    """Medians of each number, facts of the last run, and every stage by its medians."""
    row = {"scan": scan, "program": label, **runs[-1]["facts"]}
    for name in runs[-1]["numbers"]:
        row[name] = statistics.median(run["numbers"][name] for run in runs)
    points = row["points"]
    row["stages"] = {}
    for name in runs[-1]["facts"]["stages"]:
        of_stage = [run["facts"]["stages"][name] for run in runs if name in run["facts"]["stages"]]
        seconds, cpu = (statistics.median(stage[key] for stage in of_stage) for key in ("seconds", "cpu_seconds"))
        row["stages"][name] = {"stage": name, "seconds": seconds, "cpu_seconds": cpu, "us_per_point": 1e6 * cpu / points}
    return row


def misses_of(now, before):
    """What a scan misses, in words."""
    name = now["scan"]
    if now["hole_share"] > MOST_SHARE:
        yield f"{name}: the hole pass takes {100 * now['hole_share']:.1f} % of the CPU time, at most {100 * MOST_SHARE:g} asked"
    if now["loop_us"] > MOST_LOOP_US:
        yield f"{name}: {now['loop_us']:.0f} microseconds per short loop, at most {MOST_LOOP_US:g} asked"
    if not PLAN_WITHIN[0] <= now["plan"] <= PLAN_WITHIN[1]:
        yield f"{name}: plan foretold {now['plan']:.2f} of the seconds, {PLAN_WITHIN[0]:g} to {PLAN_WITHIN[1]:g} asked"
    if now["points_per_s"] < LEAST_RATE.get(name, 0):
        yield f"{name}: {now['points_per_s']:,.0f} points/s, {LEAST_RATE[name]:,} asked"
    if before:
        times = before["wall_s"] / now["wall_s"]
        if times < LEAST_TIMES and name not in RATE_ALONE:
            yield f"{name}: {times:.2f} times as fast as before, {LEAST_TIMES:g} asked"
        alike, open_before = now["alike"], before["loops"] - before["filled"]
        if alike < before["filled"] and now["loops_alike"] - alike > open_before:
            yield (f"{name}: {alike:,} of {now['loops_alike']:,} loops filled under the same limits, "
                   f"{before['filled']:,} of {before['loops']:,} before")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_scan_options(parser)
    parser.add_argument("--only", action="append", help="scans whose name contains this; may be repeated")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--stages", action="store_true", help="a table of the stages of each scan, too")
    harness.add_common_options(parser)
    options = parser.parse_args()
    harness.prepare(options)
    scans = [scan[:3] for scan in SCANS if scan[0] in TIMED] + BESIDE
    rows, missed = [], []
    for name, path, config in scans:
        if options.only and not any(part in name for part in options.only):
            continue
        if not (pathlib.Path(options.data) / path).exists():
            print(f"skipped, no such file: {path}")
            continue
        files, extra = inputs_of(pathlib.Path(options.data) / path)
        programs = {"before": (options.before, options.before_root)} if options.before else {}
        programs["now"] = (options.program, harness.ROOT)
        runs = {label: (lambda label=label, made=made: one_run(options, label, *made, config, files, extra))
                for label, made in programs.items()}
        of_scan = {label: row_of(name, label, done)
                   for label, done in harness.alternate(runs, options.repeats).items()}
        if "before" in of_scan:
            alike = one_run(options, "alike", options.program, harness.ROOT, config, files,
                            [*extra, "fill.allow_intersections=true"])["facts"]
            of_scan["now"].update(alike=alike["filled"], loops_alike=alike["loops"])
        rows += of_scan.values()
        print(harness.table(list(of_scan.values()), COLUMNS), flush=True)
        if options.stages:
            print(harness.table(list(of_scan["now"]["stages"].values()), ["stage", "seconds", "cpu_seconds", "us_per_point"]))
        missed += misses_of(of_scan["now"], of_scan.get("before"))
    print("\n" + harness.table(rows, COLUMNS))
    harness.write_results(options, "scan_speed", rows)
    return harness.exit_status(missed) or (0 if rows else 1)


if __name__ == "__main__":
    sys.exit(main())
