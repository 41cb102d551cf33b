"""Random jobs on clouds of up to 30,000 points, each whole and cut in several ways: all outputs have to be the same.

Clouds: what the program generates, as points with normals, raw scans, or scenes of scanners, and the shapes of
`clouds` without normals, here and there with some points far off, doubled or moved to coordinates of a map. Jobs:
options drawn from all sections, and outputs of all formats. Cuts: those of `same_bytes`, the budget, and runs that are
killed at random times and resumed by other threads with another budget.
"""
import os
import random
import resource

import clouds
import same_bytes
import trial

SHORT, LONG = 12, 1_500
UNIT = "comparisons"
MADE = "made"  # directory of the outputs
FORMATS = ["ply"] * 4 + ["obj", "stl", "glb", "vtp", "ply.gz"]
GENERATED = ["sphere", "torus", "bumpy-torus", "plane", "double-wall", "cube", "two-components", "genus-3"]
SCENES = ["room", "frames", "house"]
MEMORY = ["256MiB", "512MiB", "2GiB"]
LONGEST_UNTIL_KILL = 1.5  # seconds

# (probability, choices of words to add)
OPTIONS = [
    (0.30, [["--cleaning"]]),
    (0.15, [["--outlier-sigma", "4"], ["--outlier-sigma", "8"]]),
    (0.10, [["--cluster-points", "20"], ["--cluster-points", "auto"]]),
    (0.10, [["--min-surfaceness", "0.15"]]),
    (0.15, [["--every", "2"], ["--every", "3"]]),
    (0.15, [["--crop=-0.5,-2,-2,0.8,2,2"]]),
    (0.05, [["--keep-strays"]]),
    (0.30, [["--normals", "estimate"]]),
    (0.20, [["--neighbors", "8"], ["--neighbors", "24"]]),
    (0.60, [["--orientation", rule] for rule in ("propagate", "ground", "inward", "up", "viewpoint", "none")]),
    (0.40, [["--levels", str(levels)] for levels in (1, 2, 4, 8)]),
    (0.25, [["--no-fill"]]),
    (0.15, [["--kernel", "triharmonic"]]),
    (0.10, [["--neighborhood", "1.2"], ["--neighborhood", "3.5"]]),
    (0.15, [["--max-edges", "12"], ["--max-edges", "200"]]),
    (0.10, [["--max-diameter", "inf"], ["--max-diameter", "0.3"]]),
    (0.10, [["--close-outer-border"]]),
    (0.10, [["--allow-intersections"]]),
    (0.10, [["--uniform-patches"]]),
    (0.20, [["--min-triangles", "0"], ["--min-triangles", "30"]]),
    (0.15, [["--no-attributes"]]),
    (0.20, [["--check-surface"]]),
    (0.15, [["--precision", "float"]]),
]
OF_PLY = [
    (0.20, [["--confidence"]]),
    (0.20, [["--vertex-quality"]]),
    (0.10, [["--tiles", "--tile-size", "0.7"]]),
    (0.10, [["--simplify", "0.3"], ["--simplify", "500"]]),
    (0.10, [["--tileset", f"{MADE}/levels"]]),
    (0.05, [["--format", "text"]]),
]
VIEWS = {"up": ["--up", "0.1,0.2,1"], "viewpoint": ["--viewpoint", "0.3,-4,5"]}

prepare = same_bytes.prepare


def attack(case):
    points = cloud(case)
    options, mesh = job(case.rng)
    reference = outcome(case, 0, points, options, mesh, Cut(case, len(points), whole=True))
    for number in range(1, 1 + case.rng.randint(1, 3)):
        if case.problems:
            return
        cut = Cut(case, len(points), whole=False)
        found = outcome(case, number, points, options, mesh, cut)
        if cut.kills and reference.status == found.status == 0:
            found.out = reference.out  # a run that was killed at its very end has little left to say
        case.counts["comparisons"] += 1
        case.counts[f"comparisons of {'errors' if reference.status else 'meshes'}"] += 1
        same_bytes.compare(case, reference, found, cut)


