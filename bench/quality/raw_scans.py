#!/usr/bin/env python3
"""Raw scans, each through one job without tuned numbers.

  bunny    the ten range scans of the Stanford bunny with their poses, with and without the clean-up, before and
           after the fill: distances to bun_zipper.ply, holes, pieces; beside Open3D's ball pivoting and Poisson
           reconstruction of the merged cloud, its normals turned towards the scanners
  lidar    airborne, terrestrial and photogrammetric clouds: what was dropped, radii, share of points used
  lion     a real scan with its own normals and with them withheld, with and without the clean-up

Pictures go to the directory of the results. The exit status is 1 when the cleaned bunny is not nearer to
bun_zipper.ply, or has more boundary, than what Open3D's ball pivoting makes of the same scans, and when the cleaned
lion has 19,300 boundary edges before the fill or more: what two projections and thinning left in a quick experiment.

usage: bench/quality/raw_scans.py DATA_DIR [bunny|lidar|lion]... [--only NAME]
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy", "scipy")

import harness  # noqa: E402
import scans  # noqa: E402
import surface_distance  # noqa: E402
from meshes import edge_facts, read_mesh  # noqa: E402

# (name, file below DATA_DIR, job file)
CLOUDS = [("autzen", "lidar/autzen_stadium_tile_las12_pf2.las", "configs/airborne-lidar.toml"),
          ("b9", "lidar/cgal_b9_training.ply", "configs/airborne-lidar.toml"),
          ("pueblito", "photogrammetry/pueblito_las14_pf7.las", "configs/airborne-lidar.toml"),
          ("lone-star", "lidar/lone-star_las11_pf1.las", "configs/terrestrial-scan.toml"),
          ("pine-plot", "lidar/pine_plot_tls_las12_pf0.las", "configs/terrestrial-scan.toml")]
LION_EDGES = 19_300
DISTANCES = ["mean", "p95", "back_mean", "back_p95"]
BUNNY_COLUMNS = ["surface", "points", "kept", "used_share", "triangles", "components", "boundary_edges",
                 "boundary_loops", "nonmanifold_edges", *DISTANCES, "seconds", "peak_mib"]


def scan_at(options, path):
    scan = pathlib.Path(options.data) / path
    if scan.exists():
        return scan
    print(f"skipped, no such file: {scan}")
    return None


def before_and_after(options, row, mesh, truth):
    """Two rows of one run: the scanned surface alone, and with its holes filled."""
    scanned = scans.scanned_part(mesh)
    before = {**row, "surface": row["surface"] + ", open", "boundary_loops": row["loops_before"],
              "components": "", "nonmanifold_edges": "", **surface_distance.between(scanned, truth)}
    before.update({key: value for key, value in edge_facts(scanned[1]).items()
                   if key in ("triangles", "boundary_edges")})
    after = {**row, "surface": row["surface"] + ", filled", **surface_distance.between(read_mesh(mesh), truth)}
    return [before, after]


def own_bunny(options, work, conf, files, truth):
    rows = []
    for name, automatic in (("cleaned", "true"), ("as scanned", "false")):
        mesh = work / f"raw-bunny-{name.replace(' ', '-')}.ply"
        result = harness.run_job(options.program, harness.ROOT / "configs/raw-scans.toml", files, mesh,
                                 [f"input.poses={conf.resolve()}", f"cleaning.auto={automatic}"])
        scans.picture(options, mesh, f"raw_bunny_{name.replace(' ', '_')}")
        rows += before_and_after(options, scans.own_row(result, surface=f"orbweave, {name}"), mesh, truth)
    return rows


def open3d_bunny(options, work, cloud, spacing, truth):
    rows = []
    for row in scans.open3d_rows(options, cloud, work / "raw-bunny", spacing, options.depths):
        scans.picture(options, row["mesh"], "raw_bunny_" + row["surface"].lower().replace(",", "").replace(" ", "_"))
        rows.append({**row, **surface_distance.between(read_mesh(row["mesh"]), truth)})
    return rows


def part_bunny(options, work):
    conf = scan_at(options, "stanford/bunny_scans/bun.conf")
    reference = scan_at(options, "stanford/bun_zipper.ply")
    if not conf or not reference:
        return [], []
    truth = read_mesh(reference)
    files, spacing = scans.merged(conf, work / "raw-bunny-merged.ply")
    own = own_bunny(options, work, conf, files, truth)
    peers = open3d_bunny(options, work, work / "raw-bunny-merged.ply", spacing, truth)
    print(harness.table(own + peers, BUNNY_COLUMNS))
    print("\nmean, p95: distance of the surface to bun_zipper.ply; back_: of bun_zipper.ply to the surface; "
          "in the scans' unit, " f"{spacing:.4g} apart within a scan")
    show_choices(own[::2])
    cleaned, peer = own[0], peers[0]
    missed = [f"{key} {cleaned[key]:.4g} against {peer[key]:.4g}"
              for key in ("mean", "p95", "boundary_edges") if not cleaned[key] < peer[key]]
    return own + peers, missed


def show_choices(rows):
    """What each job said about its own choices."""
    for row in rows:
        dropped = ", ".join(f"{count:,} {reason}" for reason, count in row["dropped"].items()) or "nothing"
        print(f"\n{row['surface']}:\n  radii: {', '.join(f'{radius:.4g}' for radius in row['radii'])}"
              f"\n  dropped: {dropped}")
        for note in row["notes"]:
            print(f"  {note}")


def part_lidar(options, work):
    rows = []
    for name, path, config in CLOUDS:
        scan = scan_at(options, path) if not options.only or options.only in name else None
        if scan is None:
            continue
        mesh = work / f"raw-{name}.ply"
        result = harness.run_job(options.program, harness.ROOT / config, [scan], mesh)
        rows.append(scans.own_row(result, surface=name))
        scans.picture(options, mesh, f"raw_{name.replace('-', '_')}")
    print(harness.table(rows, ["surface", "points", "kept", "used_share", "triangles", "components",
                               "edges_before", "loops_before", "filled", "boundary_edges", "boundary_loops",
                               "seconds", "peak_mib"]))
    show_choices(rows)
    return rows, []


def part_lion(options, work):
    scan = scan_at(options, "points_normals/lion_takanawa_normals_rgb.ply")
    rows = []
    for source in ("file", "estimate") if scan else ():
        for name, arguments in (("as scanned", []), ("cleaned", ["--clean"])):
            mesh = work / f"raw-lion-{source}-{len(arguments)}.ply"
            result = harness.reconstruct(options.program, scan, mesh, ["--normals", source, *arguments])
            surface = f"{'own normals' if source == 'file' else 'withheld'}, {name}"
            rows.append(scans.own_row(result, surface=surface))
            scans.picture(options, mesh, "raw_lion_" + surface.replace(",", "").replace(" ", "_"))
    print(harness.table(rows, ["surface", "points", "kept", "used_share", "triangles", "components", "edges_before",
                               "loops_before", "filled", "boundary_edges", "boundary_loops", "seconds",
                               "peak_mib"]))
    show_choices(rows)
    return rows, [f"{row['surface']}: {row['edges_before']:,} boundary edges" for row in rows
                  if row["surface"].endswith("cleaned") and row["edges_before"] >= LION_EDGES]


PARTS = {"bunny": part_bunny, "lidar": part_lidar, "lion": part_lion}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="directory of real scans, with stanford/, lidar/ and points_normals/")
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; none: all")
    parser.add_argument("--only", help="clouds of `lidar` whose name contains this")
    parser.add_argument("--depths", type=lambda text: [int(word) for word in text.split(",") if word], default=[9, 10],
                        help="of Open3D's Poisson reconstruction of the bunny")
    harness.add_common_options(parser)
    options = parser.parse_intermixed_args()
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"unknown part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    work = harness.prepare(options)
    missed = []
    for part in options.parts or PARTS:
        print(f"\n-- {part}", flush=True)
        rows, part_missed = PARTS[part](options, work)
        if rows:
            harness.write_results(options, f"raw_{part}", rows)
        missed += [f"{part}: {text}" for text in part_missed]
    print("missed: " + "; ".join(missed) if missed else "all targets hold")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
