"""Delete and refill: random discs cut out of meshes of real scans, filled by the program and by CGAL."""
import json
import math
import pathlib
import statistics

import harness

RADII = (4, 8, 16)
# The dragon's file has edges of more than two triangles and the lion has no faces, so their meshes are the
# program's, with the holes of the scan left open: discs keep away from them.
MODELS = [("bunny", "stanford/bun_zipper.ply", None),
          ("dragon", "stanford/dragon_vrip_res2.ply", "0.0011,0.00165,0.002475"),
          ("lion", "points_normals/lion_takanawa_normals_rgb.ply", "0.012,0.018,0.027,0.0405")]
COLUMNS = ["model", "radius_spacings", "holes", "closed", "cgal_closed", "rms", "cgal_rms", "ratio", "better",
           "max", "cgal_max", "normal_mean_deg", "cgal_normal_mean_deg", "rim_dihedral_deg",
           "cgal_rim_dihedral_deg", "intersecting", "cgal_intersecting", "seconds", "cgal_seconds"]


def model_mesh(options, work, name, path, radii):
    """The mesh that discs are cut from; None where its data are missing."""
    scan = pathlib.Path(options.data) / path
    if not scan.exists():
        print(f"skipped, no such file: {scan}")
        return None
    if radii is None:
        return scan
    cloud = harness.oriented(options.program, work, scan) if "stanford" in path else scan
    mesh = work / f"fill-{name}.ply"
    return harness.made(mesh, [options.program, "reconstruct", cloud, "-o", mesh, "--radii", radii,
                               "--no-fill", "--progress", "none"])


def refilled(options, mesh, radius, *arguments):
    words = [options.bench_fill, "discs", mesh, "--radii", radius, "--kernel", options.kernel, *arguments]
    return [json.loads(line) for line in harness.run(words)["stdout"].splitlines()]


def rms(holes, who):
    """Over all measured points of the class; an open hole has none to measure."""
    weighted = [(h[who]["rms"] ** 2 * h["measured_points"], h["measured_points"])
                for h in holes if h[who]["triangles"]]
    points = sum(count for _, count in weighted)
    return math.sqrt(sum(squares for squares, _ in weighted) / points) if points else math.nan


def summary_of(holes, who, prefix):
    facts = [h[who] for h in holes]
    done = [f for f in facts if f["triangles"]]
    sound = [h for h in holes if h["removed_intersections"] == 0]
    row = {"closed": sum(f["closed"] for f in facts), "rms": rms(holes, who),
           "median_rms": statistics.median([f["rms"] for f in done] or [math.nan]),
           "max": max((f["max"] for f in done), default=math.nan),
           "back_rms": math.sqrt(statistics.fmean([f["back_rms"] ** 2 for f in done] or [math.nan])),
           "normal_mean_deg": statistics.fmean([f["normal_mean_deg"] for f in done] or [math.nan]),
           "normal_max_deg": max((f["normal_max_deg"] for f in done), default=math.nan),
           "rim_dihedral_deg": max((f["rim_dihedral_deg"] for f in done), default=math.nan),
           "median_rim_dihedral_deg": statistics.median([f["rim_dihedral_deg"] for f in done] or [math.nan]),
           "intersecting": sum(h[who]["self_intersections"] > 0 for h in sound),
           "new_points": sum(f["new_points"] for f in facts), "seconds": sum(f["seconds"] for f in facts)}
    return {prefix + key: value for key, value in row.items()}


def class_row(name, radius, holes):
    methods = {}
    for hole in holes:
        method = hole["engine"]["method"] or "open"
        methods[method] = methods.get(method, 0) + 1
    row = {"model": name, "radius_spacings": radius, "holes": len(holes),
           "spacing": holes[0]["spacing"] if holes else math.nan,
           "removed_points": sum(h["removed_points"] for h in holes),
           "measured_points": sum(h["measured_points"] for h in holes), "methods": methods,
           "intersecting_before": sum(h["removed_intersections"] > 0 for h in holes),
           **summary_of(holes, "engine", ""), **summary_of(holes, "cgal", "cgal_")}
    row["ratio"] = row["rms"] / row["cgal_rms"] if holes else math.nan
    row["better"] = sum(h["engine"]["rms"] < h["cgal"]["rms"] for h in holes if h["engine"]["triangles"])
    return row


def excess(hole):
    """Squared distances beyond CGAL's, summed over the removed points."""
    return (hole["engine"]["rms"] ** 2 - hole["cgal"]["rms"] ** 2) * hole["measured_points"]


def write_worst(options, work, mesh, radius, holes):
    worst = sorted(holes, key=excess, reverse=True)[:options.worst]
    if worst:
        centers = ",".join(str(hole["center"]) for hole in worst)
        refilled(options, mesh, radius, "--centers", centers, "--cases", work / "fill-cases")


def misses(row):
    where = f"{row['model']} at {row['radius_spacings']} spacings"
    if row["closed"] < row["holes"]:
        yield f"{where}: {row['holes'] - row['closed']} not closed"
    if row["intersecting"]:
        yield f"{where}: {row['intersecting']} patches intersect"
    if not row["ratio"] < 1.0:
        yield f"{where}: RMS {row['rms']:.4g} against {row['cgal_rms']:.4g}"


def run(options, work):
    rows, details = [], []
    for name, path, radii in MODELS:
        if options.only and options.only not in name:
            continue
        mesh = model_mesh(options, work, name, path, radii)
        for radius in RADII if mesh else ():
            holes = refilled(options, mesh, radius, "--count", options.count)
            rows.append(class_row(name, radius, holes))
            details += [{"model": name, **hole} for hole in holes]
            write_worst(options, work, mesh, radius, holes)
    print(harness.table(rows, COLUMNS))
    print("\nlengths in spacings (mean edge lengths), summed seconds, largest dihedral; closed, better, "
          "intersecting: numbers of holes, the last of those where what was cut out did not cut the mesh")
    harness.write_results(options, "fill_discs", rows, {"holes": details})
    return [text for row in rows for text in misses(row)]
