"""What the families of attacks share: one trial and its findings, the program run under watch, and what lies in a
directory before and after."""
import collections
import dataclasses
import hashlib
import os
import pathlib
import random
import re
import resource
import shlex
import shutil
import stat
import struct
import subprocess
import tempfile
import threading
import time

MEBIBYTE = 1 << 20
PROGRAM = "orbweave"
CPU_SECONDS = 400.0   # a trial's program takes less, even where points spread over forty decades lie in one ball
WALL_SECONDS = 600.0  # and ends within this on a busy machine
NOBODY = 65534        # user id of attacks that must not write outside of their directory
STOPPED = 130        # exit status after a signal that asks to stop
ENVIRONMENT = {**os.environ, "NO_COLOR": "1", "LC_ALL": "C.UTF-8"}


@dataclasses.dataclass
class Setup:
    """What a family starts from; `shared` is a directory of its own that all of its trials read."""
    program: str
    data: pathlib.Path
    shared: pathlib.Path
    keep: pathlib.Path
    seed: int
    prepared: object = None


@dataclasses.dataclass
class Ended:
    """A run of the program that ended, however it did. `status` is negative where a signal ended it."""
    words: list
    status: int
    out: bytes
    err: bytes
    cpu_seconds: float
    peak_bytes: int
    timed_out: bool

    @property
    def error(self):
        """The message that the program ended with; empty where there is none."""
        at = self.err.rfind(b"orbweave: error:")
        return self.err[at:].decode(errors="replace").splitlines()[0] if at >= 0 else ""

    def command(self):
        return shlex.join(os.fsdecode(word) for word in self.words)

    def shown(self):
        ending = "did not end, killed" if self.timed_out else f"status {self.status}"
        return f"{ending}, {self.cpu_seconds:.1f} s of CPU, {self.peak_bytes / MEBIBYTE:.0f} MiB: " \
               f"{(self.error or self.err.decode(errors='replace').strip()[-600:])[:1200]}"


class Case:
    """One trial: its random numbers, its directory, what it counted and what it found wrong. Numbers follow from
    seed, family and number of the trial alone."""

    def __init__(self, setup, family, number, directory):
        self.setup, self.family, self.number, self.directory = setup, family, number, directory
        self.rng = random.Random(f"{setup.seed} {family} {number}")
        self.counts = collections.Counter()
        self.problems = []

    def run(self, arguments, **watch):
        return execute([self.setup.program, *arguments], self.directory, **watch)

    def wrong(self, expected, found, command=""):
        """Notes a finding, and keeps the directory as it lies."""
        kept = self.setup.keep / f"{self.family}-{self.setup.seed}-{self.number}-{len(self.problems)}"
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(self.directory, kept, symlinks=True, ignore_dangling_symlinks=True,
                        ignore=lambda at, names: [n for n in names if not _is_plain(os.path.join(at, n))])
        self.problems.append({"family": self.family, "seed": self.setup.seed, "number": self.number,
                              "command": command, "expected": expected, "found": found, "kept": str(kept)})

    def check_ending(self, ended, allowed, budget_bytes=None):
        """Status, time, memory and form of the message; returns whether all are right."""
        before = len(self.problems)
        command = ended.command()
        if ended.timed_out or ended.cpu_seconds > CPU_SECONDS:
            self.wrong(f"an end within {CPU_SECONDS:.0f} s of CPU", ended.shown(), command)
        elif ended.status not in allowed:
            self.wrong(f"exit status of {sorted(allowed)}", ended.shown(), command)
        if budget_bytes and ended.peak_bytes > budget_bytes:
            self.wrong(f"at most {budget_bytes / MEBIBYTE:.0f} MiB", ended.shown(), command)
        if complaint := unreadable(ended.err):
            self.wrong("a message that can be read", f"{complaint}: {ended.err[-400:]!r}", command)
        return len(self.problems) == before


def _is_plain(path):
    mode = os.lstat(path).st_mode
    return stat.S_ISREG(mode) or stat.S_ISDIR(mode) or stat.S_ISLNK(mode)


