"""Limits of the system and budgets that are too small: size of files, open files, address space, processes, memory.

Right is: status 0 with the same outputs, or status 4 (2 where the limit is an option) with a message, never the end by
a signal; the peak stays inside of a budget; then the same command without the limit ends with the same outputs.
"""
import bisect
import os
import resource
import shutil

import small_job
import trial

SHORT, LONG = 10, 400
UNIT = "limits"
KINDS = ["file size", "open files", "address space", "processes", "memory"]
COMMANDS = [small_job.COMMAND] * 4 + [["convert", "scan_0.ply", "out.csv"], ["inspect", "scan_0.ply"]]


def prepare(setup):
    inputs = small_job.write(setup.program, setup.shared)
    undisturbed = small_job.Undisturbed(setup.program, setup.shared)
    return inputs, undisturbed, least_that_starts(setup), trial.let_nobody_run(setup)


def least_that_starts(setup):
    """The least number of files and address space in MiB in which the system loads the program; where it cannot, it
    says so by status 127."""
    def loads(kind, value):
        return trial.execute([setup.program, "--version"], setup.shared, [(kind, value)]).status != 127

    return {"open files": bisect.bisect_left(range(100), True, lo=3, key=lambda n: loads(resource.RLIMIT_NOFILE, n)),
            "address space": bisect.bisect_left(range(2000), True, lo=10, key=lambda n: loads(
                resource.RLIMIT_AS, n * trial.MEBIBYTE))}


def attack(case):
    inputs, undisturbed, least, nobody = case.setup.prepared
    for name in inputs:
        shutil.copy2(case.setup.shared / name, case.directory)
    kind, rng = case.rng.choice(KINDS), case.rng
    arguments = rng.choice(COMMANDS) if kind != "memory" else small_job.COMMAND
    case.counts["limits"] += 1
    case.counts[kind] += 1
    if kind == "memory":
        value = rng.choice([1, 10, 50, 100, 110, 120, 130, 150, 180, 200, 256])
        ended = case.run([*arguments, "--memory", f"{value}MiB"])
    else:
        value = VALUES[kind](rng, least)
        ended = limited(case, kind, value, arguments, nobody if kind == "processes" else None)
    check(case, ended, kind, value, undisturbed)
    if arguments == small_job.COMMAND:
        check_again(case, ended, undisturbed, inputs, f"{kind} of {value}")


VALUES = {"file size": lambda rng, least: int(10 ** rng.uniform(3.3, 6)),  # standard error is a file, too
          "open files": lambda rng, least: rng.randint(least["open files"], 40),
          "address space": lambda rng, least: int(least["address space"] * trial.MEBIBYTE * 10 ** rng.uniform(0, 0.8)),
          "processes": lambda rng, least: rng.randint(1, 6)}
LIMITS = {"file size": resource.RLIMIT_FSIZE, "open files": resource.RLIMIT_NOFILE, "address space": resource.RLIMIT_AS,
          "processes": resource.RLIMIT_NPROC}


def limited(case, kind, value, arguments, user):
    """As another user: root's processes are never too many."""
    if user:
        hand_over(case.directory, user)
    ended = case.run(arguments, limits=[(LIMITS[kind], value)], user=user)
    if user:
        hand_over(case.directory, 0)
    return ended


def hand_over(directory, user):
    for at, _, files in os.walk(directory):
        for path in [at] + [os.path.join(at, name) for name in files]:
            os.chown(path, user, user)


def check(case, ended, kind, value, undisturbed):
    what = f"{ended.command()} with {kind} of {value}"
    before = len(case.problems)
    case.check_ending(ended, {0, 2, 4} if kind == "memory" else {0, 4})
    if ended.status == 0 and kind == "memory" and ended.peak_bytes > value * trial.MEBIBYTE:
        case.wrong(f"a peak within {value} MiB", ended.shown(), what)
    if ended.status in (2, 4) and not ended.error:
        case.wrong("a message", ended.shown(), what)
    if "Too many open files" in ended.error and "free" in ended.error.split("Too many open files")[1].lower():
        case.wrong("advice that helps against too many open files", ended.error, what)
    found = small_job.outputs_in(case.directory)
    if differing := small_job.not_whole(found, undisturbed.outputs):
        case.wrong("outputs absent or whole", f"other bytes: {differing}", what)
    for problem in case.problems[before:]:
        problem["command"] = what


def check_again(case, limited_run, undisturbed, inputs, what):
    ended = case.run(small_job.COMMAND)
    command = f"{ended.command()} after {what}, status {limited_run.status}"
    found = small_job.outputs_in(case.directory)
    if ended.status != 0 or found != undisturbed.outputs:
        case.wrong("the undisturbed outputs once the limit is gone", ended.shown(), command)
    if left := sorted(set(os.listdir(case.directory)) - set(inputs) - small_job.OUTPUTS):
        case.wrong("nothing left but outputs", f"{left}", command)
