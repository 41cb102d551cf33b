#!/usr/bin/env python3
"""What formats keep: a scan in UTM with 16-bit colours, intensities, classes and GPS times goes through
every format of meshes, and each file is read by orbweave, Open3D, MeshLab and CGAL. Prints a table
for docs/results/formats.md.

Every vertex is held against its point of the scan: the largest distance, in units of the spacing, and
whether colours and other attributes are those of that point. Which point that is tell the coordinates
that orbweave reads, and the order of the vertices; where a program changes that, the nearest one. Needs python3-open3d,
python3-scipy, meshlab, xvfb and the programs of the build (CGAL: libcgal-dev).

usage: bench/quality/round_trip.py [BUILD_DIRECTORY]
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import interpreter

interpreter.need("numpy", "scipy", "open3d")
import numpy
import open3d
from scipy.spatial import cKDTree

open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
ROOT = pathlib.Path(__file__).resolve().parents[2]
TRUTH = numpy.dtype([("xyz", "<f8", 3), ("gps_time", "<f8"), ("rgb", "<u2", 3), ("intensity", "<u2"),
                     ("classification", "<u2")])
ATTRIBUTES = ("intensity", "classification", "gps_time")
PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4",
             "float": "<f4", "double": "<f8", "int64": "<i8"}


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def origin_beside(file):
    shift = file.with_name(file.name + ".shift.txt")
    if not shift.exists():
        return numpy.zeros(3)
    name, x, y, z, scale = shift.read_text().splitlines()[-1].split(";")[:5]
    assert float(scale) == 1.0
    return -numpy.array([float(x), float(y), float(z)])


class Read:
    """What a program finds in a file: vertices, colours of 0 to 255 or None, other attributes by name."""

    def __init__(self, xyz, rgb=None, attributes=None, names=()):
        self.xyz, self.rgb, self.attributes, self.names = xyz, rgb, attributes or {}, names


def by_orbweave(program, file, scratch):
    """As a table of text. The program adds the origin beside a file itself: here it is taken off again."""
    table = scratch / "read.csv"
    run(program, "convert", file, table)
    rows = numpy.genfromtxt(table, delimiter=",", names=True)
    xyz = numpy.stack([rows["x"], rows["y"], rows["z"]], 1) - origin_beside(file)
    has_colors = "red" in rows.dtype.names
    rgb = numpy.stack([rows[c] for c in ("red", "green", "blue")], 1) if has_colors else None
    own = [name for name in rows.dtype.names if name not in ("x", "y", "z", "red", "green", "blue")]
    return Read(xyz, rgb, {name: rows[name] for name in own}, own)


def by_open3d(file):
    mesh = open3d.io.read_triangle_mesh(str(file))
    rgb = numpy.asarray(mesh.vertex_colors) * 255 if mesh.has_vertex_colors() else None
    attributes = {}
    if file.suffix == ".ply":
        points = open3d.t.io.read_point_cloud(str(file)).point
        for name in ATTRIBUTES:
            for stored in (name, "scalar_" + name):
                if stored in points:
                    attributes[name] = points[stored].numpy().ravel()
    return Read(numpy.asarray(mesh.vertices), rgb, attributes, list(attributes))


def ply_rows(file):
    data = file.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    vertex = header[header.index("element vertex"):].split("element face")[0]
    fields = [(name, PLY_TYPES[kind]) for kind, name in re.findall(r"^property (\w+) (\w+)$", vertex, re.M)]
    return numpy.frombuffer(data, numpy.dtype(fields), int(vertex.split()[2]), end)


def by_meshlab(file, scratch):
    """MeshLab holds single floats; what it has read is written as PLY."""
    copy = scratch / "meshlab.ply"
    copy.unlink(missing_ok=True)
    subprocess.run(["xvfb-run", "-a", "meshlabserver", "-i", str(file), "-o", str(copy), "-m", "vc"],
                   capture_output=True, check=False)
    if not copy.exists():
        return None
    rows = ply_rows(copy)
    xyz = numpy.stack([rows[axis].astype(float) for axis in "xyz"], 1)
    rgb = numpy.stack([rows[c] for c in ("red", "green", "blue")], 1) if "red" in rows.dtype.names else None
    if rgb is not None and (rgb == rgb[0]).all():
        rgb = None  # MeshLab's own grey
    return Read(xyz, rgb)


def by_cgal(program, file, scratch):
    dump = scratch / "cgal.bin"
    words = run(program, file, dump).split()
    count, has_colors = int(words[0]), words[2] == "1"
    data = dump.read_bytes()
    xyz = numpy.frombuffer(data, "<f8", 3 * count).reshape(-1, 3)
    rgb = numpy.frombuffer(data, "u1", 3 * count, 24 * count).reshape(-1, 3) if has_colors else None
    names = [word.split(":")[-1].removeprefix("scalar_") for word in words[3:]]
    return Read(xyz, rgb, None, [name for name in ATTRIBUTES if name in names])


def judge(read, origin, truth, nearest, spacing, center):
    """The cells of a row: error, colours, attributes. `nearest`: of each vertex its point."""
    points = truth[nearest]
    distance = numpy.linalg.norm(read.xyz + (origin - center) - (points["xyz"] - center), axis=1)
    error = f"{distance.max() / spacing:.1e}" if distance.max() > 0 else "0"
    if read.rgb is None:
        colors = "none"
    else:
        expected = (points["rgb"].astype(int) + 128) // 257
        wrong = int((numpy.rint(read.rgb).astype(int) != expected).any(1).sum())
        colors = "equal" if wrong == 0 else f"{wrong} differ"
    equal = [name for name in ATTRIBUTES
             if name in read.attributes and (read.attributes[name] == points[name]).all()]
    named = [name for name in ATTRIBUTES if name in read.names and name not in read.attributes]
    kept = ", ".join(equal) + (" equal" if equal else "")
    kept += ("; " if equal and named else "") + (", ".join(named) + " named" if named else "")
    return len(read.xyz), error, colors, kept or "none"


def joined(reads):
    reads = [read for read in reads if read is not None]
    if not reads:
        return None
    whole = all(read.rgb is not None for read in reads)
    names = [name for name in reads[0].attributes if all(name in read.attributes for read in reads)]
    return Read(numpy.concatenate([read.xyz for read in reads]),
                numpy.concatenate([read.rgb for read in reads]) if whole else None,
                {name: numpy.concatenate([read.attributes[name] for read in reads]) for name in names},
                reads[0].names)


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release") / "bin"
    program = build / "orbweave"
    scratch = pathlib.Path(tempfile.mkdtemp(prefix="round_trip."))
    run(build / "utm_scan", scratch / "scan.laz", scratch / "truth")
    truth = numpy.fromfile(scratch / "truth", TRUTH)
    center = truth["xyz"].mean(0)
    tree = cKDTree(truth["xyz"] - center)
    spacing = json.loads(run(program, "inspect", scratch / "scan.laz", "--json"))["spacing"]
    origin_given = ("--origin", "448000,4511000,1300")
    jobs = {"PLY": ("m.ply",), "PLY, origin given": ("g.ply", *origin_given),
            "PLY, float": ("f.ply", "--precision", "float"), "OBJ": ("m.obj",),
            "OBJ, origin given": ("g.obj", *origin_given), "STL": ("m.stl",), "tiles": ("t.ply", "--tiles", "--chunk-points", "6000"),
            "tiles, float": ("u.ply", "--tiles", "--chunk-points", "6000", "--precision", "float"),
            "PLY of convert": None}
    print(f"{len(truth)} points, {spacing:.3g} m apart, largest coordinate {truth['xyz'].max():.0f} m\n")
    print("| format | read by | vertices | largest error, spacings | colours | attributes |")
    print("|---|---|---|---|---|---|")
    for name, words in jobs.items():
        if words is None:
            run(program, "convert", scratch / "scan.laz", scratch / "c.ply")
            mesh = scratch / "c.ply"
        else:
            mesh = scratch / words[0]
            run(program, "reconstruct", scratch / "scan.laz", "--up", "0,0,1", "--no-fill", "-o", mesh, *words[1:])
        tiles = mesh.with_suffix(".tiles")
        files = sorted(tiles.glob("*.ply")) if "tiles" in name else [mesh]
        origin = origin_beside(mesh)
        readers = {"orbweave": lambda file: by_orbweave(program, file, scratch), "Open3D": by_open3d,
                   "MeshLab": lambda file: by_meshlab(file, scratch),
                   "CGAL": lambda file: by_cgal(build / "bench_read_cgal", file, scratch)}
        if words is None:
            readers.pop("Open3D")  # reads clouds by another call
        own = None
        for reader, read_file in readers.items():
            read = joined([read_file(file) for file in files])
            if read is None:
                print(f"| {name} | {reader} | not read | | | |", flush=True)
                continue
            nearest = tree.query(read.xyz + (origin - center))[1]
            own = nearest if reader == "orbweave" else own
            has_own_order = mesh.suffix == ".stl" or (reader == "Open3D" and mesh.suffix == ".obj")
            if not has_own_order and len(own) == len(nearest):
                nearest = own
            print("| {} | {} | {:,} | {} | {} | {} |".format(
                name, reader, *judge(read, origin, truth, nearest, spacing, center)), flush=True)
    shutil.rmtree(scratch)


if __name__ == "__main__":
    main()
