#!/usr/bin/env python3
"""Whether the ground faces up, on scans of scenes without the places of their scanners.

Of the triangles that lie within 0.3 m of the lowest in their cell of 1 m and are flatter than 45 degrees
(|nz| above 0.7): the share of their area that faces up. *standing*: the same of those triangles alone below which
nothing lies within 8 m, farther down than a slope of one in two explains: eaves and ceilings, of which nothing was
seen below, are the lowest in their cells and face down for good reason. Each scan by its job file, and where normals are
propagated with each of the two rules, `propagate` and `ground`. The exit status is 1 when a share is below the
target.

usage: bench/quality/ground.py DATA_DIR [--only NAME]
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
import numpy as np  # noqa: E402
from meshes import read_mesh  # noqa: E402

TERRESTRIAL = "configs/terrestrial-scan.toml"
# (name, file below DATA_DIR, job file, units per metre, least share)
SCENES = [("pine-plot", "lidar/pine_plot_tls_las12_pf0.las", TERRESTRIAL, 1.0, 0.99),
          ("b9", "lidar/cgal_b9_training.ply", "configs/airborne-lidar.toml", 1.0, 1.0),
          ("lone-star", "lidar/lone-star_las11_pf1.las", TERRESTRIAL, 1.0, 0.99),
          ("interchange", "photogrammetry/e102_interchange_crop_1.2M.ply.gz", TERRESTRIAL, 1.0, 0.99),
          ("building", "terrestrial/dean182_building_tls_5.8M.ply.gz", TERRESTRIAL, 3.28084, 0.99)]
COLUMNS = ["scene", "rule", "ground_area", "faces_up", "standing_area", "standing_up", "contested", "patches", "ground_patches",
           "ground_patches_down", "warned"]


def standing_limits(cells, lowest, meter):
    """Per cell, the height that the lowest of the cells within 8 m allow by a slope of one in two."""
    low = cells.min(axis=0)
    grid = np.full(cells.max(axis=0) - low + 1, np.inf)
    grid[tuple((cells - low).T)] = lowest
    reach, limits = 8, grid.copy()
    padded = np.pad(grid, reach, constant_values=np.inf)
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            slope = 0.5 * meter * np.hypot(dx, dy)
            if slope <= 0.5 * meter * reach:
                shifted = padded[reach + dx:reach + dx + grid.shape[0], reach + dy:reach + dy + grid.shape[1]]
                limits = np.minimum(limits, shifted + slope)
    return limits[tuple((cells - low).T)]


def faces_up(positions, triangles, meter):
    """Of the ground, and of its standing part: area in square metres, share of it that faces up."""
    corners = positions[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    areas = np.linalg.norm(normals, axis=1)
    centers = corners.mean(axis=1)
    cells = np.floor((centers[:, :2] - positions[:, :2].min(axis=0)) / meter).astype(np.int64)
    cells, cell = np.unique(cells, axis=0, return_inverse=True)
    lowest = np.full(len(cells), np.inf)
    np.minimum.at(lowest, cell, centers[:, 2])
    ground = (centers[:, 2] - lowest[cell] <= 0.3 * meter) & (np.abs(normals[:, 2]) > 0.7 * areas)
    standing = ground & (centers[:, 2] <= standing_limits(cells, lowest, meter)[cell] + 0.3 * meter)
    up = normals[:, 2] > 0
    return [(areas[part].sum() / meter**2, float(areas[part & up].sum() / areas[part].sum()))
            for part in (ground, standing)]


def measure(options, work, scene, rule):
    name, path, config, meter, _ = scene
    mesh = work / f"ground-{name}-{rule or 'own'}.ply"
    settings = [f"normals.orientation={rule}"] if rule else []
    result = harness.run_job(options.program, harness.ROOT / config, [pathlib.Path(options.data) / path], mesh,
                             settings)
    report = result["report"]
    normals = report["normals"]
    (area, share), (standing_area, standing_share) = faces_up(*read_mesh(mesh), meter)
    return {"scene": name, "rule": normals["orientation"], "ground_area": round(area, 1),
            "faces_up": round(share, 5), "standing_area": round(standing_area, 1),
            "standing_up": round(standing_share, 5), "contested": normals["contested_patches"],
            "patches": normals["patches"], "ground_patches": normals.get("ground_patches"),
            "ground_patches_down": normals.get("ground_patches_down"),
            "warned": any("the side of the normals is" in text for text in report["warnings"])}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="directory of real scans, with lidar/, photogrammetry/ and terrestrial/")
    parser.add_argument("--only", help="scenes whose name contains this")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows, missed = [], []
    for scene in SCENES:
        name, path, config, _, least = scene
        if options.only and options.only not in name:
            continue
        if not (pathlib.Path(options.data) / path).exists():
            print(f"skipped, no such file: {path}")
            continue
        for rule in ("propagate", "") if config == TERRESTRIAL else ("",):
            rows.append(measure(options, work, scene, rule))
            print(f"{name}, {rows[-1]['rule']}: {rows[-1]['faces_up']:.4f}", flush=True)
        if rows[-1]["faces_up"] < least:
            missed.append(name)
    print("\n" + harness.table(rows, COLUMNS))
    harness.write_results(options, "ground", rows)
    print("missed: " + ", ".join(missed) if missed else "all targets hold")
    return 1 if missed or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
