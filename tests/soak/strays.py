"""Random clouds with a stray point at 10^k extents, each in three cuts.

For k from 2 to 38 the mesh file is the one of the cloud without the stray, byte for byte. A stray one or ten extents
away is a point like any other: there, with radii given, the triangles of all other points are the same. A stray may be
several: up to three points near each other, or as many in different places.

One trial in MANY_EVERY has more points than are counted one by one, on both sides of a power of two, most on one: cells as
wide as the stray makes them then hold parts of the cloud of any size.
"""
import math
import struct

import clouds
import same_bytes
import trial

SHORT, LONG = 60, 10_000
UNIT = "clouds with strays"
POINTS = (40, 200)
SURFACES = ("sphere", "torus", "grid", "plane", "lattice", "layers", "circle", "star", "spiral", "spot", "fractal",
            "noise")
CUTS = 3
MANY_EVERY = 199
MANY_POINTS = (1 << 18) + 5000


def prepare(setup):
    return None


def attack(case):
    rng = case.rng
    many = case.number % MANY_EVERY == MANY_EVERY // 2
    exponent = case.number % 39
    if many:
        points, extent, axis = straddling_sphere(rng)
        exponent = max(exponent, 2)
        # Along one axis: bounds remain narrow along the others.
        strays = [tuple(c + (extent * (10.0 ** exponent + 1) if k == axis else 0) for k, c in enumerate(points[0]))]
    else:
        points, extent = surface(rng)
        strays = placed_strays(rng, points, extent, exponent)
    options = ["--memory", "256MiB"]
    if exponent < 2 or rng.random() < 0.3:
        radius = extent * rng.uniform(1.0, 3.0) / math.sqrt(len(points))
        options += ["--radii", repr(radius)]
    if exponent < 2 or rng.random() < 0.5:
        options += ["--no-fill"]
    expected = outcome(case, "alone", points, options, chunk=same_bytes.MANY)
    with_strays = points + strays
    rng.shuffle(with_strays)
    for number in range(CUTS):
        chunk = same_bytes.MANY if number == 0 else max(1, int(len(points) / 10 ** rng.uniform(0.2, 0.9)))
        found = outcome(case, f"cut-{number}", with_strays, options, chunk)
        compare(case, expected, found, exponent)
        if case.problems:
            return
    case.counts[UNIT] += 1
    case.counts["of them without a mesh" if expected.status else "of them meshes"] += 1


def surface(rng):
    """(points, largest extent of their box), somewhere and of some size that coordinates resolve."""
    count = int(math.exp(rng.uniform(*map(math.log, POINTS))))
    points = clouds.KINDS[rng.choice(SURFACES)](count, rng)
    kind = rng.random()
    scale = 1.0 if kind < 0.5 else 10.0 ** rng.randint(-6, 6)
    offset = [0.0] * 3 if kind < 0.6 else [scale * rng.uniform(-1e4, 1e4) for _ in range(3)]
    points = clouds.moved(points, scale, offset)
    return points, max(max(p[k] for p in points) - min(p[k] for p in points) for k in range(3))


def straddling_sphere(rng):
    """(points, extent, axis): a sphere of which 0.01 to 10 % lie beyond a power of two along an axis."""
    center = [0.0] * 3
    axis = rng.randrange(3)
    plane, side = rng.choice((0.0, 0.0, 1.0, -4.0, 1024.0)), rng.choice((-1, 1))
    center[axis] = plane + side * (1 - 2 * 10 ** rng.uniform(-4, -1))
    points = []
    for i in range(MANY_POINTS):
        z = 1 - 2 * (i + 0.5) / MANY_POINTS
        q, t = math.sqrt(1 - z * z), i * 2.399963229728653
        n = (q * math.cos(t), q * math.sin(t), z)
        points.append((*(center[k] + n[k] for k in range(3)), *n))
    return points, 2.0, axis


def placed_strays(rng, points, extent, exponent):
    """Points 10^exponent extents away from the cloud, which is far more than their distances if they are a group."""
    lone = rng.random() < 0.7
    count = 1 if lone or exponent < 2 else rng.randint(2, 3)
    together = rng.random() < 0.5
    first = direction(rng)
    strays = []
    for _ in range(count):
        towards = first if together else direction(rng)
        at = [points[0][k] + extent * (10.0 ** exponent + 1) * towards[k] for k in range(3)]
        strays.append((*(a * (1 + 1e-9 * rng.random()) for a in at), *clouds.UP))
    return strays


def direction(rng):
    """Of length one by its largest coordinate, as extents are."""
    towards = [rng.uniform(-1, 1) for _ in range(3)]
    longest = max(map(abs, towards))
    return [t / longest for t in towards]


def outcome(case, name, points, options, chunk):
    directory = case.directory / name
    directory.mkdir()
    (directory / "scan.ply").write_bytes(clouds.ply(points))
    words = ["reconstruct", "scan.ply", "-o", "out.ply", "--chunk-points", str(chunk), "--threads", "1", "--progress",
             "none", *options]
    ended = trial.execute([case.setup.program, *words], directory)
    case.check_ending(ended, {0, 2, 3} if "--radii" in options else {0, 3})
    mesh = directory / "out.ply"
    ended.mesh = mesh.read_bytes() if mesh.exists() else None
    return ended


def compare(case, expected, found, exponent):
    same = (expected.mesh == found.mesh if exponent >= 2 else
            expected.mesh is None or triangles(expected.mesh) == triangles(found.mesh or b""))
    if expected.status != found.status and (exponent >= 2 or expected.status == 0):
        case.wrong(f"status {expected.status}", found.shown(), found.command())
    elif not same:
        case.wrong(f"the mesh without the stray at 1e{exponent} extents", found.shown(),
                   f"{expected.command()}\n            {found.command()}")


def triangles(mesh):
    """The triangles of a binary PLY file that the program wrote, as sets of positions in their order of turning."""
    header, _, body = mesh.partition(b"end_header\n")
    if not header:
        return set()
    lines = header.decode().splitlines()
    counts = [int(text.split()[2]) for text in lines if text.startswith("element")]
    vertex_lines = lines[lines.index(next(t for t in lines if t.startswith("element vertex"))) + 1:
                         lines.index(next(t for t in lines if t.startswith("element face")))]
    sizes = {"double": "d", "float": "f", "uchar": "B", "int": "i", "uint": "I", "ushort": "H"}
    row = struct.Struct("<" + "".join(sizes[text.split()[1]] for text in vertex_lines))
    positions = [row.unpack_from(body, i * row.size)[:3] for i in range(counts[0])]
    at, found = counts[0] * row.size, set()
    face = struct.Struct("<Biiii" if "property int hole" in lines else "<Biii")
    for _ in range(counts[1]):
        corners = face.unpack_from(body, at)[1:4]
        at += face.size
        first = min(range(3), key=lambda k: positions[corners[k]])
        found.add(tuple(positions[corners[(first + k) % 3]] for k in range(3)))
    return found
