#!/usr/bin/env python3
"""Side by side with Open3D's ball pivoting: same points, same normals, same radius.

Stanford models at the radii of Abdel-Wahab et al. 2005, table 1 (and the large dragon at 0.00069), tori with
noise of 0.1, 0.3 and 0.6 spacings at 1.3 spacings. The exit status is 1 when a mesh has fewer than 0.998 of
Open3D's triangles, more boundary edges than Open3D's, an edge of more than two triangles, or a directed edge
used twice.

usage: bench/quality/right_surface.py DATA_DIR [--only NAME] [--repeats N]
"""
import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
from meshes import edge_facts, read_mesh  # noqa: E402

STANFORD = [("bun_zipper_res4", 0.012), ("bun_zipper_res3", 0.0055), ("bun_zipper_res2", 0.0028),
            ("bun_zipper", 0.0015), ("dragon_vrip_res4", 0.0035), ("dragon_vrip_res3", 0.002),
            ("dragon_vrip_res2", 0.0011), ("dragon_vrip", 0.00069)]
TORI = [(points, noise) for points in (100_000, 200_000) for noise in (0.1, 0.3, 0.6)]
COLUMNS = ["cloud", "points", "triangles", "open3d_triangles", "triangle_ratio", "boundary_edges",
           "open3d_boundary_edges", "edges_over_two", "directed_edges_twice", "kernel_speedup", "verdict"]


def workloads(options, work):
    """(name, cloud, radius) of everything whose data are there; the rest is skipped by name."""
    for name, radius in STANFORD:
        mesh = pathlib.Path(options.data) / "stanford" / f"{name}.ply"
        if options.only and options.only not in name:
            continue
        if not mesh.exists():
            print(f"skipped, no such file: {mesh}")
            continue
        yield name, harness.oriented(options.program, work, mesh), radius
    for points, noise in TORI:
        name = f"torus {points // 1000}k noise {noise:g}"
        if options.only and options.only not in name:
            continue
        radius = 1.3 * harness.spacing("torus", points)
        yield name, harness.generated(options.program, work, "torus", points, noise), radius


def open3d_run(cloud, radius):
    words = [harness.peer_python(), harness.PEERS / "open3d_peer.py", cloud, "--radii", repr(radius)]
    measured = harness.run(words)
    return {**measured, **json.loads(measured["stdout"])}


def verdict(row):
    missed = []
    if row["triangle_ratio"] < 0.998:
        missed.append("triangles")
    if row["boundary_edges"] > row["open3d_boundary_edges"]:
        missed.append("boundary")
    if row["edges_over_two"]:
        missed.append("over two")
    if row["directed_edges_twice"]:
        missed.append("twice")
    return "missed: " + ", ".join(missed) if missed else "ok"


def kernel_seconds(result):
    """CPU seconds of the program's reconstruction stage: what one core would have needed."""
    stages = harness.stages(result["report"])
    return stages["reconstruct"]["cpu_seconds"] if "reconstruct" in stages else None


def measure(options, work, name, cloud, radius):
    mesh = work / "right_surface.ply"
    arguments = ["--radii", repr(radius), "--threads", 1]
    results = harness.alternate(
        {"ours": lambda: harness.reconstruct(options.program, cloud, mesh, arguments),
         "open3d": lambda: open3d_run(cloud, radius)}, options.repeats)
    ours, open3d = results["ours"][-1], results["open3d"][-1]
    row = {"cloud": name, "points": open3d["points"], "radius": radius,
           **edge_facts(read_mesh(mesh)[1]),
           **{f"open3d_{key}": open3d[key] for key in ("triangles", "boundary_edges", "edges_over_two",
                                                       "directed_edges_twice")}}
    row["triangle_ratio"] = row["triangles"] / max(1, open3d["triangles"])
    row["peak_memory_bytes"] = max(r["peak_memory_bytes"] for r in results["ours"])
    row["open3d_peak_memory_bytes"] = max(r["peak_memory_bytes"] for r in results["open3d"])
    row["open3d_kernel"] = harness.spread([r["kernel_seconds"] for r in results["open3d"]])
    seconds = [kernel_seconds(r) for r in results["ours"]]
    if None not in seconds:
        row["kernel"] = harness.spread(seconds)
        if row["kernel"]["median"] > 0:
            row["kernel_speedup"] = row["open3d_kernel"]["median"] / row["kernel"]["median"]
    row["checksum"] = ours["report"]["mesh"]["checksum"]
    row["verdict"] = verdict(row)
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="directory of real scans, with stanford/")
    parser.add_argument("--only", help="workloads whose name contains this")
    parser.add_argument("--repeats", type=int, default=1, help="for the seconds; counts need one")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows = []
    for name, cloud, radius in workloads(options, work):
        rows.append(measure(options, work, name, cloud, radius))
        print(f"{name}: {rows[-1]['verdict']}", flush=True)
    print("\n" + harness.table(rows, COLUMNS))
    harness.write_results(options, "right_surface", rows)
    missed = [row["cloud"] for row in rows if row["verdict"] != "ok"]
    print(f"{len(rows) - len(missed)} of {len(rows)} hold" + (f"; missed: {missed}" if missed else ""))
    return 1 if missed or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
