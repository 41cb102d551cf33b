"""How far two surfaces are apart, by points spread evenly over each. Needs Debian's python3-scipy."""
import numpy as np
from scipy.spatial import cKDTree

SAMPLES = 50_000  # of each surface, to measure from
PLACES = 200_000  # on the other surface, beside one in each triangle, by which the nearest triangles are found
TRIED = 8  # of them per measured point


def spread_points(positions, triangles, count, seed=20260401):
    """(points, their triangles): random, the same for the same mesh."""
    corners = positions[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(seed)
    ends = np.cumsum(area)
    chosen = np.searchsorted(ends, rng.random(count) * ends[-1]).clip(max=len(area) - 1)
    along, across = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - along, along * (1 - across), along * across], 1)
    return (weights[:, :, None] * corners[chosen]).sum(1), chosen


def _to_segment(p, a, b):
    edge = b - a
    length = np.maximum((edge * edge).sum(1), 1e-300)
    t = np.clip(((p - a) * edge).sum(1) / length, 0.0, 1.0)
    return np.linalg.norm(p - a - t[:, None] * edge, axis=1)


def to_triangles(p, corners):
    """Distance of point k from triangle k."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    height = np.abs(((p - a) * normal).sum(1)) / np.maximum(length, 1e-300)
    above = length > 0.0
    for tail, head in ((a, b), (b, c), (c, a)):
        above &= (np.cross(head - tail, p - tail) * normal).sum(1) >= 0.0
    rim = np.minimum(np.minimum(_to_segment(p, a, b), _to_segment(p, b, c)), _to_segment(p, c, a))
    return np.where(above, height, rim)


def to_surface(points, positions, triangles):
    """Distance of each point from the nearest of the triangles that lie around it."""
    places, owners = spread_points(positions, triangles, PLACES, seed=20260402)
    places = np.concatenate([positions[triangles].mean(1), places])
    owners = np.concatenate([np.arange(len(triangles)), owners])
    near = owners[cKDTree(places).query(points, k=TRIED, workers=-1)[1]]
    distance = np.full(len(points), np.inf)
    for k in range(TRIED):
        distance = np.minimum(distance, to_triangles(points, positions[triangles[near[:, k]]]))
    return distance


def between(mesh, truth, unit=1.0):
    """Each mesh is (positions, triangles). Mean, 95th percentile and largest distance, in `unit`s, from the mesh to
    the truth (prefix "") and from the truth to the mesh ("back_")."""
    row = {}
    for prefix, source, target in (("", mesh, truth), ("back_", truth, mesh)):
        if len(source[1]) == 0 or len(target[1]) == 0:
            row.update({prefix + key: float("nan") for key in ("mean", "p95", "max")})
            continue
        distance = to_surface(spread_points(*source, SAMPLES)[0], *target) / unit
        row.update({prefix + "mean": float(distance.mean()), prefix + "p95": float(np.quantile(distance, 0.95)),
                    prefix + "max": float(distance.max())})
    return row
