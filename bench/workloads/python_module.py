#!/usr/bin/env python3
"""What a call from Python costs beside the command line: CPU seconds, seconds and peak memory of the same cloud by the
program, by orbweave.run() on the same file and by orbweave.reconstruct() on arrays, in turn. The exit status is 1 where the
bytes differ, or where run() takes over 5 % more CPU time or memory than the program.

usage: bench/workloads/python_module.py [--points N] [--repeats N]
"""
import argparse
import hashlib
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import harness  # noqa: E402

RUN = """
import sys
sys.path.insert(0, sys.argv[1])
import orbweave
orbweave.run({"input": {"files": [sys.argv[2]]}, "output": {"mesh": sys.argv[3]}}, settings={"run.threads": 2})
"""
# The file is read first, so that the peak has the arrays of the caller in it.
RECONSTRUCT = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy, orbweave
cloud = numpy.load(sys.argv[2])
mesh = orbweave.reconstruct(cloud["points"], cloud["normals"], threads=2)
orbweave.write_mesh(sys.argv[3], mesh)
"""
ARRAYS = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy, orbweave
cloud = orbweave.read_points(sys.argv[2])
numpy.savez(sys.argv[3], points=cloud.points, normals=cloud.normals)
"""


def row_of(name, points, results, digest):
    cpu = statistics.median(r["user_seconds"] + r["system_seconds"] for r in results)
    peak = statistics.median(r["peak_memory_bytes"] for r in results)
    return {"variant": name, "points": points, "cpu_seconds": cpu, "seconds": statistics.median(r["wall_seconds"] for r in results),
            "peak_memory_mib": peak / 2 ** 20, "bytes_per_point": peak / points, "digest": digest}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    harness.add_common_options(parser)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    work = harness.prepare(options)
    module = pathlib.Path(options.program).resolve().parent.parent / "python"
    python = "/usr/bin/python3"
    cloud = harness.made(work / f"python-{options.points}.ply",
                         [options.program, "generate", "torus", "--points", options.points, "--noise", "0.1", "-o",
                          work / f"python-{options.points}.ply"])
    arrays = work / f"python-{options.points}.npz"
    harness.run([python, "-c", ARRAYS, module, cloud, arrays])
    meshes = {name: work / f"python-{name}.ply" for name in ("program", "run", "reconstruct")}
    calls = {"program": [options.program, "reconstruct", cloud, "-o", meshes["program"], "--threads", "2", "--progress", "none"],
             "run": [python, "-c", RUN, module, cloud, meshes["run"]],
             "reconstruct": [python, "-c", RECONSTRUCT, module, arrays, meshes["reconstruct"]]}
    results = harness.alternate({name: lambda words=words: harness.run(words) for name, words in calls.items()}, options.repeats)
    rows = [row_of(name, options.points, results[name], hashlib.sha256(meshes[name].read_bytes()).hexdigest()[:12]) for name in calls]
    print(harness.table(rows, list(rows[0])))
    program, run = rows[:2]
    same = len({row["digest"] for row in rows}) == 1
    cpu, memory = run["cpu_seconds"] / program["cpu_seconds"], run["peak_memory_mib"] / program["peak_memory_mib"]
    print(f"same bytes: {same}; run() over the program: CPU {cpu:.3f}, memory {memory:.3f}")
    for path in (*meshes.values(), arrays):
        path.unlink()
    return 0 if same and cpu < 1.05 and memory < 1.05 else 1


if __name__ == "__main__":
    sys.exit(main())
