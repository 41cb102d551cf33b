"""Clouds as lists of points (x, y, z, nx, ny, nz), made from random numbers, and the files that they are written to."""
import gzip
import math
import struct

GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))
UP = (0.0, 0.0, 1.0)
NO_DATA = -3.4028234663852886e38
PROPERTIES = ("x", "y", "z", "nx", "ny", "nz")


def sphere(count, rng):
    """Evenly spread, turned by a random angle."""
    turn, points = rng.random() * 6, []
    for i in range(count):
        z = 1 - 2 * (i + 0.5) / count
        q, angle = math.sqrt(1 - z * z), turn + i * GOLDEN_ANGLE
        normal = (q * math.cos(angle), q * math.sin(angle), z)
        points.append((*normal, *normal))
    return points


def torus(count, rng):
    points = []
    for _ in range(count):
        u, v = rng.random() * 2 * math.pi, rng.random() * 2 * math.pi
        normal = (math.cos(v) * math.cos(u), math.cos(v) * math.sin(u), math.sin(v))
        points.append((math.cos(u) + 0.4 * normal[0], math.sin(u) + 0.4 * normal[1], 0.4 * normal[2], *normal))
    return points


def _sheet(count, height):
    side = max(1, math.isqrt(count))
    return [(x / side, y / side, height(x, y), *UP) for x in range(side) for y in range(side)]


def grid(count, rng):
    return _sheet(count, lambda x, y: 0.0)


def plane(count, rng):
    return _sheet(count, lambda x, y: rng.random() * 0.1 / max(1, math.isqrt(count)))


def lattice(count, rng):
    edge = max(1, round(count ** (1 / 3)))
    return [(float(x), float(y), float(z), *UP) for x in range(edge) for y in range(edge) for z in range(edge)]


