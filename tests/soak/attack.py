#!/usr/bin/env python3
"""Attacks the program: mutated inputs, kills, damaged work directories, cuts whose bytes are compared, hostile clouds,
full disks, limits of the system, mutated job files, random jobs.

Trials are numbered; what trial N of a family does follows from the seed and N alone (of kills, from the moment as
well). Without --long, --count and --seconds every family runs the number of trials that CI runs. A finding prints how
it is repeated, what was expected and what was found, and keeps its files. The exit status is 1 when there is a finding.

usage: tests/soak/attack.py [--only FAMILY,...] [--seed N] [--first N] [--long | --count N] [--seconds S]
                            [--record FILE]
       tests/soak/attack.py --sum FILE      what all recorded runs did together
"""
import argparse
import collections
import concurrent.futures
import importlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import traceback

import trial

ROOT = pathlib.Path(__file__).resolve().parents[2]
FAMILIES = ["inputs", "kills", "damage", "bytes", "strays", "hostile", "disk", "limits", "jobs", "random"]
MODULES = {"bytes": "same_bytes", "random": "random_jobs"}
LONG_RUN = {"inputs": 50_000, "kills": 1_000, "damage": 2_000, "bytes": 2_000, "strays": 10_000, "random": 1_500}  # at least, over all recorded runs


def family_module(family):
    return importlib.import_module(MODULES.get(family, family))


def one_trial(setup, family, number):
    """(counts, findings) of a trial in a directory of its own; a defect of the suite is a finding, too."""
    directory = pathlib.Path(tempfile.mkdtemp(prefix="trial-", dir=setup.shared.parent))
    case = trial.Case(setup, family, number, directory)
    try:
        family_module(family).attack(case)
    except Exception:
        case.wrong("a trial that ends", traceback.format_exc())
    finally:
        shutil.rmtree(directory, ignore_errors=True)
    return case.counts, case.problems


def numbers(options, module):
    """Of the trials to run: up to the count, until the time is over."""
    count = options.count or (module.LONG if options.long else None if options.seconds else module.SHORT)
    end = time.monotonic() + (options.seconds or float("inf"))
    number = options.first
    while (count is None or number < options.first + count) and time.monotonic() < end:
        yield number
        number += 1


def outcomes(setup, family, options, module):
    """What every trial gave, as they end; at most two per worker wait."""
    with concurrent.futures.ProcessPoolExecutor(options.workers, initializer=trial.begin_worker,
                                                initargs=(options.launcher,)) as pool:
        waiting = set()
        for number in numbers(options, module):
            waiting.add(pool.submit(one_trial, setup, family, number))
            if len(waiting) >= 2 * options.workers:
                done, waiting = concurrent.futures.wait(waiting, return_when=concurrent.futures.FIRST_COMPLETED)
                yield from (future.result() for future in done)
        yield from (future.result() for future in concurrent.futures.as_completed(waiting))


def show(problem):
    print(f"\nFINDING in {problem['family']}: seed {problem['seed']}, trial {problem['number']}\n"
          f"  repeat    tests/soak/attack.py --only {problem['family']} --seed {problem['seed']} "
          f"--first {problem['number']} --count 1\n"
          f"  command   {problem['command']}\n  expected  {problem['expected']}\n  found     {problem['found']}\n"
          f"  files     {problem['kept']}", flush=True)


def run_family(family, options, scratch):
    """Runs the trials of a family; returns its line of the record."""
    module, began = family_module(family), time.monotonic()
    shared = scratch / family / "shared"
    shared.mkdir(parents=True)
    setup = trial.Setup(options.program, options.data, shared, options.keep, options.seed)
    setup.prepared = module.prepare(setup)
    counts, trials, wrong = collections.Counter(), 0, []
    for one_counts, problems in outcomes(setup, family, options, module):
        trials += 1
        counts.update(one_counts)
        for problem in problems:
            show(problem)
        wrong += problems
    shutil.rmtree(scratch / family)
    return {"family": family, "seed": options.seed, "first": options.first, "trials": trials, "wrong": len(wrong),
            "seconds": round(time.monotonic() - began, 1), "counts": dict(sorted(counts.items())), "findings": wrong}


