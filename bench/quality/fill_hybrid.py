"""The base paper's hybrid run (section 4.4): an incomplete bunny of 28,060 points, before and after the fill."""
import pathlib

import numpy as np

import harness
from meshes import edge_facts, read_mesh, read_ply, write_cloud

LEFT = 28_060
PAPER_AFTER = 29_967
RADII = "0.0015,0.00225,0.003375"
# What is missing: all points within a radius of a vertex of bun_zipper.ply nearest to a place. The last one
# takes as many as it needs, nearest first, for exactly 28,060 points to be left.
REMOVED = [("back, left", (-0.004, 0.113, -0.019), 0.021), ("back, right", (0.022, 0.121, 0.031), 0.021),
           ("spine", (0.013, 0.130, 0.004), 0.012), ("rump", (0.047, 0.092, 0.0), 0.018),
           ("tail", (0.060, 0.055, 0.010), 0.012), ("head, top", (-0.066, 0.150, 0.020), 0.010),
           ("cheek", (-0.082, 0.120, 0.035), 0.011), ("head, behind", (-0.050, 0.130, -0.005), 0.008),
           ("chest", (-0.070, 0.075, 0.035), 0.018), ("haunch, right", (0.010, 0.060, 0.057), 0.018),
           ("haunch, left", (0.010, 0.060, -0.040), 0.016), ("flank, left", (-0.028, 0.090, -0.035), 0.013),
           ("chest, left", (-0.068, 0.080, -0.012), 0.017), ("below", (0.025, 0.034, 0.005), 0.019), ("flank, right", (-0.030, 0.090, 0.047), 0.020)]


def removed_points(positions):
    """(which points go, what each disc took)"""
    gone, taken = np.zeros(len(positions), bool), []
    for rank, (name, place, radius) in enumerate(REMOVED):
        center = positions[np.argmin(((positions - place) ** 2).sum(1))]
        distance = np.linalg.norm(positions - center, axis=1)
        if rank + 1 < len(REMOVED):
            here = ~gone & (distance <= radius)
        else:
            order = np.argsort(np.where(gone, np.inf, distance), kind="stable")
            here = np.zeros(len(positions), bool)
            here[order[:int((~gone).sum()) - LEFT]] = True
        taken.append({"name": name, "center": center.tolist(), "points": int(here.sum()),
                      "radius": float(distance[here].max())})
        gone |= here
    return gone, taken


def incomplete_cloud(options, work, scan):
    """The bunny's points with normals from the whole mesh's faces, without the removed ones."""
    vertex = read_ply(harness.oriented(options.program, work, scan))["vertex"]
    columns = np.zeros(len(vertex["x"]), [(name, "<f4") for name in vertex])
    for name, values in vertex.items():
        columns[name] = values
    gone, taken = removed_points(np.stack([columns[axis] for axis in "xyz"], 1).astype(float))
    cloud = work / "fill-hybrid-cloud.ply"
    write_cloud(cloud, columns[~gone])
    return cloud, taken


def write_turned(path, mesh):
    """The mesh turned half around the upright axis, its patches still marked: the picture of the other side."""
    elements = read_ply(mesh)
    positions, triangles = read_mesh(mesh)
    turned = np.zeros(len(positions), [(axis, "<f8") for axis in "xyz"])
    for axis, values in zip("xyz", (positions * (-1.0, 1.0, -1.0)).T):
        turned[axis] = values
    faces = np.zeros(len(triangles), [("n", "u1"), ("v", "<i4", 3), ("hole", "<i4")])
    faces["n"], faces["v"] = 3, triangles
    faces["hole"] = elements["face"].get("hole", np.zeros(len(triangles)))
    with open(path, "wb") as stream:
        stream.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {len(turned)}\n"
                      "property double x\nproperty double y\nproperty double z\n"
                      f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
                      "property int hole\nend_header\n").encode())
        stream.write(turned.tobytes() + faces.tobytes())


def draw(options, work, mesh, name):
    """Pictures from the program's usual side and from the other one."""
    out = pathlib.Path(options.out)
    turned = work / "fill-hybrid-turned.ply"
    write_turned(turned, mesh)
    for side, file in (("front", mesh), ("back", turned)):
        harness.run([options.program, "inspect", file, "--picture", out / f"fill_hybrid_{name}_{side}.png"])


def reconstructed(options, work, cloud, name, *arguments):
    mesh = work / f"fill-hybrid-{name}.ply"
    result = harness.reconstruct(options.program, cloud, mesh, ["--radii", RADII, *arguments])
    draw(options, work, mesh, name)
    facts = result["report"]["mesh"]
    holes = result["report"].get("holes", [])
    row = {"surface": name, "vertices": facts["vertices"], **edge_facts(read_mesh(mesh)[1]),
           "boundary_loops": facts["boundary_loops"], "components": facts["components"],
           "watertight": facts["watertight"], "filled": sum(hole["filled"] for hole in holes),
           "points_added": sum(hole.get("points_added", 0) for hole in holes),
           "seconds": result["wall_seconds"]}
    return row, holes


def run(options, work):
    scan = pathlib.Path(options.data) / "stanford" / "bun_zipper.ply"
    if not scan.exists():
        print(f"skipped, no such file: {scan}")
        return []
    cloud, taken = incomplete_cloud(options, work, scan)
    before, _ = reconstructed(options, work, cloud, "before", "--no-fill")
    after, holes = reconstructed(options, work, cloud, "after")
    for row in (before, after):
        row["points"] = LEFT
        row["points_with_added"] = LEFT + row["points_added"]
        row["paper_points_with_added"] = PAPER_AFTER
    print(harness.table(taken, ["name", "points", "radius"]))
    print("\n" + harness.table([before, after], [
        "surface", "points", "vertices", "triangles", "boundary_edges", "boundary_loops", "edges_over_two", "filled",
        "points_added", "points_with_added", "paper_points_with_added", "watertight", "seconds"]))
    harness.write_results(options, "fill_hybrid", [before, after], {"removed": taken, "holes": holes})
    return [f"{after['boundary_loops']} loops left"] if after["boundary_loops"] else []
