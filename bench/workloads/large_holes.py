#!/usr/bin/env python3
"""One large hole: seconds, memory, new points and how busy the threads are, over the edges of its rim.

  smooth    a ring of points on a wavy height field
  crumpled  the same with noise of a third of a spacing along the normals, which are off by some 15 degrees

The ring is 40 spacings wide; what it surrounds is the hole, its outer border stays open. Columns: edges of the rim,
whether the hole was filled or the reason why not, new points, wall and CPU seconds of the hole pass, their ratio
(`busy`, of `threads`), microseconds of CPU per edge and binary logarithm of the edges, and the peak memory of the job.
The exit status is 1 where the CPU time of a hole grows by more than twice what n log n allows from one size
to the next, a job holds more than its budget, or the hole of a smooth ring stays open.

usage: bench/workloads/large_holes.py [--edges 500,5000,50000] [--kinds smooth,crumpled] [--memory 512MiB]
"""
import argparse
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
import numpy  # noqa: E402
from hostile import write_ply  # noqa: E402
from whole_jobs import parse_bytes  # noqa: E402

EDGES = (500, 5_000, 50_000)
RING = 40.0  # spacings
EDGES_PER_SPACING = 0.85  # of a rim through a grid, which balls cut short
MOST_GROWTH = 2.0  # over n log n
COLUMNS = ["kind", "rim_edges", "points", "filled", "points_added", "seconds", "cpu_seconds", "busy", "us_per_edge_log",
           "peak_mib"]


def ring(edges, random, crumpled):
    """Points a spacing apart, and their normals: height 0.1 R (sin(2 x / R) + cos(3 y / R))."""
    radius = edges / (2 * math.pi * EDGES_PER_SPACING)
    outer = radius + RING
    places = []
    for row in numpy.arange(-math.ceil(outer), math.ceil(outer) + 1):
        most = math.sqrt(max(outer**2 - row**2, 0.0))
        least = math.sqrt(max(radius**2 - row**2, 0.0))
        columns = numpy.arange(-math.ceil(most), math.ceil(most) + 1)
        places.append(numpy.stack([columns, numpy.full(len(columns), row)], axis=1)[
            (abs(columns) <= most) & (abs(columns) >= least)])
    flat = numpy.concatenate(places) + random.uniform(-0.25, 0.25, (sum(map(len, places)), 2))
    x, y = flat.T / radius
    slopes = numpy.stack([0.2 * numpy.cos(2 * x), -0.3 * numpy.sin(3 * y)], axis=1)
    heights = 0.1 * radius * (numpy.sin(2 * x) + numpy.cos(3 * y))
    points = numpy.column_stack([flat, heights])
    normals = numpy.column_stack([-slopes, numpy.ones(len(flat))])
    normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
    if crumpled:
        points += normals * random.normal(0, 1 / 3, (len(flat), 1))
        normals += random.normal(0, 0.2, normals.shape)
        normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
    return points, normals


def row_of(options, work, kind, edges):
    cloud, mesh = work / f"ring-{kind}-{edges}.ply", work / "ring-mesh.ply"
    points, normals = ring(edges, numpy.random.default_rng(edges), kind == "crumpled")
    write_ply(cloud, points, normals)
    result = harness.reconstruct(options.program, cloud, mesh, ["--memory", options.memory, "--max-diameter", "inf"])
    cloud.unlink()
    report = result["report"]
    inside = [hole for hole in report["holes"] if "outer border" not in str(hole["reason"])]
    hole = max(inside, key=lambda each: each["edges"])
    stage = harness.stages(report)["holes"]
    cost = hole["edges"] * math.log2(hole["edges"])
    return {"kind": kind, "points": len(points), "rim_edges": hole["edges"],
            "filled": "yes" if hole["filled"] else str(hole["reason"])[:60], "points_added": hole["points_added"],
            "seconds": stage["seconds"], "cpu_seconds": stage["cpu_seconds"],
            "busy": stage["cpu_seconds"] / stage["seconds"], "us_per_edge_log": 1e6 * stage["cpu_seconds"] / cost,
            "peak_mib": result["peak_memory_bytes"] / 2**20}


def misses_of(rows, most_mib):
    for before, after in zip(rows, rows[1:]):
        growth = after["us_per_edge_log"] / before["us_per_edge_log"]
        if growth > MOST_GROWTH:
            yield f"{after['kind']}: {growth:.1f} times n log n from {before['rim_edges']:,} to {after['rim_edges']:,} edges"
    for row in rows:
        if row["peak_mib"] > most_mib:
            yield f"{row['kind']}, {row['rim_edges']:,} edges: {row['peak_mib']:.0f} MiB held, {most_mib:.0f} allowed"
        if row["kind"] == "smooth" and row["filled"] != "yes":
            yield f"smooth, {row['rim_edges']:,} edges: open, {row['filled']}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    harness.add_common_options(parser)
    parser.add_argument("--edges", default=",".join(map(str, EDGES)))
    parser.add_argument("--kinds", default="smooth,crumpled")
    parser.add_argument("--memory", default="512MiB")
    options = parser.parse_args()
    work = harness.prepare(options)
    most_mib = parse_bytes(options.memory) / 2**20
    rows, missed = [], []
    for kind in options.kinds.split(","):
        of_kind = [row_of(options, work, kind, int(edges)) for edges in options.edges.split(",")]
        print(harness.table(of_kind, COLUMNS), flush=True)
        missed += misses_of(of_kind, most_mib)
        rows += of_kind
    harness.write_results(options, "large_holes", rows)
    return harness.exit_status(missed)


if __name__ == "__main__":
    sys.exit(main())
