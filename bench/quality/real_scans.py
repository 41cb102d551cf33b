#!/usr/bin/env python3
"""Each real scan by the job file that is made for its kind: what the mesh is worth, of one program or of two.

Columns: share of the points that are vertices, pairs of triangles that cross (of the mesh file, by the newer program's
`inspect`), places where sheets touch, edges at the border, loops filled of all, share of the area that no point
supports, doubtful patches, orientation patches that contradict their neighbours, share of the ground that faces up
(`ground.py`), and whether the mesh is watertight. Clouds that are no scans (kitten, oni, points of the Stanford meshes) run
as objects. The exit status is 1 where triangles of this program's mesh cross.

usage: bench/quality/real_scans.py DATA_DIR [--before PROGRAM --before-root DIR] [--only NAME]
"""
import argparse
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
from ground import faces_up  # noqa: E402
from meshes import read_mesh  # noqa: E402

TERRESTRIAL, AIRBORNE = "configs/terrestrial-scan.toml", "configs/airborne-lidar.toml"
OBJECT, TERRAIN, RAW = "configs/object.toml", "configs/terrain.toml", "configs/raw-scans.toml"
# (name, file below DATA_DIR, job file, units per metre where there is a ground)
SCANS = [("autzen", "lidar/autzen_stadium_tile_las12_pf2.las", AIRBORNE, 3.28084),
         ("b9", "lidar/cgal_b9_training.ply", AIRBORNE, 1.0),
         ("lone-star", "lidar/lone-star_las11_pf1.las", TERRESTRIAL, 1.0),
         ("pine plot", "lidar/pine_plot_tls_las12_pf0.las", TERRESTRIAL, 1.0),
         ("pueblito", "photogrammetry/pueblito_las14_pf7.las", TERRAIN, 1.0),
         ("interchange crop", "photogrammetry/e102_interchange_crop_1.2M.ply.gz", TERRESTRIAL, 1.0),
         ("lion", "points_normals/lion_takanawa_normals_rgb.ply", OBJECT, None),
         ("kitten", "points_normals/kitten.xyz", OBJECT, None),
         ("oni", "points_normals/oni.xyz", OBJECT, None),
         ("bunny, its mesh's points", "stanford/bun_zipper.ply", OBJECT, None),
         ("bunny, ten scans", "stanford/bunny_scans/bun.conf", RAW, None),
         ("dragon", "stanford/dragon_vrip.ply", OBJECT, None),
         ("dragon res2", "stanford/dragon_vrip_res2.ply", OBJECT, None),
         ("dragon res3", "stanford/dragon_vrip_res3.ply", OBJECT, None),
         ("building 182", "terrestrial/dean182_building_tls_5.8M.ply.gz", TERRESTRIAL, 3.28084)]
COLUMNS = ["scan", "program", "seconds", "cpu_seconds", "vertices", "used", "crossings", "pinches", "border", "loops", "filled",
           "invented", "doubtful", "contested", "faces_up", "watertight"]


def inputs_of(path):
    """Files and settings of a scan; the poses of a .conf come with it."""
    if path.suffix != ".conf":
        return [path], []
    names = [line.split()[1] for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("bmesh")]
    return [path.parent / name for name in names], [f"input.poses={json.dumps(str(path))}"]


def measure(options, work, scan, label, program, root):
    name, path, config, meter = scan
    mesh = work / f"real-{label}-{re.sub('[^a-z0-9]+', '-', name)}.ply"
    files, settings = inputs_of(pathlib.Path(options.data) / path)
    result = harness.run_job(program, root / config, files, mesh, settings)
    report = result["report"]
    facts = json.loads(harness.run([options.program, "inspect", mesh, "--json"])["stdout"])
    holes = report["holes"]
    filled = [hole for hole in holes if hole["filled"]]
    ground = round(faces_up(*read_mesh(mesh), meter)[0][1], 4) if meter else ""
    mesh.unlink()
    return {"scan": name, "program": label, "seconds": result["wall_seconds"],
            "cpu_seconds": result["user_seconds"] + result["system_seconds"], "vertices": facts["vertices"],
            "used": 1.0 - report["points_unused"] / max(1, report["input"]["points_read"]),
            "crossings": facts["crossing_pairs"], "pinches": report["mesh"].get("pinches", ""), "border": facts["boundary_edges"],
            "loops": len(holes), "filled": len(filled), "invented": facts["patch_area"] / facts["area"],
            "doubtful": sum((hole.get("confidence") or 0.0) < 0.5 for hole in filled) if "pinches" in report["mesh"] else "",
            "contested": report["normals"].get("contested_patches", "") if report.get("normals") else "",
            "faces_up": ground, "watertight": facts["watertight"]}


def add_scan_options(parser):
    """Where the scans are, and the other program."""
    parser.add_argument("data", help="directory of real scans")
    parser.add_argument("--before", help="another program, run in turn with this one")
    parser.add_argument("--before-root", default=harness.ROOT, type=pathlib.Path,
                        help="the tree whose configs/ the other program understands")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_scan_options(parser)
    parser.add_argument("--only", help="scans whose name contains this")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    programs = [("before", options.before, options.before_root)] if options.before else []
    programs.append(("now", options.program, harness.ROOT))
    rows = []
    for scan in SCANS:
        if options.only and options.only not in scan[0]:
            continue
        if not (pathlib.Path(options.data) / scan[1]).exists():
            print(f"skipped, no such file: {scan[1]}")
            continue
        for label, program, root in programs:
            rows.append(measure(options, work, scan, label, program, root))
            print(harness.table(rows[-1:], COLUMNS), flush=True)
    print("\n" + harness.table(rows, COLUMNS))
    harness.write_results(options, "real_scans", rows)
    crossing = [row["scan"] for row in rows if row["program"] == "now" and row["crossings"]]
    print("missed: triangles cross: " + ", ".join(crossing) if crossing else "no triangles cross")
    return 1 if crossing or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