def unreadable(err):
    """What keeps a terminal or a log from showing the messages; empty where nothing does."""
    try:
        text = err.decode()
    except UnicodeDecodeError as error:
        return f"not UTF-8 ({error.reason})"
    control = re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]", text)
    return f"control character {control.group()!a}" if control else ""


class Launcher:
    """Starts the program without loading its libraries each time (launcher.cpp); the kills and limits start it anew."""

    def __init__(self, path):
        self.process = subprocess.Popen([path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=ENVIRONMENT)

    def run(self, words, directory, user, wall_seconds):
        with tempfile.NamedTemporaryFile() as out, tempfile.NamedTemporaryFile() as err:
            strings = [directory, out.name, err.name, "" if user is None else str(user), str(int(wall_seconds)), *words]
            request = b"".join(os.fsencode(text) + b"\0" for text in strings)
            self.process.stdin.write(struct.pack("=I", len(request)) + request)
            self.process.stdin.flush()
            status, late, cpu_seconds, peak_kib = struct.unpack("=iidq", self.process.stdout.read(24))
            return Ended(words, status, out.read(), err.read(), cpu_seconds, peak_kib * 1024, bool(late))


launcher = None


def begin_worker(launcher_path):
    """For a process that runs trials: no core files of the program, and no machine that runs out of memory."""
    global launcher
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (6 << 30, resource.RLIM_INFINITY))
    launcher = Launcher(launcher_path) if launcher_path else None


def execute(words, directory, limits=(), user=None, wall_seconds=WALL_SECONDS):
    """Runs to the end, or kills after wall_seconds. limits: pairs of a resource and its soft limit."""
    def limit():
        for kind, value in limits:
            resource.setrlimit(kind, (value, value))

    words = [os.fspath(word) if isinstance(word, os.PathLike) else word for word in words]
    if launcher and not limits and os.path.basename(os.fsdecode(words[0])) == PROGRAM:
        return launcher.run(words, directory, user, wall_seconds)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(words, cwd=directory, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                   env=ENVIRONMENT, user=user, group=user, preexec_fn=limit if limits else None)
        late = threading.Event()
        alarm = threading.Timer(wall_seconds, lambda: (late.set(), process.kill()))
        alarm.start()
        _, status, usage = os.wait4(process.pid, 0)
        alarm.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return Ended(words, process.returncode, out.read(), err.read(), usage.ru_utime + usage.ru_stime,
                     usage.ru_maxrss * 1024, late.is_set())


def succeed(words, directory):
    """For what a family prepares: ends the attack where the program fails."""
    ended = execute(words, directory)
    if ended.status != 0:
        raise SystemExit(f"{ended.command()}: {ended.shown()}")
    return ended


def let_nobody_run(setup):
    """The user id that the program is to run as where it may not write anything but what it is given; None where this
    is not root. A program that nobody cannot reach is copied."""
    if os.getuid() != 0:
        return None
    try:
        execute([setup.program, "--version"], setup.shared, user=NOBODY)
    except PermissionError:
        setup.program = shutil.copy(setup.program, setup.shared)
    return NOBODY


def digest(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def contents(directory):
    """{path below the directory: digest of a file, target of a link, "directory", or the kind of anything else}."""
    found = {}
    for at, folders, files in os.walk(directory):
        for name in folders + files:
            path = os.path.join(at, name)
            found[os.path.relpath(path, directory)] = _content(path)
    return found


def _content(path):
    mode = os.lstat(path).st_mode
    if stat.S_ISLNK(mode):
        return "link to " + os.readlink(path)
    if stat.S_ISREG(mode):
        return digest(path)
    return "directory" if stat.S_ISDIR(mode) else "special"


def clear(directory, keep):
    """Removes all but the names in `keep`."""
    for entry in list(os.scandir(directory)):
        if entry.name in keep:
            continue
        if entry.is_dir(follow_symlinks=False):
            shutil.rmtree(entry.path)
        else:
            os.unlink(entry.path)


def wait_until(condition, seconds, step=0.001):
    """Whether the condition came true in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(step)
    return condition()