def describe(line):
    counts = ", ".join(f"{name} {number:,}" for name, number in line["counts"].items())
    print(f"{line['family']:8} {line['trials']:7,} trials {line['seconds']:8.1f} s {line['wrong']:4} wrong   {counts}",
          flush=True)


def version(program):
    """Of the program, and of the sources beside it where they are under git."""
    words = ["git", "-C", str(ROOT), "describe", "--always", "--dirty"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    shown = trial.succeed([program, "--version"], ROOT).out.decode().strip()
    return {"program": shown, "commit": done.stdout.strip() or "unknown"}


def taken_together(lines):
    """{family: line} of recorded lines; trials that were run before count once, what was wrong always."""
    totals, spans = {}, collections.defaultdict(list)
    for line in lines:
        total = totals.setdefault(line["family"], {"family": line["family"], "trials": 0, "seconds": 0.0, "wrong": 0,
                                                   "counts": collections.Counter()})
        total["wrong"] += line["wrong"]
        span, earlier = range(line["first"], line["first"] + line["trials"]), spans[line["family"], line["seed"]]
        if any(span.start < other.stop and other.start < span.stop for other in earlier):
            print(f"{line['family']}, seed {line['seed']}, from {span.start}: run before, not counted again")
            continue
        earlier.append(span)
        total["trials"] += line["trials"]
        total["seconds"] += line["seconds"]
        total["counts"].update(line["counts"])
    return totals


def add_up(path):
    """Prints what the recorded runs did. Status 1 where any was wrong."""
    lines = [json.loads(text) for text in pathlib.Path(path).read_text(encoding="utf-8").splitlines()]
    totals = taken_together(lines)
    for family in FAMILIES:
        if family in totals:
            describe(totals[family])
    for family, least in LONG_RUN.items():
        unit = family_module(family).UNIT
        done = totals[family]["counts"][unit] if family in totals else 0
        print(f"{unit:12} {done:9,} of at least {least:,}{'' if done >= least else '   MISSING'}")
    wrong = sum(total["wrong"] for total in totals.values())
    print(f"{wrong} wrong, programs: {', '.join(sorted({line['commit'] for line in lines}))}")
    return 1 if wrong else 0


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=",".join(FAMILIES), help=f"of {', '.join(FAMILIES)}")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first trial")
    parser.add_argument("--long", action="store_true", help="as many trials as are asked for once per issue")
    parser.add_argument("--count", type=int, help="trials of each family")
    parser.add_argument("--seconds", type=float, help="time for each family; trials that run then still end")
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count()))
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/orbweave"))
    parser.add_argument("--launcher", help="program that starts the program quickly; empty: none")
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared" / "data",
                        help="directory of real samples; the attack goes on without them")
    parser.add_argument("--keep", type=pathlib.Path, default=ROOT / "build" / "soak", help="for the files of findings")
    parser.add_argument("--scratch", default="/dev/shm" if os.access("/dev/shm", os.W_OK) else None)
    parser.add_argument("--record", help="file to which a line per family is appended")
    parser.add_argument("--sum", metavar="FILE", help="add up what was recorded, run nothing")
    options = parser.parse_args()
    options.program = str(pathlib.Path(options.program).resolve())
    options.keep = options.keep.resolve()
    if options.launcher is None:
        beside = pathlib.Path(options.program).with_name("soak_launcher")
        options.launcher = str(beside) if beside.exists() else ""
    options.only = options.only.split(",")
    if unknown := set(options.only) - set(FAMILIES):
        parser.error(f"no family {', '.join(sorted(unknown))}; there are {', '.join(FAMILIES)}")
    return options


def attack(options):
    about, wrong = version(options.program), 0
    os.umask(0o022)
    options.keep.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="orbweave-soak-", dir=options.scratch) as scratch:
        os.chmod(scratch, 0o755)
        for family in options.only:
            line = run_family(family, options, pathlib.Path(scratch))
            describe(line)
            wrong += line["wrong"]
            if options.record:
                with open(options.record, "a", encoding="utf-8") as record:
                    record.write(json.dumps({**line, **about, "ended": time.strftime("%Y-%m-%d %H:%M")}) + "\n")
    print(f"{wrong} wrong")
    return 1 if wrong else 0


def main():
    sys.stdout.reconfigure(errors="backslashreplace")
    options = parsed()
    return add_up(options.sum) if options.sum else attack(options)


if __name__ == "__main__":
    sys.exit(main())
