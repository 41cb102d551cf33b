#!/usr/bin/env python3
"""How long a job takes on 1 to 1,000 workers, predicted from the times of the chunks of one measured job, so that a
cluster can be sized: docs/scaling.md.

The measured job is one of orbweave with one thread: the report of your own (--report), or a torus that is generated
and run here (--measured points). It is predicted as it is and scaled to --points. bench/models/cluster_model.py is the model
and states its assumptions; bench/models/stage_kinds.py says which stages are shared.

Bytes that a team moves are those that a report of the same job by several ranks counted (--team-report, --check); the
column before_seconds is for a counter that gives out chunk by chunk and a leader who merges all counts alone.

--check runs the measured job with 2 threads and, where orbweave-mpi is there, by 1, 2 and 4 ranks, in turns, and
compares the model, told how many cores there are, with their medians. What a team costs any job (its start, its
meetings, its flushes) is measured on a tiny one and added. Exit status 1 where it is off by more than --tolerance on as
many workers as there are cores, or fewer. With --fit, 4 ranks are predicted from 1 and 2 alone, and judged: what a team
costs any job grows evenly with its ranks, and --slowdown is what makes the model right for 2 ranks. A machine that does
something else meanwhile spoils it.

usage: bench/models/simulate.py [--report JOB.report.json [--team-report JOB.report.json]] [--points 1G] [--threads 16]
                                [--storage 10] [--worker 2] [--check [--fit]]
"""
import argparse
import dataclasses
import json
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("matplotlib")

import cluster_model  # noqa: E402
import harness  # noqa: E402
import plots  # noqa: E402
import ranks  # noqa: E402
import stage_kinds  # noqa: E402
import whole_jobs  # noqa: E402

WORKERS = (1, 2, 4, 8, 16, 32, 64, 100, 200, 500, 1000)
LEAST_POINTS = 10_000  # a job that is all start and end
COLUMNS = ["workers", "seconds", "before_seconds", "points_per_second", "speed_up", "efficiency", "shared_seconds",
           "alone_seconds", "least_for_transfer", "bytes_per_point", "counter_calls", "longest_stage"]
CHECK_COLUMNS = ["variant", "workers", "measured_seconds", "predicted_seconds", "error_percent", "of_a_team", "counts",
                 "bytes_per_point", "predicted_bytes", "counter_calls", "predicted_calls"]
FITTED_RANKS = (1, 2)  # others are predicted from these


