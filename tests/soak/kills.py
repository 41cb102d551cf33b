"""Kills a job of every stage with every signal, and lets the same command go on until it ends.

A trial is a round: some six signals at moments drawn from the stages of an undisturbed run, its start and the removal
of its work directory, each later in the job than the one before, at a random time within the stage; every start but
the first is a resumption, some with other threads, with another budget or with packed results. Then the same command
runs to the end. Two jobs in six write tiles, by chunk or by the cells of a map.

Right is: after every signal an output is absent or whole, and a signal that asks to stop ends in status 130, without a
mesh before the export; results and documents that are committed when a run is killed are the same files when the next
one is killed or ends, unless a later stage was complete by then; at the end mesh and picture have the bytes of the
undisturbed run, the report the same mesh and holes, and nothing is left but outputs.
"""
import os
import shutil
import signal
import time

import small_job
import trial

SHORT, LONG = 7, 350
UNIT = "kills"
SIGNALS_PER_ROUND = 6
ASKS_TO_STOP = {signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGXCPU, signal.SIGUSR1, signal.SIGUSR2,
                signal.SIGALRM}  # the last one at once
IGNORED = {signal.SIGPIPE, signal.SIGCONT}  # the run goes on
SIGNALS = [signal.SIGKILL] * 3 + [signal.SIGTERM, signal.SIGINT] * 2 + [
    signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT, signal.SIGSEGV, signal.SIGPIPE, signal.SIGXCPU, signal.SIGBUS,
    signal.SIGALRM, signal.SIGUSR1, signal.SIGCONT]
RAW_STAGES = ["raw", "raw_outliers", "raw_merged", "raw_normals", "raw_smooth_1", "raw_thinned", "raw_patches"]
DOCUMENTS = {"partition.json.xxh3", "ended.json.xxh3", "moves.json.xxh3"}  # written last
VARIED = [[]] * 3 + [["--threads", "1"], ["--threads", "3"], ["--memory", "300MiB"], ["--set", "run.compress=true"]]


def prepare(setup):
    inputs = small_job.write(setup.program, setup.shared)
    return inputs, [(form, small_job.Undisturbed(setup.program, setup.shared, form))
                    for form in ([], small_job.TILES, small_job.MAP_TILES)]


def attack(case):
    inputs, forms = case.setup.prepared
    form, undisturbed = case.rng.choices(forms, weights=(4, 1, 1))[0]
    for name in inputs:
        shutil.copy2(case.setup.shared / name, case.directory)
    history, committed, going_on = [], {}, True
    for moment in moments(case.rng, list(undisturbed.seconds)):
        going_on = disturb(case, undisturbed, moment, form, history)
        committed = check_committed(case, committed, history)
        if not going_on:
            break
    ended = case.run([*small_job.COMMAND, *form]) if going_on else None
    if ended and ended.status != 0:
        case.wrong(f"the same command to end after {history}", ended.shown(), ended.command())
    check_committed(case, committed, history)
    check_end(case, undisturbed, inputs, history)


def moments(rng, order):
    """Of a round: in the order in which the job comes to them; a start may come again and again."""
    taken = rng.sample(order, min(SIGNALS_PER_ROUND, len(order)))
    later = sorted((m for m in taken if m != small_job.START), key=order.index)
    for _ in range(len(taken) - len(later)):
        later.insert(rng.randrange(len(later) + 1), small_job.START)
    return later


def disturb(case, undisturbed, moment, form, history):
    """A run with a signal; returns whether the job is to go on."""
    number, twice = case.rng.choice(SIGNALS), case.rng.random() < 0.3
    delay = case.rng.random() * undisturbed.seconds[moment]

    def send(process):
        if number == signal.SIGCONT:
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.05)
        process.send_signal(number)
        if twice and number == signal.SIGINT:
            time.sleep(0.01)
            process.send_signal(number)

    arguments = [*form, *case.rng.choice(VARIED)]
    ended, reached = small_job.disturbed(case.setup.program, case.directory, moment, delay, send, arguments)
    if reached:
        case.counts["kills"] += 1
        case.counts[f"kills {signal.Signals(number).name}"] += 1
    history.append((moment, signal.Signals(number).name, ended.status, *arguments))
    check_signal(case, undisturbed, number if reached else None, ended, history)
    return ended.status != 0


def check_signal(case, undisturbed, number, ended, history):
    """What a run with a signal (None: it ended before) may end with, and leave."""
    allowed = {0} if number is None else {0, -number}
    if number in IGNORED and history[-1][0] != small_job.START:  # at the start it does not yet listen
        allowed.remove(-number)
    if number in ASKS_TO_STOP:
        allowed.add(trial.STOPPED)
    command = f"{ended.command()}, then {history}"
    if ended.timed_out or ended.status not in allowed:
        case.wrong(f"exit status of {sorted(allowed)}", ended.shown(), command)
    found = small_job.outputs_in(case.directory)
    if differing := small_job.not_whole(found, undisturbed.outputs):
        case.wrong("outputs absent or whole", f"other bytes: {differing}", command)
    log = small_job.log_text(case.directory)
    if ended.status == trial.STOPPED and "mesh.ply" in found and log and "export: ends" not in log:
        case.wrong("no mesh after a stop before the export", "mesh.ply", command)


def committed_in(directory):
    """{(stage, file): inode} of what is committed."""
    found, work = {}, directory / "work"
    for stage in work.iterdir() if work.is_dir() else ():
        if stage.name == "tiles":  # belongs to the export, which starts over
            continue
        for entry in os.scandir(stage) if stage.is_dir() else ():
            if (entry.name.endswith(".h5") and not entry.name.startswith(".")) or entry.name in DOCUMENTS:
                found[stage.name, entry.name] = entry.stat().st_ino
    return found


def may_go(work, stage):
    """Whether results of the stage are no longer needed: a later one is complete."""
    if not work.is_dir() or (work / "ended.json").exists():
        return True
    if not any(work.iterdir()):  # all of it is removed but the directory
        return True
    if stage.endswith("_cut"):  # counts and bins, until the points are sorted
        return any((work / name / "partition.json").exists() for name in (stage[:-len("_cut")], "points"))
    if not stage.startswith("raw"):
        return False
    later = RAW_STAGES[RAW_STAGES.index(stage) + 1:]
    return (work / "points" / "partition.json").exists() or any((work / name / "ended.json").exists() for name in later)


def check_committed(case, before, history):
    """What is committed now; what was before may be gone when it is no longer needed, and is never made again."""
    now = committed_in(case.directory)
    for (stage, name), inode in before.items():
        if now.get((stage, name), inode) != inode:
            case.wrong("no committed result made again", f"{stage}/{name}", str(history))
        elif (stage, name) not in now and not may_go(case.directory / "work", stage):
            case.wrong("no committed result gone", f"{stage}/{name}", str(history))
    return now


def check_end(case, undisturbed, inputs, history):
    found, expected = small_job.outputs_in(case.directory), undisturbed.outputs
    if differing := [name for name in {**expected, **found} if found.get(name) != expected.get(name)]:
        case.wrong("the outputs of the undisturbed run", f"differing or absent: {differing}", str(history))
    if left := sorted(set(os.listdir(case.directory)) - set(inputs) - small_job.OUTPUTS):
        case.wrong("nothing left but outputs", f"{left}", str(history))
