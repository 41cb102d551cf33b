"""What the benchmarks of raw scans share: scans with poses, the program and Open3D on them, facts of the meshes."""
import json
import pathlib

import numpy as np

import harness
from meshes import read_mesh, read_ply, write_cloud

FACTS = ["triangles", "components", "boundary_edges", "boundary_loops", "nonmanifold_edges"]


def positions_of(path):
    vertex = read_ply(path, last="vertex")["vertex"]
    return np.stack([vertex[axis] for axis in "xyz"], 1).astype(np.float64)


def read_poses(path):
    """[(file, rotation, translation)] of a Stanford .conf, whose quaternions turn row vectors."""
    poses = []
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words and words[0] == "bmesh":
            values = np.array([float(word) for word in words[2:9]])
            x, y, z, w = values[3:] / np.linalg.norm(values[3:]) * (-1, -1, -1, 1)
            turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
            poses.append((words[1], turn, values[:3]))
    return poses


def merged(conf, target):
    """Writes the scans of a .conf as one cloud in world coordinates, each point with the direction to its scanner.
    Returns (files, spacing within the scans)."""
    files, pieces, spacings = [], [], []
    for name, turn, shift in read_poses(conf):
        files.append(conf.parent / name)
        own = positions_of(files[-1])
        spacings.append(spacing_of(own))
        piece = np.zeros(len(own), [(axis, "<f8") for axis in ("x", "y", "z", "sx", "sy", "sz")])
        for axis, values in zip("xyz", (own @ turn.T + shift).T):
            piece[axis] = values
        for axis, value in zip(("sx", "sy", "sz"), turn @ (0, 0, 1)):
            piece[axis] = value
        pieces.append(piece)
    write_cloud(target, np.concatenate(pieces))
    return files, float(np.median(spacings))


def spacing_of(positions):
    """Median distance to the nearest neighbour."""
    from scipy.spatial import cKDTree
    return float(np.median(cKDTree(positions).query(positions, k=2)[0][:, 1]))


def facts(program, mesh):
    """The program's count of a mesh file, whoever wrote it."""
    found = json.loads(harness.run([program, "inspect", mesh, "--json"])["stdout"])
    return {key: found[key] for key in FACTS + ["vertices", "unreferenced_vertices"]}


def picture(options, mesh, name):
    harness.run([options.program, "inspect", mesh, "--picture", pathlib.Path(options.out) / f"{name}.png"])


def scanned_part(mesh):
    """(positions, triangles) without the patches of holes."""
    positions, triangles = read_mesh(mesh)
    hole = read_ply(mesh)["face"].get("hole")
    return positions, triangles if hole is None else triangles[hole == 0]


def loops_before(report):
    """Boundary before the fill."""
    holes = report.get("holes", [])
    return {"loops_before": len(holes), "edges_before": sum(hole["edges"] for hole in holes)}


def own_row(result, **more):
    """A row of the program's run of harness.reconstruct()."""
    report = result["report"]
    mesh, given = report["mesh"], report["input"]
    kept = given["points_read"] - sum(given["points_dropped"].values())
    used = kept - report["points_unused"]
    row = {**more, "points": given["points_read"], "kept": kept, "used_share": used / kept if kept else 0.0,
           **{key: mesh[key] for key in FACTS}, **loops_before(report),
           "filled": sum(hole["filled"] for hole in report.get("holes", [])),
           "radii": report["radii"]["values"], "radii_reason": report["radii"]["reason"],
           "dropped": given["points_dropped"], "seconds": result["wall_seconds"],
           "peak_mib": result["peak_memory_bytes"] / (1 << 20), "notes": report.get("notes", [])}
    for section in ("normals", "cleaning"):
        if section in report:
            row[section] = report[section]
    return row


def _open3d(cloud, *arguments):
    words = [harness.peer_python(), harness.PEERS / "open3d_scans.py", cloud, *arguments]
    told = json.loads(harness.run(words)["stdout"].splitlines()[-1])
    return {"points": told["points"], "kept": told["points"], "seconds": told["seconds"],
            "peak_mib": told["peak_memory_bytes"] / (1 << 20)}


def open3d_rows(options, cloud, stem, spacing, depths):
    """Rows of Open3D on a cloud of merged(): ball pivoting, and Poisson of each depth as it is and trimmed; each with
    the mesh's path under "mesh"."""
    meshes = [("Open3D ball pivoting", f"{stem}-bpa.ply",
               _open3d(cloud, "--method", "bpa", "--radii", ball_radii(spacing), "--mesh", f"{stem}-bpa.ply"))]
    for depth in depths:
        whole, trimmed = f"{stem}-poisson-{depth}.ply", f"{stem}-poisson-{depth}-trimmed.ply"
        told = _open3d(cloud, "--method", "poisson", "--depth", depth, "--mesh", whole, "--trimmed", trimmed)
        meshes += [(f"Open3D Poisson {depth}", whole, told), (f"Open3D Poisson {depth}, trimmed", trimmed, told)]
    for name, mesh, told in meshes:
        found = facts(options.program, mesh)
        row = {"surface": name, "mesh": mesh, **told, **{key: found[key] for key in FACTS}}
        if mesh.endswith("-bpa.ply"):
            row["used_share"] = (found["vertices"] - found["unreferenced_vertices"]) / told["points"]
        yield row


def ball_radii(spacing):
    """Four radii for a peer that has none of its own: from one and a half times the spacing within a scan."""
    return ",".join(repr(1.5 ** (1 + k) * spacing) for k in range(4))
