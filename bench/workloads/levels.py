#!/usr/bin/env python3
"""Levels of detail of a generated mesh: triangles per second, memory, disk, shares of borders, errors.

    bench/workloads/levels.py [--triangles 10e6] [--threads 2] [--memory 1GiB] [--work FOLDER] [--mesh MESH.ply]
        [--measure] [--colors] [--compression none|meshopt]

The mesh is a torus with bumps of several sizes, closed, written row by row, on a lattice on which floats of tiles are exact.
`--mesh` takes a mesh that is there. Where node and gltf-validator are installed, every tile goes through it
(bench/quality/validate_gltf.js). All borders of the generated mesh are walked (bench/quality/tile_borders.py), where tiles
are not compressed. Prints JSON: of each level the share of triangles at borders, the stated error and, with `--measure`, the
measured distance and the error of colors. Exit status 1 where more than 30 % of a level's triangles lie at borders, a level
is farther from the mesh than it states, or tiles do not meet.
"""
import argparse
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import interpreter

interpreter.need("numpy")

import harness
import numpy as np


LATTICE = 2.0**20
MOST_AT_BORDERS = 0.3


def torus_rows(first, count, rows, columns):
    u = (np.arange(first, first + count) * (2 * math.pi / rows))[:, None]
    v = (np.arange(columns) * (2 * math.pi / columns))[None, :]
    bumps = 0.4 + 0.03 * np.sin(9 * u) * np.cos(7 * v) + 0.004 * np.sin(97 * u) * np.sin(83 * v)
    bumps = bumps + 0.0004 * np.sin(1013 * u) * np.cos(911 * v)
    ring = 1.0 + bumps * np.cos(v)
    places = np.stack([ring * np.cos(u), ring * np.sin(u), bumps * np.sin(v) * np.ones_like(u)], axis=-1)
    return np.round(places * LATTICE) / LATTICE


def colored(places):
    """Rows with colors that change as fast as the second size of bumps."""
    rows = np.empty(places.shape[0] * places.shape[1], np.dtype([("at", "<f8", 3), ("color", "u1", 3)]))
    rows["at"] = places.reshape(-1, 3)
    rows["color"] = np.round(127.5 + 127.5 * np.sin(40 * rows["at"]))
    return rows


def write_torus(path, triangles, has_colors):
    columns = max(8, round(math.sqrt(triangles / 2 / 2.5)))
    rows = max(8, round(triangles / 2 / columns))
    face = np.dtype([("corners", "u1"), ("at", "<u4", 3)])
    with open(path, "wb") as file:
        file.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {rows * columns}\n"
                    "property double x\nproperty double y\nproperty double z\n"
                    + ("property uchar red\nproperty uchar green\nproperty uchar blue\n" if has_colors else "") +
                    f"element face {2 * rows * columns}\n"
                    "property list uchar uint vertex_indices\nend_header\n").encode())
        for first in range(0, rows, 256):
            places = torus_rows(first, min(256, rows - first), rows, columns)
            (colored(places) if has_colors else places.astype("<f8")).tofile(file)
        column = np.arange(columns)
        after = (column + 1) % columns
        for row in range(rows):
            here = row * columns
            ahead = ((row + 1) % rows) * columns
            faces = np.empty(2 * columns, face)
            faces["corners"] = 3
            faces["at"][0::2] = np.stack([here + column, ahead + column, ahead + after], axis=1)
            faces["at"][1::2] = np.stack([here + column, ahead + after, here + after], axis=1)
            faces.tofile(file)
    return 2 * rows * columns


def levels_of(report):
    levels = []
    for level in report["levels"]:
        measured = level["measured"] or {}
        levels.append({"level": level["level"], "tiles": level["tiles"], "triangles": level["triangles"],
                       "border_share": round(level["border_triangles"] / level["triangles"], 4),
                       "stated_error": level["stated_error"],
                       **{key: measured[key] for key in ("distance", "mean_distance", "color_error", "samples") if key in measured}})
    return levels


def holds(levels, borders):
    """What is promised of a tileset."""
    return (all(level["border_share"] <= MOST_AT_BORDERS for level in levels)
            and all(level.get("distance", 0) <= level["stated_error"] for level in levels)
            and (isinstance(borders, str) or not any(cut["without_counterpart"] for cut in borders)))


def walked_borders(folder, arguments):
    if arguments.mesh or arguments.compression != "none":
        return "skipped: of generated meshes without compression"
    script = harness.ROOT / "bench" / "quality" / "tile_borders.py"
    return json.loads(subprocess.run([sys.executable, script, folder], stdout=subprocess.PIPE, text=True, check=False).stdout)


def validated(folder):
    if not shutil.which("node"):
        return "skipped: no node"
    script = harness.ROOT / "bench" / "quality" / "validate_gltf.js"
    done = subprocess.run(["node", str(script), str(folder)], capture_output=True, text=True, check=False)
    return "skipped: no gltf-validator" if done.returncode == 77 else json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=float, default=10e6)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--memory", default="1GiB")
    parser.add_argument("--work", help="a folder with room; default: a temporary one")
    parser.add_argument("--mesh", help="a mesh instead of the generated one")
    parser.add_argument("--measure", action="store_true", help="distances of levels to the mesh, too")
    parser.add_argument("--colors", action="store_true", help="the generated mesh has colors")
    parser.add_argument("--compression", default="none", choices=["none", "meshopt"])
    parser.add_argument("--program", default=str(harness.ROOT / "build" / "release" / "bin" / "orbweave"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.work) as work:
        mesh = pathlib.Path(arguments.mesh or pathlib.Path(work) / "torus.ply")
        if not arguments.mesh:
            write_torus(mesh, arguments.triangles, arguments.colors)
        folder = pathlib.Path(work) / "tiles"
        report = pathlib.Path(work) / "report.json"
        measured = harness.run([arguments.program, "tileset", mesh, "-o", folder, "--threads", arguments.threads,
                                "--memory", arguments.memory, "--progress", "none",
                                "--report", report, "--tileset-compression", arguments.compression,
                                *(["--measure"] if arguments.measure else [])])
        measured.pop("stdout")
        levels = levels_of(json.loads(report.read_text()))
        borders = walked_borders(folder, arguments)
        cpu = measured["user_seconds"] + measured["system_seconds"]
        result = {"mesh_bytes": mesh.stat().st_size, "threads": arguments.threads, "memory": arguments.memory,
                  "triangles": levels[0]["triangles"],
                  "triangles_per_second": round(levels[0]["triangles"] / measured["wall_seconds"]),
                  "triangles_per_cpu_second": round(levels[0]["triangles"] / cpu), **measured,
                  "folder_bytes": sum(file.stat().st_size for file in folder.iterdir()), "compression": arguments.compression, "levels": levels, "borders": borders,
                  "gltf_validator": validated(folder)}
    print(json.dumps(result, indent=1))
    return 0 if holds(levels, borders) else 1


if __name__ == "__main__":
    sys.exit(main())
