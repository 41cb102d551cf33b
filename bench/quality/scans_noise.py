#!/usr/bin/env python3
"""Noise and misregistration against the truth: what a virtual scanner sees of a shape from six sides.

For every pair of a noise (along the rays) and a misregistration, both in distances between rays: the program with and
without its clean-up, before and after the fill, Open3D's ball pivoting, and its Poisson reconstruction, as it is and
trimmed where few points support it. Distances to the true surface are in the same unit. The program gets the scans
with their poses as a Stanford .conf, Open3D the merged cloud with normals turned towards the scanners.

usage: bench/quality/scans_noise.py [--shapes S,S] [--points N] [--noise S,S,...] [--misregistration S,S,...]
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy", "scipy", "matplotlib")

import harness  # noqa: E402
import plots  # noqa: E402
import scans  # noqa: E402
import surface_distance  # noqa: E402
from meshes import edge_facts, read_mesh  # noqa: E402

COLUMNS = ["shape", "noise", "misregistration", "surface", "mean", "p95", "back_p95", "used_share", "triangles",
           "components", "boundary_edges", "boundary_loops", "nonmanifold_edges", "seconds"]


def generated_scans(options, work, shape, noise, misregistration):
    """(.conf, true mesh, distance between rays)"""
    stem = work / f"scans-{shape}-{options.points}-{options.scans}-{noise:g}-{misregistration:g}"
    conf, truth = pathlib.Path(f"{stem}.conf"), pathlib.Path(f"{stem}-truth.ply")
    harness.made(conf, [options.program, "generate", shape, "--points", options.points, "--scans", options.scans,
                        "--noise", f"{noise:g}", "--misregistration", f"{misregistration:g}", "--separate",
                        "-o", f"{stem}.ply", "--truth", truth])
    return conf, truth


def own_rows(options, mesh, files, conf, truth, unit):
    for name, arguments in (("cleaned", ["--clean"]), ("as scanned", [])):
        result = harness.reconstruct(options.program, files, mesh, ["--poses", conf, *arguments])
        row = scans.own_row(result)
        scanned = scans.scanned_part(mesh)
        counts = edge_facts(scanned[1])
        yield {**row, "surface": f"orbweave, {name}", "triangles": counts["triangles"], "components": "",
               "boundary_edges": counts["boundary_edges"], "boundary_loops": row["loops_before"],
               **surface_distance.between(scanned, truth, unit)}
        yield {**row, "surface": f"orbweave, {name}, filled",
               **surface_distance.between(read_mesh(mesh), truth, unit)}


def rows_of(options, work, shape, noise, misregistration):
    conf, truth_path = generated_scans(options, work, shape, noise, misregistration)
    merged = work / "scans-merged.ply"
    files, spacing = scans.merged(conf, merged)
    truth, unit = read_mesh(truth_path), ray_distance(files)
    mesh = work / "scans-noise.ply"
    facts = {"shape": shape, "noise": noise, "misregistration": misregistration, "unit": unit}
    for row in own_rows(options, mesh, files, conf, truth, unit):
        yield {**facts, **row}
    for row in scans.open3d_rows(options, merged, work / "scans-noise", spacing, [options.depth]):
        yield {**facts, **row, **surface_distance.between(read_mesh(row["mesh"]), truth, unit)}


def ray_distance(files):
    """Between neighbouring rays: the smallest step between the x of a scan's own grid."""
    steps = []
    for path in files:
        x = sorted(set(scans.positions_of(path)[:, 0]))
        steps.append(min(b - a for a, b in zip(x, x[1:])))
    return min(steps)


def draw(options, shape, rows):
    """p95 over the noise at each end of the misregistrations, and the other way round."""
    for across, along in (("noise", "misregistration"), ("misregistration", "noise")):
        for value in sorted({row[along] for row in rows})[::max(1, len({row[along] for row in rows}) - 1)]:
            chosen = [row for row in rows if row[along] == value and not row["surface"].endswith("filled")]
            series = {}
            for row in chosen:
                series.setdefault(row["surface"], []).append((row[across], row["p95"]))
            name = f"scans_{shape.replace('-', '_')}_{across}_{along}_{value:g}.svg"
            plots.line_plot(pathlib.Path(options.out) / name, f"{shape}, six scans, {along} {value:g}",
                            f"{across}, spacings", "95th percentile of the distance to the truth, spacings", series)


def numbers(text):
    return [float(word) for word in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", default="bumpy-torus,cube", help="S,S,...")
    parser.add_argument("--points", type=int, default=100_000, help="of all scans together")
    parser.add_argument("--scans", type=int, default=6)
    parser.add_argument("--noise", type=numbers, default=[0.1, 0.3, 0.6, 1.0])
    parser.add_argument("--misregistration", type=numbers, default=[0.0, 0.5, 1.0, 2.0])
    parser.add_argument("--depth", type=int, default=8, help="of Poisson's octree; its cells are as wide as the "
                        "distance between rays")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows = []
    for shape in options.shapes.split(","):
        for noise in options.noise:
            for misregistration in options.misregistration:
                rows += rows_of(options, work, shape, noise, misregistration)
                print(".", end="", flush=True)
        draw(options, shape, [row for row in rows if row["shape"] == shape])
    print("\n" + harness.table(rows, COLUMNS))
    print("\nmean, p95: distance of the surface to the true one; back_p95: of the true one to the surface; in "
          "distances between rays")
    harness.write_results(options, "scans_noise", rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
