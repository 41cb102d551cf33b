#!/usr/bin/env python3
"""Open3D's ball pivoting on an oriented PLY cloud; prints one JSON object.

Seconds are those of loading, of the reconstruction alone ("kernel") and of writing; neither the start of
the interpreter nor the import is in them.
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
from meshes import edge_facts  # noqa: E402


def timed(call):
    begin = time.perf_counter()
    result = call()
    return result, time.perf_counter() - begin


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cloud", help="PLY with normals")
    parser.add_argument("--radii", required=True, help="R,R,...")
    parser.add_argument("--mesh", help="write the mesh there (PLY)")
    parser.add_argument("--no-counts", action="store_true", help="leave the edges uncounted")
    options = parser.parse_args()
    radii = [float(text) for text in options.radii.split(",")]

    cloud, load_seconds = timed(lambda: open3d.io.read_point_cloud(options.cloud))
    if not cloud.has_normals():
        sys.exit(f"{options.cloud}: no normals")
    mesh, kernel_seconds = timed(
        lambda: open3d.geometry.TriangleMesh.create_from_point_cloud_ball_pivoting(
            cloud, open3d.utility.DoubleVector(radii)))
    write_seconds = 0.0
    if options.mesh:
        _, write_seconds = timed(lambda: open3d.io.write_triangle_mesh(options.mesh, mesh))
    peak_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    facts = {"program": f"Open3D {open3d.__version__}", "points": len(cloud.points), "radii": radii,
             "load_seconds": load_seconds, "kernel_seconds": kernel_seconds,
             "write_seconds": write_seconds, "peak_memory_bytes": peak_bytes}
    if not options.no_counts:
        facts.update(edge_facts(np.asarray(mesh.triangles)))
    print(json.dumps(facts))


if __name__ == "__main__":
    main()