def layers(count, rng):
    return [(x + rng.random() * 0.1, y + rng.random() * 0.1, z * 0.05, 0.0, 0.0, 1.0 if z % 2 else -1.0)
            for z in range(1 + count // 100) for x in range(10) for y in range(10)]


def line(count, rng):
    return [(i * 1e-3, rng.gauss(0, 1e-4), rng.gauss(0, 1e-4), *UP) for i in range(count)]


def circle(count, rng):
    return [(math.cos(2 * math.pi * i / count), math.sin(2 * math.pi * i / count), 0.0, *UP) for i in range(count)]


def star(count, rng):
    return [((1 + 0.5 * (i % 2)) * x, (1 + 0.5 * (i % 2)) * y, z, *UP)
            for i, (x, y, z, *_) in enumerate(circle(count, rng))]


def spiral(count, rng):
    return [(math.sqrt(i) * math.cos(2 * math.sqrt(i)), math.sqrt(i) * math.sin(2 * math.sqrt(i)), 0.0, *UP)
            for i in range(count)]


def spot(count, rng):
    """A sphere with a third of its points in one dense spot."""
    few = count // 3
    dense = [(1 + rng.gauss(0, 1e-4), rng.gauss(0, 1e-4), rng.gauss(0, 1e-4), 1.0, 0.0, 0.0) for _ in range(few)]
    return sphere(count - few, rng) + dense if count > few else dense


def fractal(count, rng):
    corners = [(0, 0, 0), (1, 0, 0), (0.5, 0.866, 0), (0.5, 0.289, 0.816)]
    at, points = (0.3, 0.3, 0.3), []
    for _ in range(count):
        at = tuple((a + c) / 2 for a, c in zip(at, rng.choice(corners)))
        points.append((*at, *UP))
    return points


def noise(count, rng):
    return [(*(rng.random() for _ in range(3)), *(rng.gauss(0, 1) for _ in range(3))) for _ in range(count)]


def far_pair(count, rng):
    """Two spheres far from each other."""
    away, half = 10.0 ** rng.randint(1, 9), sphere(max(1, count // 2), rng)
    return half + moved(half, 1.0, (away, 0.0, 0.0))


KINDS = {f.__name__: f for f in (sphere, torus, grid, plane, lattice, layers, line, circle, star, spiral, spot, fractal,
                                 noise, far_pair)}
STRAYS = [(0.0, 0.0, 0.0), (1e7, 0.0, 0.0), (1e18, 0.0, 0.0), (NO_DATA,) * 3, (1e38, -1e38, 0.0), (-1e5, 3.0, 1e5),
          (1e300, 0.0, 0.0)]


def moved(points, scale, offset):
    return [(*(scale * p[k] + offset[k] for k in range(3)), *p[3:]) for p in points]


def ply(points, form="binary_little_endian", normals=True):
    """The bytes of a PLY file; doubles, in text with as many digits as they need. Points may be without normals."""
    names = PROPERTIES if normals and all(len(p) == len(PROPERTIES) for p in points) else PROPERTIES[:3]
    header = f"ply\nformat {form} 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property double {name}\n" for name in names) + "end_header\n"
    if form == "ascii":
        return header.encode() + _lines((p[:len(names)] for p in points), " ")
    record = struct.Struct(("<" if "little" in form else ">") + f"{len(names)}d")
    return header.encode() + b"".join(record.pack(*p[:len(names)]) for p in points)


def read_ply(data):
    """(names of the properties, rows) of points in little-endian binary numbers."""
    letters = {"double": "d", "float": "f", "uchar": "B", "ushort": "H", "uint": "I", "char": "b", "short": "h", "int": "i"}
    header, _, body = data.partition(b"end_header\n")
    properties = [line.split()[1:] for line in header.decode().splitlines() if line.startswith("property ")]
    rows = struct.iter_unpack("<" + "".join(letters[kind] for kind, _ in properties), body)
    return [name for _, name in properties], list(rows)


def csv(points):
    return (",".join(PROPERTIES) + "\n").encode() + _lines(points, ",")


def _lines(rows, separator):
    return b"".join(separator.join(map(repr, row)).encode() + b"\n" for row in rows)


def xyz(points):
    return _lines(points, " ")


def pts(points):
    rows = (f"{p[0]!r} {p[1]!r} {p[2]!r} {i % 2048} {i % 256} 7 9\n" for i, p in enumerate(points))
    return f"{len(points)}\n".encode() + "".join(rows).encode()


def ptx(points):
    header = f"{len(points)}\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    return header.encode() + _lines(((*p[:3], 0.5) for p in points), " ")


def pcd(points, data="ascii"):
    header = "VERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 8 8 8 8 8 8\nTYPE F F F F F F\n" \
             f"COUNT 1 1 1 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n" \
             f"POINTS {len(points)}\nDATA {data}\n"
    if data == "ascii":
        return header.encode() + _lines(points, " ")
    if data == "binary":
        return header.encode() + b"".join(struct.pack("<6d", *p) for p in points)
    columns = b"".join(struct.pack(f"<{len(points)}d", *column) for column in zip(*points))
    packed = _lzf_literals(columns)
    return header.encode() + struct.pack("<II", len(packed), len(columns)) + packed


def _lzf_literals(data):
    """LZF without any matches: runs of up to 32 bytes behind their length less one."""
    return b"".join(bytes([len(run) - 1]) + run for run in (data[i:i + 32] for i in range(0, len(data), 32)))


def las(points, minor):
    """Version 1.`minor`, point format 0, millionths of a unit."""
    size = {0: 227, 1: 227, 2: 227, 3: 235, 4: 375}[minor]
    low, high = ([f(p[k] for p in points) for k in range(3)] for f in (min, max))
    head = struct.pack("<4sHHIHH8sBB32s32sHHHIIBHI5I", b"LASF", 0, 0, 0, 0, 0, bytes(8), 1, minor, b"soak", b"soak", 1,
                       2020, size, size, 0, 0, 20, len(points), len(points), 0, 0, 0, 0)
    head += struct.pack("<12d", 1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0, *(v for pair in zip(high, low) for v in pair))
    head = head.ljust(size, b"\0")
    if minor == 4:
        head = head[:247] + struct.pack("<QQ", len(points), len(points)) + head[263:]
    rows = (struct.pack("<iiiHBBbBH", *(round(v * 1e6) for v in p[:3]), i % 65536, 0x09, i % 32, 0, 0, 1)
            for i, p in enumerate(points))
    return head + b"".join(rows)


def gzipped(data):
    return gzip.compress(data, mtime=0)
