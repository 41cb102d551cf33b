#!/usr/bin/python3
"""What compressing the work directory (run.compress) saves and costs: bytes per point of every stage that leaves
results there, the most that a job holds on disk, and seconds, with and without, alternating.

The exit status is 1 where the mesh is not the same, byte for byte, or the store does not get smaller.

usage: bench/compression.py [--points N] [--repeats N] [--memory SIZE] [--cloud FILE] [--program P] [--output DIR]
"""
import argparse
import hashlib
import json
import pathlib
import statistics
import sys
import tempfile

import harness


def checksum(path):
    digest = hashlib.blake2b()
    with open(path, "rb") as file:
        while piece := file.read(1 << 22):
            digest.update(piece)
    return digest.hexdigest()


def run_job(options, cloud, work, compress):
    mesh, report = work / "mesh.ply", work / "report.json"
    words = [options.program, "reconstruct", cloud, "-o", mesh, "--radii",
             1.3 * harness.spacing("torus", options.points), "--memory", options.memory, "--work-dir", work / "work",
             "--report", report, "--progress", "none"]
    measured = harness.run(words + (["--compress"] if compress else []))
    facts = json.loads(report.read_text())
    stages = {stage["name"]: stage for stage in facts["stages"]}
    result = {"seconds": measured["wall_seconds"], "cpu_seconds": measured["user_seconds"] + measured["system_seconds"],
              "peak_memory_bytes": measured["peak_memory_bytes"], "disk_bytes": facts["measured"]["disk_bytes"],
              "points_bytes": stages["sort"]["bytes_written"] / options.points,
              "mesh_bytes": stages["reconstruct"]["bytes_written"] / options.points, "checksum": checksum(mesh)}
    mesh.unlink()
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=10_000_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--memory", default="1GiB")
    parser.add_argument("--cloud", help="a torus of so many points; generated where it is not given")
    parser.add_argument("--program", default=str(harness.ROOT / "build/release/bin/orbweave"))
    parser.add_argument("--output", default=".")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        work = pathlib.Path(place)
        cloud = options.cloud
        if cloud is None:
            cloud = work / "cloud.ply"
            harness.run([options.program, "generate", "torus", "--points", options.points, "-o", cloud])
        runs = harness.alternate({"plain": lambda: run_job(options, cloud, work, False),
                                  "compressed": lambda: run_job(options, cloud, work, True)}, options.repeats)
    rows = {}
    for name, results in runs.items():
        rows[name] = {key: statistics.median(result[key] for result in results)
                      for key in results[0] if key != "checksum"}
        print(f"{name:11} points {rows[name]['points_bytes']:6.1f} B/point, mesh {rows[name]['mesh_bytes']:6.1f} B/point, "
              f"most on disk {rows[name]['disk_bytes'] / options.points:6.1f} B/point, "
              f"{rows[name]['seconds']:6.1f} s, {rows[name]['cpu_seconds']:6.1f} s of CPU")
    same = len({result["checksum"] for results in runs.values() for result in results}) == 1
    smaller = rows["compressed"]["disk_bytes"] < rows["plain"]["disk_bytes"]
    print("the same bytes" if same else "OTHER BYTES")
    result = {"workload": "compression", "points": options.points, "machine": harness.machine(), "medians": rows,
              "runs": runs, "same_bytes": same}
    (pathlib.Path(options.output) / "compression.json").write_text(json.dumps(result, indent=2) + "\n")
    sys.exit(0 if same and smaller else 1)


if __name__ == "__main__":
    main()