def cloud(case):
    """Rows of equal length: x, y, z, and a normal where the cloud has some."""
    rng = case.rng
    count = int(10 ** rng.uniform(2, 4.5))
    if rng.random() < 0.3:
        points = [p[:3] for p in clouds.KINDS[rng.choice(sorted(clouds.KINDS))](min(count, 5_000), rng)]
    else:
        points = generated(case, count)
    if rng.random() < 0.15:
        points += rng.choices(points, k=len(points) // 10)
    if rng.random() < 0.15:
        points += [(*clouds.STRAYS[rng.randrange(3)], *p[3:]) for p in rng.choices(points, k=3)]
    if rng.random() < 0.2:
        points = clouds.moved(points, rng.choice([1.0, 1e3, 1e-4]), (500_000.0, 5_000_000.0, 100.0))
    return points


def generated(case, count):
    rng = case.rng
    words = [rng.choice(GENERATED + SCENES), "--points", max(1_000, count), "--noise", rng.choice([0, 0, 0.1, 0.3, 0.6]),
             "--seed", rng.randint(1, 1000)]
    if words[0] not in SCENES:
        scans = ["--scans", rng.randint(1, 9), "--misregistration", rng.choice([0, 0.5, 2])]
        words += rng.choice([[], ["--density", "varying"], scans])
    path = case.directory / "generated.ply"
    trial.succeed([case.setup.program, "generate", *map(str, words), "-o", str(path)], case.directory)
    names, rows = clouds.read_ply(path.read_bytes())
    path.unlink()
    kept = [names.index(name) for name in clouds.PROPERTIES if name in names]
    return [tuple(row[k] for k in kept) for row in rows]


def job(rng):
    """(options, name of the mesh)"""
    ending = rng.choice(FORMATS)
    options = [word for probability, choices in OPTIONS + (OF_PLY if ending == "ply" else [])
               if rng.random() < probability for word in rng.choice(choices)]
    for rule, words in VIEWS.items():
        if rule in options:
            options += words
    if rng.random() < 0.2:
        options += ["--picture", f"{MADE}/mesh.png"]
    return options, f"{MADE}/mesh.{ending}"


class Cut(same_bytes.Cut):
    """How the work is cut, with how much memory, and whether a run before was killed."""

    def __init__(self, case, count, whole):
        super().__init__(case, count, whole)
        rng = case.rng
        self.memory = "2GiB" if whole else rng.choice(MEMORY)
        self.kills = 0 if whole or self.ranks or rng.random() < 0.6 else rng.choice([1, 1, 2, 4])

    def __str__(self):
        return f"{super().__str__()}, {self.memory}, {self.kills} kills before"

    def command(self, case, names, options, mesh):
        words = self.words(case, names, [*options, "--memory", self.memory])
        words[words.index("out.ply")] = mesh
        return words

    def with_other_means(self, rng, words):
        """The same command with other threads and another budget, which a resumption may have."""
        words = list(words)
        words[words.index("--threads") + 1] = str(rng.randint(1, 4))
        words[words.index("--memory") + 1] = rng.choice(MEMORY)
        return words


def outcome(case, number, points, options, mesh, cut):
    """The run's end; `mesh` of it are the digests of all outputs."""
    directory = case.directory / f"cut-{number}"
    (directory / MADE).mkdir(parents=True)
    words = cut.command(case, cut.write(directory, points), options, mesh)
    rng = random.Random(f"{case.setup.seed} {case.number} {number}")
    for _ in range(cut.kills):
        killed = trial.execute(cut.with_other_means(rng, words), directory, limits=[(resource.RLIMIT_CORE, 0)],
                               wall_seconds=rng.uniform(0, LONGEST_UNTIL_KILL))
        case.counts["kills"] += killed.timed_out
        if not killed.timed_out:  # it ended before: what follows would make the outputs anew, from nothing
            trial.clear(directory / MADE, set())
    ended = trial.execute(words, directory)
    ended.mesh = trial.contents(directory / MADE)
    if case.check_ending(ended, {0, 2, 3}) and ended.status == 0:
        case.counts["outputs"] += len(ended.mesh)
        if stays := [name for name in os.listdir(directory / MADE) if name.startswith(".") or name.endswith(".work")]:
            case.wrong("nothing left but outputs", str(stays), ended.command())
    elif ended.status in (2, 3):
        ended.mesh = {name: what for name, what in ended.mesh.items() if ".work" not in name}
        if ended.mesh:
            case.wrong("no output of a run that failed", str(sorted(ended.mesh)), ended.command())
    return ended