def measure(options, work, samples, clouds, variants):
    """{(ranks, threads, points): results}, alternating; ranks 0: orbweave itself. All with the same chunks."""
    limit = options.chunk_points or max(options.measured // 40, 5_000)
    runs = {}
    for team, threads, points in variants:
        call = ranks.team_job(options, work, clouds.torus(points), points, team, threads,
                              "--memory", options.memory or "2GiB", "--chunk-points", limit)
        name = f"{team} ranks, {threads} threads, {points} points"
        runs[(team, threads, points)] = samples.kept(f"{name}, {limit} per chunk, {options.memory}", call)
    return whole_jobs.alternate(runs, {name: options.repeats for name in runs})


def median_result(results):
    return sorted(results, key=lambda result: result["wall_seconds"])[(len(results) - 1) // 2]


def median_wall(results):
    return harness.spread([result["wall_seconds"] for result in results])["median"]


def given_team(path, points):
    """A report of several ranks, of the same job."""
    report = json.loads(path.read_text(encoding="utf-8"))
    if report.get("ranks", 1) < 2 or "traffic" not in report:
        sys.exit(f"{path}: wanted is the report of a job by two ranks or more, which counts the bytes of all of them")
    if report["input"]["points_read"] != points:
        sys.exit(f"{path}: {report['input']['points_read']:,} points; the job of --report has {points:,}")
    return report


def given_report(path):
    report = json.loads(path.read_text(encoding="utf-8"))
    threads = report["options"]["run"]["threads"]
    if threads != 1 or report.get("ranks", 1) != 1:
        sys.exit(f"{path}: made with {threads or 'all'} threads and {report.get('ranks', 1)} ranks; wanted is one by "
                 "--threads 1, as chunks that run beside each other take longer")
    if not any(stage.get("chunk_seconds") for stage in report["stages"]):
        sys.exit(f"{path}: no stage has chunk_seconds (a resumed job, or an older version); run the job with --fresh")
    return report


def check_has_cpu_seconds(path, report):
    if not all(stage.get("chunk_cpu_seconds") for stage in report["stages"] if stage.get("chunk_seconds")):
        sys.exit(f"{path}: its stages lack chunk_cpu_seconds (an older version made it); run the job anew")


def curve(options, stages, points, own):
    """A row per number of workers; own: the points of the measured job."""
    grown = [stage.grown(points / own) for stage in stages]
    rows = []
    for workers in WORKERS:
        cluster = cluster_of(options, workers)
        seconds = cluster_model.job_seconds(grown, cluster)
        before = cluster_model.job_seconds(grown, dataclasses.replace(cluster, by_blocks=False, by_tree=False))
        total = sum(seconds.values())
        shared = sum(seconds[stage.name] for stage in grown if stage.kind.work == "shared")
        first = rows[0]["seconds"] if rows else total
        rows.append({"points": points, "workers": workers, "threads": cluster.threads, "seconds": total,
                     "before_seconds": sum(before.values()), "points_per_second": points / total, "speed_up": first / total,
                     "efficiency": first / total / workers, "shared_seconds": shared, "alone_seconds": total - shared,
                     "least_for_transfer": cluster_model.transfer_seconds(grown, cluster),
                     "bytes_per_point": cluster_model.bytes_moved(grown, cluster) / points,
                     "counter_calls": cluster_model.calls_of(grown, cluster),
                     "longest_stage": max(seconds, key=seconds.get), "stage_seconds": seconds})
    return rows


def cluster_of(options, workers):
    return cluster_model.Cluster(workers=workers, threads=options.threads, storage_bandwidth=options.storage * 1e9,
                                 worker_bandwidth=options.worker * 1e9, task_seconds=options.task_ms * 1e-3,
                                 counter_seconds=options.counter_ms * 1e-3, stage_seconds=options.stage_ms * 1e-3,
                                 slowdown=options.slowdown)


def advice(rows):
    """How many workers are worth it, in words."""
    half = [row for row in rows if row["efficiency"] >= 0.5][-1]
    best = min(rows, key=lambda row: row["seconds"])
    enough = next(row for row in rows if row["seconds"] <= 1.1 * best["seconds"])
    return (f"{rows[0]['points']:,} points: {half['workers']:,} workers of {half['threads']} threads are used at "
            f"least by half ({half['seconds']:,.0f} s); more than {enough['workers']:,} gain less than a tenth "
            f"({enough['seconds']:,.0f} s, {enough['alone_seconds']:,.0f} of them the leader's or everybody's own)")


def draw(options, curves):
    out = pathlib.Path(options.out)
    times = {f"{points:,} points": [(r["workers"], r["seconds"]) for r in rows] for points, rows in curves.items()}
    for points, rows in curves.items():
        times[f"{points:,} points, ideal"] = [(r["workers"], rows[0]["seconds"] / r["workers"]) for r in rows]
    title = f"Predicted, {options.threads} threads a worker, storage {options.storage:g} GB/s"
    plots.line_plot(out / "simulate_time.svg", title, "workers", "seconds", times, log_x=True, log_y=True)
    plots.line_plot(out / "simulate_efficiency.svg", title, "workers", "efficiency",
                    {f"{points:,} points": [(r["workers"], r["efficiency"]) for r in rows]
                     for points, rows in curves.items()}, log_x=True, log_y=True)


def stage_table(stages):
    rows = []
    for stage in stages:
        own = stage.seconds + sum(stage.chunk_seconds)
        rows.append({"stage": stage.name, "work": stage.kind.work, "seconds": own, "chunks": len(stage.chunk_seconds),
                     "not_in_chunks": stage.seconds, "read_mb": stage.bytes_read / 1e6,
                     "written_mb": stage.bytes_written / 1e6})
    return harness.table(rows, list(rows[0]))


def machine_as_cluster(options, team, threads, slowdown):
    """This machine; the storage is the page cache, which the measured times contain."""
    return cluster_model.Cluster(workers=max(team, 1), threads=threads, slowdown=slowdown, cores=os.cpu_count() or 1,
                                 task_seconds=options.check_task_ms * 1e-3 if team > 0 else 0.0, stage_seconds=0.0)


def fitted_team_seconds(team_seconds):
    """What a team costs any job, on the line through one rank and two."""
    if not all(team in team_seconds for team in FITTED_RANKS):
        return team_seconds
    one, two = (team_seconds[team] for team in FITTED_RANKS)
    return {team: max(0.0, one + (two - one) * (team - 1)) for team in team_seconds}


def fitted_slowdown(options, stages, taken, team_seconds):
    """With which the model is right for two ranks; 0 where it is too slow without."""
    two = next((results for (team, threads, _), results in taken.items() if (team, threads) == (2, 1)), None)
    if two is None:
        return options.slowdown
    wanted = median_wall(two) - team_seconds.get(2, 0.0)

    def predicted(slowdown):
        return sum(cluster_model.job_seconds(stages, machine_as_cluster(options, 2, 1, slowdown)).values())

    low, high = 0.0, 1.0
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if predicted(middle) < wanted else (low, middle)
    return low


def check_rows(options, stages, taken, team_seconds):
    """What the model says of the measured runs."""
    cores = os.cpu_count() or 1
    slowdown = options.slowdown
    if options.fit:
        team_seconds = fitted_team_seconds(team_seconds)
        slowdown = fitted_slowdown(options, stages, taken, team_seconds)
        print(f"\nfitted on 1 and 2 ranks: a slowdown of {slowdown:.3f}, " +
              ", ".join(f"{seconds:.2f} s of a team of {team}" for team, seconds in team_seconds.items()))
    rows = []
    for (team, threads, points), results in taken.items():
        cluster = machine_as_cluster(options, team, threads, slowdown)
        by_stage = cluster_model.job_seconds(stages, cluster)
        by_stage[stage_kinds.OUTSIDE] += by_stage.pop(stage_kinds.ANY_JOB) + team_seconds.get(team, 0.0)
        predicted, measured = sum(by_stage.values()), median_wall(results)
        fits = cluster.slots() <= cores or (options.fit and team > 0)
        traffic = median_result(results)["report"].get("traffic", {})
        rows.append({"variant": f"{team} ranks" if team else f"{threads} threads", "workers": cluster.slots(),
                     "measured_seconds": measured, "predicted_seconds": predicted,
                     "error_percent": 100.0 * (predicted / measured - 1.0), "of_a_team": team_seconds.get(team, 0.0),
                     "counts": "yes" if fits else f"no, {cores} cores", "fits": fits,
                     "bytes_per_point": traffic.get("bytes_per_point", 0.0),
                     "predicted_bytes": cluster_model.bytes_moved(stages, cluster) / points,
                     "counter_calls": traffic.get("counter_calls", 0),
                     "predicted_calls": cluster_model.calls_of(stages, cluster),
                     "measured_stages": whole_jobs.stage_medians(results), "predicted_stages": by_stage})
    return rows


def show_check(rows):
    print("\nprediction against measurement\n" + harness.table(rows, CHECK_COLUMNS))
    stages = [{"stage": stage, **{row["variant"]: f"{row['predicted_stages'].get(stage, 0.0):.2f} for {seconds:.2f}"
                                  for row in rows if (seconds := row["measured_stages"].get(stage)) is not None}}
              for stage in rows[0]["measured_stages"]]
    print("\nseconds predicted for those measured\n" + harness.table(stages, list(stages[0])))


def same_bytes(taken):
    return len({result["sha256"] for results in taken.values() for result in results}) == 1


def targets_of(options, checks, taken):
    targets = {f"{row['variant']}: error, percent": (row["error_percent"],
                                                     not row["fits"] or abs(row["error_percent"]) <= options.tolerance,
                                                     f"within {options.tolerance:g}" if row["fits"] else "reported")
               for row in checks}
    if len(taken) > 1:
        targets["same bytes in all runs"] = (same_bytes(taken), same_bytes(taken), "True")
    return targets


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--report", type=pathlib.Path, help="of a job with --threads 1 --fresh")
    parser.add_argument("--measured", type=lambda text: whole_jobs.numbers(text)[0],
                        help="points of the job that is measured here (default: 300,000, with --check 3 million, with --full 10 "
                        "million)")
    parser.add_argument("--chunk-points", type=int, help="of the job that is measured here (default: a 40th of them)")
    parser.add_argument("--threads", type=int, default=1, help="of a worker; default 1")
    parser.add_argument("--storage", type=float, default=10.0, help="GB/s of the file system; default 10")
    parser.add_argument("--worker", type=float, default=2.0, help="GB/s of a worker to it; default 2")
    parser.add_argument("--task-ms", type=float, default=2.0, help="per chunk, for opening files; default 2")
    parser.add_argument("--counter-ms", type=float, default=5.0, help="between two chunks that the common counter "
                        "gives out; default 5, over TCP; next to nothing with an RDMA network")
    parser.add_argument("--stage-ms", type=float, default=20.0, help="per stage, to meet; default 20")
    parser.add_argument("--slowdown", type=float, default=0.0, help="of a thread per further one beside it, for the "
                        "memory bandwidth they share; 0.05: a twentieth; default 0")
    parser.add_argument("--stage", action="append", default=[], metavar="NAME=WORK",
                        help="shared, leader or redundant, instead of what bench/models/stage_kinds.py says")
    parser.add_argument("--cpu-seconds", action="store_true", help="take the report's CPU seconds for its wall "
                        "seconds: it was made on a machine that was busy with something else")
    parser.add_argument("--check", action="store_true", help="measure 1, 2 and 4 workers, compare")
    parser.add_argument("--fit", action="store_true", help="with --check: predict 4 ranks from 1 and 2")
    parser.add_argument("--team-report", type=pathlib.Path, help="of the job of --report by two ranks or more")
    parser.add_argument("--check-task-ms", type=float, default=0.0, help="--task-ms of the ranks that are measured")
    parser.add_argument("--tolerance", type=float, default=15.0, help="of the check, percent; default 15")
    ranks.add_options(parser)
    options = parser.parse_args()
    options.overrides = dict(words.split("=", 1) for words in options.stage)
    if bad := set(options.overrides.values()) - {"shared", "leader", "redundant"}:
        parser.error(f"--stage: no such work: {', '.join(sorted(bad))}")
    if unknown := set(options.overrides) - set(stage_kinds.KINDS):
        parser.error(f"--stage: no such stage: {', '.join(sorted(unknown))}")
    if options.cpu_seconds and not options.report:
        parser.error("--cpu-seconds is for a --report")
    if options.fit and not options.check:
        parser.error("--fit is for --check")
    if options.team_report and not options.report:
        parser.error("--team-report is of the job of a --report")
    if options.report and options.check:
        parser.error("--check measures jobs of its own, a --report is of another")
    usual = 3_000_000 if options.check else 300_000
    options.measured = options.measured or (10_000_000 if options.full else usual)
    return options


def measured_stages(options, work, samples):
    """The stages of the job with one thread, its points, all runs of --check, and what teams cost any job."""
    if options.report:
        report = given_report(options.report)
        if options.cpu_seconds:
            check_has_cpu_seconds(options.report, report)
            report = cluster_model.unhindered(report)
        points = report["input"]["points_read"]
        team = given_team(options.team_report, points) if options.team_report else None
        return cluster_model.stages_of(report, overrides=options.overrides, team=team), points, {}, {}
    alone, least = (0, 1, options.measured), (0, 1, LEAST_POINTS)
    teams = ranks.RANKS if options.check and ranks.mpi_program(options) else ()
    variants = [alone] + ([(0, 2, options.measured)] if options.check else [])
    variants += [(n, 1, options.measured) for n in teams] + [least] + [(n, 1, LEAST_POINTS) for n in teams]
    with whole_jobs.Clouds(options, work) as clouds:
        taken = measure(options, work, samples, clouds, variants)
    tiny = {team: taken.pop((team, 1, LEAST_POINTS)) for team in (0, *teams)}
    team_seconds = {team: max(0.0, median_wall(tiny[team]) - median_wall(tiny[0])) for team in teams}
    one = median_result(taken[alone])
    constant = whole_jobs.outside_seconds(median_result(tiny[0]))
    growing = whole_jobs.outside_seconds(one) - constant
    team = median_result(taken[(2, 1, options.measured)])["report"] if 2 in teams else None
    return (cluster_model.stages_of(one["report"], growing, constant, options.overrides, team), options.measured, taken,
            team_seconds)


def main():
    options = parsed()
    work = whole_jobs.prepared(options)
    samples = whole_jobs.Samples(options, "simulate")
    stages, own, taken, team_seconds = measured_stages(options, work, samples)
    print(f"\nthe measured job, {own:,} points, one thread\n" + stage_table(stages))
    curves = {points: curve(options, stages, points, own)
              for points in dict.fromkeys([own, *(options.points or [1_000_000_000])])}
    for points, rows in curves.items():
        print(f"\n{points:,} points\n" + harness.table(rows, COLUMNS))
    print("\n" + "\n".join(advice(rows) for rows in curves.values()))
    print("\nassumptions\n" + "\n".join(f"- {line}" for line in cluster_model.ASSUMPTIONS))
    draw(options, curves)
    checks = check_rows(options, stages, taken, team_seconds) if options.check else []
    if checks:
        show_check(checks)
    extra = {"assumptions": cluster_model.ASSUMPTIONS, "checks": checks, "measured_points": own,
             "measured_stages": [dataclasses.asdict(stage) for stage in stages],
             "cluster": dataclasses.asdict(cluster_of(options, 1))}
    return whole_jobs.finish(options, "simulate", [row for rows in curves.values() for row in rows],
                             targets_of(options, checks, taken), extra, samples)


if __name__ == "__main__":
    sys.exit(main())
