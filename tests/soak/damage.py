"""Damages what an interrupted job stored, in every way that is known, and lets the same command go on.

A trial runs the job to a random moment, where it is killed (or to its end, its work directory kept), damages one or
two of the stored files, and starts the same command. Donors are work directories of the same job at other moments, of
the job with other options, and of another job.

Right is: status 0 with the outputs of the undisturbed run; where something stands in the way that the program did not
write (another file of the name, a directory, a link) or the word on the layout is damaged, status 2 or 4 with a message
that names it and what to do are right as well. What the program did not write is there afterwards as it was; a work
directory that stays for its sake is named.
"""
import os
import re
import shutil

import small_job
import trial

SHORT, LONG = 20, 2000
UNIT = "damages"
KEEP = ["--keep-work-dir"]
STRANGERS = ["notes.txt", "movie.mp4.part", "member.csv", ".notes.part", "ended.txt", "scan.ply", "000000.h5.bak",
             ".000001.h5.part~"]
ADVICE = re.compile(r"--fresh|--work-dir|remove|delete|move", re.I)


def prepare(setup):
    """Donors below the shared directory; the job itself lies in it."""
    inputs = small_job.write(setup.program, setup.shared)
    undisturbed = small_job.Undisturbed(setup.program, setup.shared)
    for name, other in (("older", {"radius": 1.1}), ("other_job", {"seed": 2})):
        directory = setup.shared / name
        directory.mkdir()
        small_job.write(setup.program, directory, **other)
        gather(setup, undisturbed, directory)
    return inputs, undisturbed


def gather(setup, undisturbed, directory):
    """Everything that the job stores at one moment or another, in `directory`/donor."""
    for moment in (*list(undisturbed.seconds)[1::3], None):
        if moment is None:
            trial.succeed([setup.program, *small_job.COMMAND, *KEEP], directory)
        elif not small_job.killed(setup.program, directory, moment, 0.5 * undisturbed.seconds[moment]):
            continue
        if (directory / "work").is_dir():
            shutil.copytree(directory / "work", directory / "donor", dirs_exist_ok=True)


def attack(case):
    inputs, undisturbed = case.setup.prepared
    for name in inputs:
        shutil.copy2(case.setup.shared / name, case.directory)
    arguments = KEEP if case.rng.random() < 0.3 else []
    interrupted(case, undisturbed, arguments)
    work = case.directory / "work"
    if not work.is_dir():
        return
    damage = Damage(case, work)
    for _ in range(case.rng.choice([1, 1, 2])):
        damage.one()
    case.counts["damages"] += len(damage.done)
    ended = case.run([*small_job.COMMAND, *arguments])
    check(case, ended, damage)
    check_outputs(case, undisturbed, inputs, ended, damage)


def interrupted(case, undisturbed, arguments):
    """A job that was killed somewhere, or that ended and kept its work directory."""
    order = list(undisturbed.seconds)
    moment = case.rng.choice(order[1:])
    if arguments and case.rng.random() < 0.3:
        case.run([*small_job.COMMAND, *arguments])
        return
    delay = case.rng.random() * undisturbed.seconds[moment]
    small_job.killed(case.setup.program, case.directory, moment, delay, arguments)


