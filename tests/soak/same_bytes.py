"""Random clouds, each cut in several ways: the mesh file, the exit status and the message have to be the same.

Clouds: known surfaces, shapes that break plans, random points and unions of these, with strays, duplicates, far and
tiny coordinates, or with hardly any points. Cuts: chunk size, threads, budget, order of the points, their split over
files, text instead of binary, several ranks where MPI is there.
"""
import os
import pathlib
import re
import shutil

import clouds
import trial

SHORT, LONG = 40, 750
UNIT = "comparisons"
MANY = 10 ** 9
CHUNKS = 1.7  # at most 10 to this power: each may have all points in its halo
RANKS_IN = 25  # one trial of so many has a cut with ranks
NAMES = re.compile(r"\bscan(_\d+)?\.(ply|csv|xyz)\b|\bchunk \d+|\b\d+ chunks?")
STAYS = " The work directory out.work stays; remove it."
RANK = re.compile(r"(?<=orbweave: error: )rank \d+ \([^)]*\): ")


def prepare(setup):
    """The program over MPI, where there is one and the means to start it."""
    program = pathlib.Path(setup.program).with_name("orbweave-mpi")
    return str(program) if program.exists() and shutil.which("mpirun") else None


def attack(case):
    points, options = cloud(case.rng), job_options(case.rng)
    reference = outcome(case, 0, points, options, Cut(case, len(points), whole=True))
    for number in range(1, 1 + case.rng.randint(2, 4)):
        if case.problems:
            return
        cut = Cut(case, len(points), whole=False)
        found = outcome(case, number, points, options, cut)
        case.counts["comparisons"] += 1
        case.counts[f"comparisons of {'errors' if reference.status else 'meshes'}"] += 1
        compare(case, reference, found, cut)


def cloud(rng):
    count = rng.randint(0, 10) if rng.random() < 0.15 else int(10 ** rng.uniform(1, 3))
    points = _shape(rng, count)
    if rng.random() < 0.2:
        points += clouds.moved(_shape(rng, max(1, count // 2)), 1.0, [rng.uniform(-3, 3) for _ in range(3)])
    if points and rng.random() < 0.15:
        points += rng.choices(points, k=rng.choice([1, 10, 100]))
    points = clouds.moved(points, *_placing(rng))
    if rng.random() < 0.2:
        points += [(*rng.choice(clouds.STRAYS), *clouds.UP) for _ in range(rng.choice([1, 1, 2, 30]))]
    return points


def _shape(rng, count):
    return list(clouds.KINDS[rng.choice(sorted(clouds.KINDS))](count, rng)) if count else []


def _placing(rng):
    """(scale, offset)"""
    kind = rng.random()
    if kind < 0.6:
        return 1.0, (0.0, 0.0, 0.0)
    if kind < 0.75:
        return 10.0 ** rng.randint(-3, 3), (500_000.0, 5_000_000.0, 100.0)
    if kind < 0.9:
        return 10.0 ** rng.randint(-12, 12), [rng.uniform(-10, 10) for _ in range(3)]
    return 10.0 ** rng.randint(-300, 300), (0.0, 0.0, 0.0)


def job_options(rng):
    options = ["--memory", rng.choice(["256MiB", "512MiB", "2GiB"])]
    if rng.random() < 0.2:
        options += ["--radii", rng.choice(["0.1", "0.3,0.6", "1e-3", "1e6", "0.05,0.1,0.2"])]
    elif rng.random() < 0.3:
        options += ["--levels", str(rng.randint(1, 3))]
    if rng.random() < 0.2:
        options += ["--normals", "estimate"]
    if rng.random() < 0.3:
        options += ["--no-fill"]
    if rng.random() < 0.1:
        options += rng.choice([["--clean"], ["--outlier-sigma", "4"], ["--merge-tolerance", "0.05"],
                               ["--thin-to-spacing", "0.1"], ["--smooth-radius", "0.3"]])
    return options


class Cut:
    """How the work is cut; the first one of a trial does it whole, by one thread, as the points lie."""

    def __init__(self, case, count, whole):
        rng = case.rng
        self.chunk = MANY if whole else max(1, int(count / 10 ** rng.uniform(0, CHUNKS)))
        self.threads = 1 if whole else rng.choice([1, 2, 5])
        self.shuffled = not whole and rng.random() < 0.5
        self.files = 1 if whole else rng.choice([1, 1, 2, 3])
        self.form = "binary_little_endian" if whole else rng.choice(
            ["binary_little_endian", "binary_little_endian", "binary_big_endian", "ascii"])
        with_ranks = not whole and case.setup.prepared and case.number % RANKS_IN == 0
        self.ranks = rng.choice([2, 3]) if with_ranks else 0
        self.order = rng.random()

    def __str__(self):
        return f"chunks of {self.chunk}, {self.threads} threads, {'shuffled, ' if self.shuffled else ''}" \
               f"{self.files} files, {self.form}, {self.ranks} ranks"

    def write(self, directory, points):
        """Returns the names of the files."""
        points = list(points)
        if self.shuffled:
            points.sort(key=lambda p: hash((self.order, p)))
        names = ["scan.ply"] if self.files == 1 else [f"scan_{k}.ply" for k in range(self.files)]
        for k, name in enumerate(names):
            share = points[k * len(points) // self.files:(k + 1) * len(points) // self.files]
            (directory / name).write_bytes(clouds.ply(share, self.form))
        return names

    def words(self, case, names, options):
        words = ["reconstruct", *names, "-o", "out.ply", "--chunk-points", str(self.chunk), "--threads",
                 str(self.threads), "--progress", "none", *options]
        if not self.ranks:
            return [case.setup.program, *words]
        return ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(self.ranks),
                case.setup.prepared, *words]


def outcome(case, number, points, options, cut):
    """The run's end; it also gets `mesh`, the digest of the mesh file."""
    directory = case.directory / f"cut-{number}"
    directory.mkdir()
    ended = trial.execute(cut.words(case, cut.write(directory, points), options), directory)
    mesh = directory / "out.ply"
    ended.mesh = trial.digest(mesh) if mesh.exists() else None
    lengths = {"--radii", "--smooth-radius"} & set(options)  # may be too large or too small for the scale
    if not case.check_ending(ended, {0, 2, 3} if lengths else {0, 3}):
        return ended
    # Of several processes, others may still be at work there.
    stays = {"out.work"} if cut.ranks and STAYS in ended.error else set()
    if ended.status == 3 and (left := [name for name in os.listdir(directory)
                                       if not name.startswith("scan") and name not in stays]):
        case.wrong("nothing left after bad input", str(left), ended.command())
    return ended


def compare(case, reference, found, cut):
    differing = [what for what, one, other in (
        ("status", reference.status, found.status), ("mesh", reference.mesh, found.mesh),
        ("words", words(reference), words(found))) if one != other]
    if differing:
        case.wrong(f"the same {', '.join(differing)}: {words(reference)}", f"with {cut}: {words(found)}",
                   f"{reference.command()}\n            {found.command()}")


def words(ended):
    """What the run said, without what a cut may change: names of files and chunks, who of several processes says it."""
    said = ended.out.decode(errors="replace") if ended.status == 0 else RANK.sub("", ended.error).replace(STAYS, "")
    return f"status {ended.status}: {NAMES.sub('_', said).strip().rstrip('.')}"
