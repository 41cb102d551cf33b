"""Mutated files of every format, given to the commands that read them.

Seeds: small clouds and meshes made here and by the program, the seeds of the fuzz targets, small real samples where
they are at hand, poses. Right is: status 0, 2, 3 or 4 in bounded time and memory, a message that names the file, JSON
that parses, the inputs untouched, and nothing on disk but the outputs of a command that succeeded (and the work
directory of one that ran out of a resource).
"""
import gzip
import json
import os
import pathlib
import random

import clouds
import trial
from mutations import mutated

SHORT, LONG = 300, 50_000
UNIT = "inputs"
LARGEST_SEED = 100_000
BUDGET = 256 * trial.MEBIBYTE
FUZZ_SEEDS = {"fuzz_e57_source": "", "fuzz_gzip_source": ".txt.gz", "fuzz_las_source": "", "fuzz_laz_reader": "",
              "fuzz_mesh_reader": "", "fuzz_pcd_source": "", "fuzz_ply_source": "", "fuzz_ptx_source": "",
              "fuzz_text_source": ""}  # with what their names need behind them
MESHES = (".ply", ".obj", ".stl", ".glb")
READ = (".ply", ".gz", ".xyz", ".txt", ".csv", ".pts", ".ptx", ".pcd", ".las", ".laz", ".e57", ".stl", ".obj", ".glb",
        ".conf")
COMMANDS = ["inspect"] * 58 + ["json"] * 25 + ["reconstruct"] * 6 + ["convert"] * 5 + ["plan"] * 3 + ["other"] * 3
ODD_NAMES = ["scan\udcff", "scan \u00e9\u4e2d", "scan\n1", "scan'\"", "-scan", "scan" * 50, "scan\x1b[31m"]


def prepare(setup):
    """Writes every seed; returns their names."""
    write_own(setup)
    for folder, extension in FUZZ_SEEDS.items():
        for path in sorted((pathlib.Path(__file__).parents[1] / "fuzz" / "seeds" / folder).iterdir()):
            (setup.shared / f"{folder}-{path.name}{extension if path.suffix == '.gz' else ''}").write_bytes(
                path.read_bytes())
    for path in sorted(setup.data.glob("*/**/*")):
        if path.suffix in READ and path.stat().st_size <= LARGEST_SEED:
            (setup.shared / f"data-{path.parent.name}-{path.name}").write_bytes(path.read_bytes())
    return sorted(os.listdir(setup.shared))


def write_own(setup):
    points = clouds.sphere(80, random.Random(1))
    made = {f"own-{form}.ply": clouds.ply(points, form)
            for form in ("ascii", "binary_little_endian", "binary_big_endian")}
    made |= {f"own-{data}.pcd": clouds.pcd(points, data) for data in ("ascii", "binary", "binary_compressed")}
    made |= {f"own-1.{minor}.las": clouds.las(points, minor) for minor in range(5)}
    made |= {"own.xyz": clouds.xyz(points), "own.csv": clouds.csv(points), "own.pts": clouds.pts(points),
             "own.ptx": clouds.ptx(points), "own.ply.gz": clouds.gzipped(clouds.ply(points)),
             "own.xyz.gz": clouds.gzipped(clouds.xyz(points))}
    for name, data in made.items():
        (setup.shared / name).write_bytes(data)
    trial.succeed([setup.program, "generate", "sphere", "--points", "200", "--truth", "own-mesh.ply", "-o",
                   "own-generated.ply"], setup.shared)
    for mesh in ("own-mesh.obj", "own-mesh.stl", "own-mesh.glb"):
        trial.succeed([setup.program, "convert", "own-mesh.ply", mesh], setup.shared)
    trial.succeed([setup.program, "generate", "torus", "--points", "600", "--scans", "2", "--separate", "-o",
                   "own-scan.ply"], setup.shared)


def attack(case):
    name = case.rng.choice(case.setup.prepared)
    if case.rng.random() < 0.03:
        name = "own-scan.conf"
    target = placed(case, name)
    kind = "poses" if name.endswith(".conf") else case.rng.choice(COMMANDS)
    arguments, outputs = command(case, kind, target)
    before = trial.contents(case.directory)
    ended = case.run(arguments)
    case.counts["inputs"] += 1
    case.counts[f"inputs {_format(name)}"] += 1
    case.counts[f"status {ended.status}"] += 1
    if case.check_ending(ended, {0, 2, 3, 4}, BUDGET):
        check_words(case, ended, kind)
    check_disk(case, ended, before, outputs)


