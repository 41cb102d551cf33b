#!/usr/bin/env python3
"""Open3D on merged raw scans, whose points say where their scanner lies; prints one JSON object.

Normals are estimated from 16 neighbours and turned towards the scanners. Then ball pivoting, or screened Poisson
reconstruction, whose mesh is written a second time, trimmed where few points support it.
"""
import argparse
import json
import pathlib
import resource
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy", "open3d")

import numpy as np  # noqa: E402
import open3d  # noqa: E402
from meshes import read_ply  # noqa: E402


def oriented_cloud(path):
    """(the cloud with normals, seconds of loading, seconds of the normals)"""
    begin = time.perf_counter()
    vertex = read_ply(path)["vertex"]
    positions, to_scanner = (np.stack([vertex[axis] for axis in axes], 1).astype(np.float64)
                             for axes in (("x", "y", "z"), ("sx", "sy", "sz")))
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(positions))
    loaded = time.perf_counter()
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(16))
    normals = np.asarray(cloud.normals)
    normals[(normals * to_scanner).sum(1) < 0] *= -1
    cloud.normals = open3d.utility.Vector3dVector(normals)
    return cloud, loaded - begin, time.perf_counter() - loaded


def reconstruct(cloud, options):
    """(mesh, density of the points at its vertices or None)"""
    if options.method == "poisson":
        mesh, density = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=options.depth)
        return mesh, np.asarray(density)
    radii = [float(text) for text in options.radii.split(",")]
    return open3d.geometry.TriangleMesh.create_from_point_cloud_ball_pivoting(
        cloud, open3d.utility.DoubleVector(radii)), None


def write(path, mesh):
    """Double coordinates without normals: what distances are measured with."""
    mesh.vertex_normals = open3d.utility.Vector3dVector()
    open3d.io.write_triangle_mesh(path, mesh, write_vertex_normals=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cloud", help="PLY with x, y, z and, towards the scanner, sx, sy, sz")
    parser.add_argument("--method", choices=["bpa", "poisson"], required=True)
    parser.add_argument("--radii", help="R,R,... of ball pivoting")
    parser.add_argument("--depth", type=int, default=9, help="of Poisson's octree")
    parser.add_argument("--mesh", required=True, help="write the mesh there (PLY)")
    parser.add_argument("--trimmed", help="write Poisson's mesh there, too, less --trim of its vertices")
    parser.add_argument("--trim", type=float, default=0.02, help="the part of the vertices with the least density")
    options = parser.parse_args()
    cloud, load_seconds, normal_seconds = oriented_cloud(options.cloud)
    begin = time.perf_counter()
    mesh, density = reconstruct(cloud, options)
    kernel_seconds = time.perf_counter() - begin
    write(options.mesh, mesh)
    if options.trimmed:
        mesh.remove_vertices_by_mask(density < np.quantile(density, options.trim))
        write(options.trimmed, mesh)
    print(json.dumps({"program": f"Open3D {open3d.__version__}", "points": len(cloud.points),
                      "load_seconds": load_seconds, "normal_seconds": normal_seconds,
                      "kernel_seconds": kernel_seconds,
                      "seconds": load_seconds + normal_seconds + kernel_seconds,
                      "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}))


if __name__ == "__main__":
    main()
