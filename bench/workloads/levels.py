#!/usr/bin/env python3
"""Levels of detail of a generated mesh: triangles per second, memory, disk, shares of borders, errors.

    bench/workloads/levels.py [--triangles 10e6] [--threads 2] [--memory 1GiB] [--work FOLDER] [--mesh MESH.ply]
        [--measure]

The mesh is a torus with bumps of several sizes, closed, written row by row. `--mesh` takes a mesh that is there. Where node
and gltf-validator are installed, every tile goes through it (bench/quality/validate_gltf.js). Prints JSON.
"""
import argparse
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import interpreter

interpreter.need("numpy")

import harness
import numpy as np


def torus_rows(first, count, rows, columns):
    u = (np.arange(first, first + count) * (2 * math.pi / rows))[:, None]
    v = (np.arange(columns) * (2 * math.pi / columns))[None, :]
    bumps = 0.4 + 0.03 * np.sin(9 * u) * np.cos(7 * v) + 0.004 * np.sin(97 * u) * np.sin(83 * v)
    bumps = bumps + 0.0004 * np.sin(1013 * u) * np.cos(911 * v)
    ring = 1.0 + bumps * np.cos(v)
    return np.stack([ring * np.cos(u), ring * np.sin(u), bumps * np.sin(v) * np.ones_like(u)], axis=-1)


def write_torus(path, triangles):
    columns = max(8, round(math.sqrt(triangles / 2 / 2.5)))
    rows = max(8, round(triangles / 2 / columns))
    face = np.dtype([("corners", "u1"), ("at", "<u4", 3)])
    with open(path, "wb") as file:
        file.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {rows * columns}\n"
                    "property double x\nproperty double y\nproperty double z\n"
                    f"element face {2 * rows * columns}\n"
                    "property list uchar uint vertex_indices\nend_header\n").encode())
        for first in range(0, rows, 256):
            torus_rows(first, min(256, rows - first), rows, columns).astype("<f8").tofile(file)
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


def levels_of(text):
    """The table that the command prints."""
    levels = []
    for line in text.splitlines():
        match = re.match(r"\s*(\d+)\s+([\d,]+)\s+([\d,]+)\s+(\S+) %\s+(\S+)(?:\s+(\S+)\s+(\S+))?$", line)
        if match:
            level, tiles, triangles, border, error, distance, mean = match.groups()
            levels.append({"level": int(level), "tiles": int(tiles.replace(",", "")),
                           "triangles": int(triangles.replace(",", "")), "border_percent": float(border),
                           "error": float(error)})
            if distance:
                levels[-1].update(measured=float(distance), mean=float(mean))
    return levels


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
    parser.add_argument("--program", default=str(harness.ROOT / "build" / "release" / "bin" / "orbweave"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.work) as work:
        mesh = pathlib.Path(arguments.mesh or pathlib.Path(work) / "torus.ply")
        if not arguments.mesh:
            write_torus(mesh, arguments.triangles)
        folder = pathlib.Path(work) / "tiles"
        measured = harness.run([arguments.program, "tileset", mesh, "-o", folder, "--threads", arguments.threads,
                                "--memory", arguments.memory, "--progress", "none",
                                *(["--measure"] if arguments.measure else [])])
        levels = levels_of(measured.pop("stdout"))
        cpu = measured["user_seconds"] + measured["system_seconds"]
        result = {"mesh_bytes": mesh.stat().st_size, "threads": arguments.threads, "memory": arguments.memory,
                  "triangles": levels[0]["triangles"],
                  "triangles_per_second": round(levels[0]["triangles"] / measured["wall_seconds"]),
                  "triangles_per_cpu_second": round(levels[0]["triangles"] / cpu), **measured,
                  "folder_bytes": sum(file.stat().st_size for file in folder.iterdir()), "levels": levels,
                  "gltf_validator": validated(folder)}
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