def _format(name):
    return pathlib.Path(name.removesuffix(".gz")).suffix.lstrip(".")


def placed(case, name):
    """Writes the mutated seed, one time in twenty under an odd name; returns its name."""
    rng, shared = case.rng, case.setup.shared
    data, other = (shared / name).read_bytes(), (shared / rng.choice(case.setup.prepared)).read_bytes()
    data = changed(name, data, other, rng)
    stem = rng.choice(ODD_NAMES)[:60] if rng.random() < 0.05 else "scan"
    target = stem + "".join(pathlib.Path(name).suffixes[-2 if name.endswith(".gz") else -1:])
    (case.directory / target).write_bytes(data)
    return target


def changed(name, data, other, rng):
    """Mutated; packed files inside or outside of their packing, E57 mostly with checksums that are right."""
    if name.endswith(".gz") and rng.random() < 0.5:
        try:
            return clouds.gzipped(mutated(gzip.decompress(data), rng, other))
        except (OSError, EOFError):
            return mutated(data, rng, other)
    data = mutated(data, rng, other)
    return with_page_checksums(data) if name.endswith(".e57") and rng.random() < 0.8 else data


CRC32C = []
for _value in range(256):
    for _ in range(8):
        _value = _value >> 1 ^ (0x82F63B78 if _value & 1 else 0)
    CRC32C.append(_value)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC32C[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def with_page_checksums(data, page=1024):
    """Whole pages of an E57 file, the length in its header and the checksum of each page made right."""
    data = bytearray(data[:len(data) // page * page])
    data[16:24] = len(data).to_bytes(8, "little") if data else b""
    for at in range(0, len(data), page):
        data[at + page - 4:at + page] = crc32c(data[at:at + page - 4]).to_bytes(4, "big")
    return bytes(data)


def command(case, kind, target):
    """(arguments, names that the command may leave)"""
    name = target if not target.startswith("-") else "./" + target
    rng, mesh = case.rng, target.endswith(MESHES)
    if kind == "inspect":
        return ["inspect", name], set()
    if kind == "json":
        return ["inspect", "--json", name], set()
    if kind == "poses":
        for k in range(2):
            scan = case.setup.shared / f"own-scan_{k}.ply"
            (case.directory / f"scan_{k}.ply").write_bytes(scan.read_bytes())
        return ["reconstruct", "scan_0.ply", "scan_1.ply", "--poses", name, "-o", "out.ply", "--memory", "256MiB",
                "--no-fill"], {"out.ply"}
    if kind == "reconstruct":
        return ["reconstruct", name, "-o", "out.ply", "--report", "out.json", "--memory", "256MiB", "--chunk-points",
                str(rng.choice([500, 10 ** 6]))], {"out.ply", "out.json", "out.html", "out.prj", "out.wkt"}
    if kind == "convert":
        out = "out" + rng.choice([".ply", ".xyz", ".csv", ".obj", ".stl"])
        return ["convert", name, out], {out, out + ".shift.txt", "out.prj", "out.wkt"}
    if kind == "other" and mesh:
        if rng.random() < 0.5:
            return ["fill", name, "-o", "out.ply", "--report", "out.json"], {"out.ply", "out.json", "out.html"}
        return ["compare", "--json", name, name], set()
    return ["plan", "--memory", "256MiB", name], set()


def check_words(case, ended, kind):
    if ended.status != 0:
        named = "scan" in ended.error or (ended.status == 2 and "out." in ended.error)
        if not named:
            case.wrong("a message that names the file", ended.shown(), ended.command())
    elif kind == "json" or "--json" in ended.words:
        check_json(case, ended)


def check_json(case, ended):
    def refuse(word):
        raise ValueError(f"{word} is no JSON")

    try:
        json.loads(ended.out, parse_constant=refuse)
    except ValueError as error:
        case.wrong("JSON", f"{error}: {ended.out[:300]!r}", ended.command())


def check_disk(case, ended, before, outputs):
    after = trial.contents(case.directory)
    if touched := sorted(name for name in before if after.get(name) != before[name]):
        case.wrong("inputs as they were", f"changed or gone: {touched}", ended.command())
    new = {name for name in after if name not in before and not
           (ended.status == 4 and name.split("/")[0] == "out.work")}
    if left := sorted(new - (outputs if ended.status == 0 else set())):
        case.wrong(f"nothing but outputs after status {ended.status}", f"left over: {left}", ended.command())
