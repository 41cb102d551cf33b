#!/usr/bin/env python3
"""One SHA-256 of the output however the work is cut.

Every cloud is reconstructed with chunks of 1,000 points, of 20,000 and with everything in one, with one, two
and five threads, with its points shuffled, and with its points dealt to several files. Raw scans go through
every clean-up stage, with estimated normals that the scanners or propagation orient. The exit status is 1 when
two outputs of a cloud differ.

usage: tests/soak/scans_same_bytes.py DATA_DIR [--only NAME] [--full]
"""
import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import interpreter  # noqa: E402

interpreter.need("numpy")

import numpy as np  # noqa: E402
import harness  # noqa: E402
from whole_jobs import sha256  # noqa: E402
from meshes import read_ply, write_cloud  # noqa: E402

EVERYTHING = 10 ** 12
# (name, file below DATA_DIR, mesh to be oriented?, radius or None for three automatic levels)
SCANS = [("bun_zipper", "stanford/bun_zipper.ply", True, 0.0015),
         ("dragon_vrip_res2", "stanford/dragon_vrip_res2.ply", True, 0.0011),
         ("lion", "points_normals/lion_takanawa_normals_rgb.ply", False, None),
         ("kitten", "points_normals/kitten.xyz", False, None)]
# (name, shape, points, noise in spacings)
SHAPES = [("torus 2M", "torus", 2_000_000, 0.0), ("torus 200k noise 0.3", "torus", 200_000, 0.3),
          ("double wall", "double-wall", 100_000, 0.0)]
CLEAN_UP = ["--clean", "--outlier-sigma", 4, "--merge-tolerance"]


def wanted_scan(options, name, path):
    """The scan's path; None where it is not asked for or, said so, absent."""
    scan = pathlib.Path(options.data) / path
    if options.only and options.only not in name:
        return None
    if not scan.exists():
        print(f"skipped, no such file: {scan}")
        return None
    return scan


def raw_workloads(options, work):
    """The same for scans without normals; a list of files is scans with poses."""
    raw = [("raw bunny scans", "stanford/bunny_scans", 5e-5),
           ("lion without normals", "points_normals/lion_takanawa_normals_rgb.ply", 1e-3)]
    for name, path, tolerance in raw:
        scan = wanted_scan(options, name, path)
        if scan is None:
            continue
        arguments = ["--normals", "estimate", *CLEAN_UP, tolerance, "--no-fill", "--levels", 2]
        if scan.is_dir():
            yield name, sorted(scan.glob("*.ply")), ["--poses", scan / "bun.conf", *arguments]
        else:
            yield name, scan, [*arguments, "--orientation", "propagate"]
    name = "raw torus, propagated"
    if not options.only or options.only in name:
        cloud = work / "raw_torus.ply"
        harness.run([options.program, "generate", "bumpy-torus", "--points", 60_000, "--scans", 6, "--noise", 0.3,
                     "--misregistration", 0.5, "-o", cloud])
        yield name, cloud, [*CLEAN_UP, 1e-3, "--orientation", "propagate"]


def workloads(options, work):
    """(name, cloud, arguments); absent files are skipped by name."""
    yield from raw_workloads(options, work)
    for name, path, is_mesh, radius in SCANS:
        scan = wanted_scan(options, name, path)
        if scan is None:
            continue
        cloud = harness.oriented(options.program, work, scan) if is_mesh else scan
        yield name, cloud, ["--radii", repr(radius)] if radius else ["--levels", 3]
    for name, shape, points, noise in SHAPES:
        if options.only and options.only not in name:
            continue
        radius = 1.3 * harness.spacing(shape, points)
        cloud = harness.generated(options.program, work, shape, points, noise)
        yield name, cloud, ["--radii", repr(radius)]


def rows_of(cloud):
    """The points as rows that can be reordered: text lines, or a structured array."""
    if cloud.suffix == ".ply":
        vertex = read_ply(cloud)["vertex"]
        rows = np.empty(len(next(iter(vertex.values()))), [(k, v.dtype) for k, v in vertex.items()])
        for key, values in vertex.items():
            rows[key] = values
        return rows
    return np.array([line + b"\n" for line in cloud.read_bytes().splitlines() if line], dtype=object)


def write_rows(path, rows):
    if path.suffix == ".ply":
        write_cloud(path, rows)
    else:
        path.write_bytes(b"".join(rows))


def rearranged(cloud, work):
    """(the points shuffled, one file; the points dealt unevenly to three files, in another order)"""
    rows = rows_of(cloud)
    rng = np.random.default_rng(20260101)
    shuffled = work / f"shuffled{cloud.suffix}"
    write_rows(shuffled, rows[rng.permutation(len(rows))])
    parts = [work / f"part{k}{cloud.suffix}" for k in range(3)]
    cuts = [len(rows) // 7, len(rows) // 2]
    pieces = np.split(np.arange(len(rows)), cuts)
    for path, piece in zip(parts, pieces):
        write_rows(path, rows[piece])
    return shuffled, parts[::-1]


def variants(cloud, work, full):
    """(what is varied, clouds, chunk points, threads); `full` crosses chunks with threads."""
    one = isinstance(cloud, pathlib.Path)
    chunks, threads = (1_000, 20_000, EVERYTHING), (1, 2, 5)
    pairs = [(c, t) for c in chunks for t in threads if full or t == 2 or c == 20_000]
    for chunk_points, count in pairs:
        limit = "everything" if chunk_points == EVERYTHING else f"{chunk_points:,}"
        yield f"chunks of {limit}, {count} threads", [cloud] if one else cloud, chunk_points, count
    if not one:
        yield "files in another order", cloud[::-1], 20_000, 2
        return
    shuffled, parts = rearranged(cloud, work)
    yield "shuffled", [shuffled], 20_000, 2
    yield "three files", parts, 20_000, 2
    yield "three files, one chunk, 5 threads", parts, EVERYTHING, 5


def measure(options, work, name, cloud, arguments):
    rows = []
    for variant, clouds, chunk_points, threads in variants(cloud, work, options.full):
        mesh = work / "same_bytes.ply"
        result = harness.reconstruct(options.program, clouds, mesh,
                                     [*arguments, "--chunk-points", chunk_points, "--threads", threads])
        facts = result["report"]
        rows.append({"cloud": name, "variant": variant, "chunks": facts["partition"]["chunks"],
                     "triangles": facts["mesh"]["triangles"], "seconds": result["wall_seconds"],
                     "peak_memory_bytes": result["peak_memory_bytes"], "sha256": sha256(mesh)})
        print(f"  {rows[-1]['sha256'][:16]}  {variant} ({rows[-1]['chunks']} chunks, "
              f"{rows[-1]['seconds']:.2f} s)", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="directory of real scans, with stanford/ and points_normals/")
    parser.add_argument("--only", help="workloads whose name contains this")
    parser.add_argument("--full", action="store_true", help="every chunk size with every thread count")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows, differing = [], []
    for name, cloud, arguments in workloads(options, work):
        print(name, flush=True)
        taken = measure(options, work, name, cloud, arguments)
        rows += taken
        if len({row["sha256"] for row in taken}) != 1 or not taken[0]["triangles"]:
            differing.append(name)
            print("  DIFFERENT BYTES (or no triangle)")
    summary = {name: sorted({r["sha256"] for r in rows if r["cloud"] == name})
               for name in dict.fromkeys(r["cloud"] for r in rows)}
    harness.write_results(options, "same_bytes", rows, {"sha256": summary})
    print(json.dumps(summary, indent=1))
    print(f"{len(summary) - len(differing)} of {len(summary)} clouds have one SHA-256")
    return 1 if differing or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
