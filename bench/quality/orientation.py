#!/usr/bin/env python3
"""Estimated, oriented normals side by side with Open3D's: share of points whose sign agrees with the truth,
angle error, CPU time, peak memory; the same in 1 chunk and in 64.

Vertices of Stanford models (truth: area-weighted normals of the faces), scans with normals of their own,
generated surfaces. The exit status is 1 when chunks give another result than the whole, or a closed model has
fewer than 0.999 agreeing signs.

usage: bench/quality/orientation.py DATA_DIR [--only NAME] [--no-open3d]
"""
import argparse
import json
import pathlib
import resource
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402
import harness  # noqa: E402

STANFORD = ["bun_zipper", "dragon_vrip_res3", "dragon_vrip_res2", "dragon_vrip"]
WITH_NORMALS = [("kitten.xyz", True), ("lion_takanawa_normals_rgb.ply", False)]
SURFACES = [("sphere", 2_000_000), ("torus", 2_000_000)]
COLUMNS = ["cloud", "points", "agree", "open3d_agree", "disagree", "mean_angle_degrees", "normal_seconds",
           "patch_seconds", "graph_seconds", "open3d_normal_seconds", "open3d_orient_seconds",
           "peak_memory_bytes", "open3d_peak_memory_bytes", "patches", "contested", "satisfied",
           "same_in_chunks", "verdict"]
LARGEST_FOR_OPEN3D = 500_000  # it takes a minute and 2.5 GB per million points


def workloads(options, work):
    """(name, cloud with normals, whether it is closed) of everything whose data are there."""
    data = pathlib.Path(options.data)
    for name in STANFORD:
        mesh = data / "stanford" / f"{name}.ply"
        if options.only in name and present(mesh):
            yield name, harness.oriented(options.program, work, mesh), True
    for name, closed in WITH_NORMALS:
        cloud = data / "points_normals" / name
        if options.only in name and present(cloud):
            yield name, cloud, closed
    for shape, points in SURFACES:
        if options.only in shape:
            yield shape, harness.generated(options.program, work, shape, points), True


def present(path):
    if not path.exists():
        print(f"skipped, no such file: {path}")
    return path.exists()


def open3d_worker(cloud):
    """Runs in a process of its own, so that its peak memory is its own."""
    import numpy
    import open3d
    truth = open3d.io.read_point_cloud(str(cloud), format="xyzn" if cloud.endswith(".xyz") else "auto")
    normals = numpy.asarray(truth.normals)
    points = open3d.geometry.PointCloud(truth.points)
    begin = time.process_time()
    points.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(17))
    middle = time.process_time()
    points.orient_normals_consistent_tangent_plane(16)
    end = time.process_time()
    agree = float(((numpy.asarray(points.normals) * normals).sum(axis=1) > 0).mean())
    print(json.dumps({"agree": agree, "normal_seconds": middle - begin, "orient_seconds": end - middle,
                      "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}))


def measured(options, name, cloud, closed):
    bench = pathlib.Path(options.program).with_name("bench_orientation")
    # Memory of the whole alone: the run in chunks holds both results.
    alone = harness.run([bench, cloud])
    row = {"cloud": name, **json.loads(harness.run([bench, cloud, 64])["stdout"]),
           "peak_memory_bytes": alone["peak_memory_bytes"]}
    row["verdict"] = "ok"
    if not row["same_in_chunks"]:
        row["verdict"] = "chunks differ"
    elif closed and row["agree"] < 0.999:
        row["verdict"] = "signs"
    if options.open3d and row["points"] <= LARGEST_FOR_OPEN3D:
        peer = json.loads(harness.run([harness.peer_python(), __file__, "--worker", cloud])["stdout"])
        row.update({f"open3d_{key}": value for key, value in peer.items()})
    return row


def main():
    if sys.argv[1:2] == ["--worker"]:
        return open3d_worker(sys.argv[2])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", metavar="DATA_DIR")
    parser.add_argument("--only", default="", help="workloads whose name holds this")
    parser.add_argument("--no-open3d", dest="open3d", action="store_false")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows = []
    for workload in workloads(options, work):
        rows.append(measured(options, *workload))
        print(json.dumps({key: rows[-1].get(key) for key in COLUMNS}), flush=True)
    result = {"machine": harness.machine(), "commit": harness.commit(), "rows": rows}
    (pathlib.Path(options.out) / "orientation.json").write_text(json.dumps(result, indent=1) + "\n")
    return 0 if all(row["verdict"] == "ok" for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
