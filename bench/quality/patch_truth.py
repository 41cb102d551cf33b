"""How far the patches of a mesh lie from the truth, hole by hole, and what their confidence is worth."""
import harness
import numpy as np
from meshes import read_ply

NEAR = 2.0  # spacings: what a confidence is the chance of
CLASSES = ((0.0, 0.1), (0.1, 0.3), (0.3, 0.5), (0.5, 0.7), (0.7, 0.85), (0.85, 0.95), (0.95, 1.01))
SPLITS = 3  # of each edge of a triangle, for points inside it
COLUMNS = ["scene", "method", "confidence", "holes", "mean_confidence", "near", "median_rms", "area", "area_near"]


def split_triangles(corners):
    """(n, 3, 3) corners -> the corners of SPLITS^2 equal parts of each."""
    steps = np.arange(SPLITS + 1) / SPLITS
    parts = []
    for i in range(SPLITS):
        for j in range(SPLITS - i):
            parts.append(((i, j), (i + 1, j), (i, j + 1)))
            if j < SPLITS - i - 1:
                parts.append(((i + 1, j), (i + 1, j + 1), (i, j + 1)))
    weights = np.array([[[1 - steps[a] - steps[b], steps[a], steps[b]] for a, b in part] for part in parts])
    return np.einsum("pkc,ncx->npkx", weights, corners).reshape(-1, 3, 3)


def write_triangles(path, corners):
    """A PLY of triangles that share no vertex."""
    count = len(corners)
    faces = np.zeros(count, [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = np.arange(3 * count).reshape(-1, 3)
    with open(path, "wb") as stream:
        stream.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {3 * count}\nproperty double x\n"
                      f"property double y\nproperty double z\nelement face {count}\n"
                      "property list uchar int vertex_indices\nend_header\n").encode())
        stream.write(np.ascontiguousarray(corners, "<f8").tobytes())
        stream.write(faces.tobytes())


def patch_rows(program, work, mesh, report, truth, spacing):
    """One row per filled hole with an area: method, edges, confidence, area and the root mean square distance to the
    truth in spacings, of the middles of equal parts of its triangles. Holes whose own rims are off are left out: there the
    scan is of leaves, of a person or of nothing that the truth has."""
    filled = read_ply(mesh)
    vertex, face = filled["vertex"], filled["face"]
    positions = np.stack([np.asarray(vertex[axis], float) for axis in "xyz"], 1)
    hole = np.asarray(face["hole"])
    of_patch = np.flatnonzero(hole)
    triangles = np.asarray(face["vertex_indices"])
    corners = positions[triangles[of_patch]]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    parts = SPLITS ** 2
    middles = split_triangles(corners).mean(axis=1)
    # The tool measures at vertices: one small triangle stands for each point.
    points, errors = work / "patch-points.ply", work / "patch-errors.ply"
    tiny = 1e-6 * spacing * np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    write_triangles(points, middles[:, None, :] + tiny[None])
    harness.run([program, "compare", points, truth, "--errors", errors])
    distance = np.asarray(read_ply(errors)["vertex"]["error"], float)[::3]
    harness.run([program, "compare", mesh, truth, "--errors", errors])
    at_vertex = np.asarray(read_ply(errors)["vertex"]["error"], float)
    is_scanned = np.zeros(len(positions), bool)
    is_scanned[triangles[hole == 0].ravel()] = True
    squares = (distance ** 2).reshape(-1, parts).mean(axis=1) * areas
    size = np.bincount(hole[of_patch], areas)
    square = np.bincount(hole[of_patch], squares)
    rim = np.full(len(size), np.inf)
    order = np.argsort(hole[of_patch], kind="stable")
    numbers, first = np.unique(hole[of_patch][order], return_index=True)
    for number, members in zip(numbers, np.split(order, first[1:])):
        vertices = np.unique(triangles[of_patch[members]])
        vertices = vertices[is_scanned[vertices]]
        rim[number] = np.median(at_vertex[vertices]) / spacing if len(vertices) else np.inf
    rows = []
    for facts in report["holes"]:
        number = facts["id"]
        if facts["filled"] and number < len(size) and size[number] > 0 and rim[number] <= NEAR:
            rows.append({**facts, "rms": float(np.sqrt(square[number] / size[number])) / spacing,
                         "area": float(size[number])})
    return rows


def class_rows(scene, holes):
    """By method and class of confidence, and of all methods together."""
    for method in sorted({hole["method"] for hole in holes}) + ["all"]:
        for low, high in CLASSES:
            members = [hole for hole in holes if method in ("all", hole["method"]) and low <= hole["confidence"] < high]
            if members:
                near = np.array([hole["rms"] <= NEAR for hole in members])
                area = np.array([hole["area"] for hole in members])
                yield {"scene": scene, "method": method, "confidence": f"{low:.2f} .. {min(high, 1.0):.2f}",
                       "holes": len(members), "mean_confidence": float(np.mean([h["confidence"] for h in members])),
                       "near": float(near.mean()), "median_rms": float(np.median([h["rms"] for h in members])),
                       "area": float(area.sum()), "area_near": float((area * near).sum() / area.sum())}
