#!/usr/bin/env python3
"""The same job by one process, and by mpirun with 1, 2 and 4 ranks of 1 and 2 threads: seconds, and the same bytes.

What few cores can show: that every split gives the same bytes, what it costs to be a team (orbweave-mpi with one rank
over orbweave), and the gain of as many workers as there are cores. What they cannot: any gain beyond them. Rows with
more workers than cores say so; there the time may rise, and only the bytes are judged. Exit status 1 where they
differ, 2 where there is no mpirun or no orbweave-mpi.

usage: bench/workloads/ranks.py [--points N] [--full] [--repeats N] [--memory 1GiB]     --full: 2M points
"""
import argparse
import os
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("matplotlib")

import harness  # noqa: E402
import plots  # noqa: E402
import whole_jobs  # noqa: E402

RANKS = (1, 2, 4)
THREADS = (1, 2)
COLUMNS = ["variant", "workers", "seconds", "relative_half_range", "speed_up", "largest_rank_mib", "chunks", "can_show"]


def launcher(ranks):
    """Of Open MPI: more ranks than cores, threads free to move, root as in containers."""
    for name in ("OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"):
        os.environ[name] = "1"
    return ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", ranks]


def mpi_program(options):
    """orbweave-mpi beside orbweave; None where it or mpirun is missing."""
    program = pathlib.Path(options.mpi_program or pathlib.Path(options.program).with_name("orbweave-mpi"))
    return program if shutil.which("mpirun") and os.access(program, os.X_OK) else None


def team_job(options, work, cloud, points, ranks, threads, *arguments):
    """Of `ranks` processes; 0: of orbweave itself."""
    words = ["--threads", threads, *arguments]
    if ranks == 0:
        return whole_jobs.job(options, work, cloud, points, *words)
    team = argparse.Namespace(**{**vars(options), "program": str(mpi_program(options))})
    return whole_jobs.job(team, work, cloud, points, *words, launcher=launcher(ranks))


def add_options(parser):
    parser.add_argument("--mpi-program", help="default: orbweave-mpi beside --program")
    whole_jobs.add_options(parser)


def measured(options, work, samples, points):
    memory = options.memory or "1GiB"
    runs, facts = {}, {}
    with whole_jobs.Clouds(options, work) as clouds:
        cloud = clouds.torus(points)
        for threads in THREADS:
            for ranks in (0, *RANKS):
                name = f"{ranks} x {threads}" if ranks else f"one process, {threads}"
                job = team_job(options, work, cloud, points, ranks, threads, "--memory", memory,
                               "--chunk-points", max(points // 40, 5_000))
                runs[name] = samples.kept(f"{name} threads, {points} points, {memory}", job)
                facts[name] = {"ranks": ranks, "threads": threads}
        results = whole_jobs.alternate(runs, {name: options.repeats for name in runs})
    return [{**whole_jobs.row_of(name, points, results[name]), **facts[name],
             "stage_seconds": whole_jobs.stage_medians(results[name])} for name in runs]


def complete(rows):
    cores = os.cpu_count() or 1
    for row in rows:
        row["workers"] = max(row["ranks"], 1) * row["threads"]
        row["speed_up"] = rows[0]["seconds"] / row["seconds"]
        row["largest_rank_mib"] = row.pop("peak_memory_mib")
        row["can_show"] = "time and bytes" if row["workers"] <= cores else f"bytes ({cores} cores)"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser)
    options = parser.parse_args()
    points = (options.points or [2_000_000 if options.full else 300_000])[0]
    work = whole_jobs.prepared(options)
    if not mpi_program(options):
        print("no mpirun or no orbweave-mpi beside the program: nothing to measure", file=sys.stderr)
        return 2
    samples = whole_jobs.Samples(options, "ranks")
    rows = measured(options, work, samples, points)
    complete(rows)
    print("\n" + harness.table(rows, COLUMNS))
    stages = [{"stage": stage, **{row["variant"]: row["stage_seconds"].get(stage, 0.0) for row in rows}}
              for stage in rows[0]["stage_seconds"]]
    print("\nseconds of the leader\n" + harness.table(stages, list(stages[0])))
    lines = {f"{threads} threads a rank": [(row["ranks"], row["seconds"]) for row in rows
                                           if row["ranks"] and row["threads"] == threads] for threads in THREADS}
    plots.line_plot(pathlib.Path(options.out) / "ranks.svg", f"{points:,} points on {os.cpu_count()} cores", "ranks",
                    "seconds", lines)
    same, team = whole_jobs.one_digest(rows), rows[1]["seconds"] / rows[0]["seconds"]
    targets = {"same bytes for any ranks and threads": (same, same, "True"),
               "a team of one over one process": (team, True, "reported")}
    return whole_jobs.finish(options, "ranks", rows, targets, {}, samples)


if __name__ == "__main__":
    sys.exit(main())