class Damage:
    """What is done to a work directory, and what of it the program must leave alone."""

    def __init__(self, case, work):
        self.case, self.rng, self.work = case, case.rng, work
        self.done, self.strangers, self.may_refuse = [], {}, False
        self.outside = case.setup.shared.parent / f"outside-{case.number}"

    def one(self):
        """Damages a file, of each kind of file with the same chance."""
        files = [path for path in sorted(self.work.rglob("*"))
                 if path.is_file() and not path.is_symlink() and path not in self.strangers]
        kinds = {}
        for path in files:
            kinds.setdefault(_kind(path, self.work), []).append(path)
        how = self.rng.choice([self.flip] * 3 + [self.truncate, self.empty, self.append, self.swap, self.swap,
                               self.other_stage, self.older, self.other_job, self.missing, self.missing_stage,
                               self.directory, self.link, self.stranger, self.part])
        if kinds:
            path = self.rng.choice(kinds[self.rng.choice(sorted(kinds))])
            if what := how(path):
                self.done.append(f"{how.__name__} {path.relative_to(self.work)}{'' if what is True else f' {what}'}")
                self.case.counts[f"damages {how.__name__}"] += 1
                self.may_refuse |= path.name == "orbweave-store.json" or self.has_no_proof()

    def has_no_proof(self):
        """Where the record is damaged, another damaged file may be anybody's."""
        of_record = ["orbweave-record." in what for what in self.done]
        return any(of_record) and not all(of_record)

    def flip(self, path):
        data = bytearray(path.read_bytes())
        for _ in range(self.rng.choice([1, 1, 8]) if data else 0):
            data[self.rng.randrange(len(data))] ^= 1 << self.rng.randrange(8)
        return self.overwrite(path, data)

    def truncate(self, path):
        data = path.read_bytes()
        return data and self.overwrite(path, data[:self.rng.randrange(len(data))])

    def empty(self, path):
        return self.overwrite(path, b"")

    def append(self, path):
        return self.overwrite(path, path.read_bytes() + self.rng.randbytes(self.rng.choice([1, 8, 4096])))

    def overwrite(self, path, data):
        """In place half of the time, else as another file, as tools that copy do."""
        if self.rng.random() < 0.5:
            path.unlink()
            self.may_refuse = True
        path.write_bytes(data)
        return True

    def swap(self, path):
        """With another of its stage."""
        others = [other for other in sorted(path.parent.iterdir())
                  if other.is_file() and other != path and other.suffix == path.suffix]
        if not others:
            return False
        other = self.rng.choice(others)
        aside = path.with_name("aside")
        path.rename(aside)
        other.rename(path)
        aside.rename(other)
        self.may_refuse = True
        return f"with {other.name}"

    def other_stage(self, path):
        """A file of another stage in its place, of the same name where there is one."""
        others = [other for other in sorted(self.work.rglob("*" + path.suffix))
                  if other.is_file() and other.parent != path.parent]
        same_name = [other for other in others if other.name == path.name]
        return self.copy_of(self.rng.choice(same_name or others), path) if others else False

    def older(self, path):
        """The same file, or the same stage, of an earlier run with other options."""
        return self.from_donor(path, "older")

    def other_job(self, path):
        return self.from_donor(path, "other_job")

    def from_donor(self, path, name):
        donor = self.case.setup.shared / name / "donor"
        source = donor / path.relative_to(self.work)
        if path.parent != self.work and source.parent.is_dir() and self.rng.random() < 0.2:
            shutil.rmtree(path.parent)
            shutil.copytree(source.parent, path.parent)
            self.may_refuse = True
            return "with its stage"
        return self.copy_of(source, path) if source.is_file() else False

    def copy_of(self, source, path):
        self.overwrite(path, source.read_bytes())
        return f"from {source.parent.name}/{source.name}"

    def missing(self, path):
        path.unlink()
        return True

    def missing_stage(self, path):
        if path.parent == self.work:
            return False
        shutil.rmtree(path.parent)
        self.strangers = {stranger: before for stranger, before in self.strangers.items()
                          if path.parent not in stranger.parents}
        return True

    def directory(self, path):
        """A directory of the user's in its place."""
        path.unlink()
        path.mkdir()
        self.may_refuse = True
        return self.add_stranger(path / "mine.txt")

    def link(self, path):
        """A link of the user's in its place, to the file moved elsewhere or to another."""
        self.outside.mkdir(exist_ok=True)
        target = self.outside / f"{len(self.done)}-{path.name}"
        shutil.copy(path, target)
        if self.rng.random() < 0.5:
            target.write_bytes(b"the user's own words\n")
        path.unlink()
        path.symlink_to(target)
        self.strangers[target] = trial.digest(target)
        self.may_refuse = True
        return True

    def stranger(self, path):
        return self.add_stranger(path.parent / self.rng.choice(STRANGERS))

    def part(self, path):
        """A folder of the user's with the name of a part file."""
        folder = path.parent / self.rng.choice([f".{path.name}.part", "notes.part", path.name + ".d"])
        if folder.exists():
            return False
        folder.mkdir()
        return self.add_stranger(folder / "mine.txt")

    def add_stranger(self, path):
        if path.exists():
            return False
        path.write_bytes(self.rng.randbytes(20))
        self.strangers[path] = trial.digest(path)
        return path.name


def _kind(path, work):
    """Results, part files, and every other file of a stage or of the work directory by its name."""
    name = re.sub(r"^\d+\.h5$", "result", path.name)
    name = "part" if name.endswith(".part") else name
    return str(path.parent.relative_to(work) / name)


def check(case, ended, damage):
    """Status, advice, strangers."""
    allowed = {0, 2, 4} if damage.may_refuse else {0}
    right = case.check_ending(ended, allowed)
    if right and ended.status != 0 and not ("work" in ended.error and ADVICE.search(ended.error)):
        case.wrong("a message that names the file and says what to do", f"{damage.done}: {ended.shown()}",
                   ended.command())
    elif not right:
        case.problems[-1]["found"] += f" after {damage.done}"
    for path, before in damage.strangers.items():
        if not path.is_file() or trial.digest(path) != before:
            case.wrong("what the user put there", f"changed or gone after {damage.done}: {path.name}", ended.command())
    shutil.rmtree(damage.outside, ignore_errors=True)


def check_outputs(case, undisturbed, inputs, ended, damage):
    found = small_job.outputs_in(case.directory)
    expected = undisturbed.outputs
    differing = small_job.not_whole(found, expected)
    if ended.status == 0:
        differing = [name for name in {**expected, **found} if found.get(name) != expected.get(name)]
    if differing:
        case.wrong("the outputs of the undisturbed run", f"status {ended.status}, differing: {differing} after "
                   f"{damage.done}", ended.command())
    left = set(os.listdir(case.directory)) - set(inputs) - small_job.OUTPUTS
    said = b"work" in ended.out + ended.err  # a file that was replaced may be the user's: it stays, with a word
    if ended.status != 0 or damage.strangers or said or ended.words[-1:] == KEEP:
        left.discard("work")
    # Who refuses to begin changes nothing; without the record nothing says any more whose a part file is.
    if ended.status != 0 or any("orbweave-record." in what for what in damage.done):
        left = {name for name in left if not name.endswith(".part")}
    if left:
        case.wrong("nothing left but outputs", f"{sorted(left)} after {damage.done}", ended.command())
