#!/usr/bin/env python3
"""What a call from Python costs beside the command line: CPU seconds, seconds and peak memory of the same cloud by the
program, by orbweave.run() on the same file and by orbweave.reconstruct() on arrays, in turn. A call is measured from the
arrays, or the file, to the written mesh; starting Python is not part of it. Its memory is the peak of the process less what
the process held before the call and less the arrays that the mesh gives out: the program has both in files. The exit status is
1 where the bytes differ, or where a call takes over 5 % more CPU time or memory than the program.

usage: bench/workloads/python_module.py [--points N | --scan FILE] [--repeats N]
"""
import argparse
import hashlib
import json
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import harness  # noqa: E402

MEASURED = """
import json, resource, sys, time
sys.path.insert(0, sys.argv[1])
import numpy, orbweave

def usage():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime, time.monotonic(), used.ru_maxrss * 1024

def told(before, arrays=()):
    after = usage()
    print(json.dumps({"cpu_seconds": after[0] - before[0], "seconds": after[1] - before[1],
                      "peak_memory_bytes": after[2] - before[2] - sum(array.nbytes for array in arrays)}))
"""
RUN = MEASURED + """
before = usage()
orbweave.run({"input": {"files": [sys.argv[2]]}, "output": {"mesh": sys.argv[3]}}, settings={"run.threads": 2})
told(before)
"""
RECONSTRUCT = MEASURED + """
points, normals = numpy.load(sys.argv[2]), numpy.load(sys.argv[3])
attributes = dict(numpy.load(sys.argv[4])) or None
before = usage()
mesh = orbweave.reconstruct(points, normals if len(normals) else None, attributes=attributes, threads=2)
orbweave.write_mesh(sys.argv[5], mesh)
told(before, (mesh.vertices, mesh.normals, mesh.triangles, mesh.triangle_hole))
"""
ARRAYS = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy, orbweave
cloud = orbweave.read_points(sys.argv[2])
numpy.save(sys.argv[3], cloud.points)
numpy.save(sys.argv[4], cloud.points[:0] if cloud.normals is None else cloud.normals)
numpy.savez(sys.argv[5], **cloud.attributes)
print(len(cloud))
"""


def measures(result):
    """CPU seconds, seconds and peak memory: of the call where the process tells them, else of the process."""
    if result["stdout"].startswith("{"):
        return json.loads(result["stdout"])
    return {"cpu_seconds": result["user_seconds"] + result["system_seconds"], "seconds": result["wall_seconds"],
            "peak_memory_bytes": result["peak_memory_bytes"]}


def row_of(name, points, results, digest):
    of_runs = [measures(result) for result in results]
    median = {key: statistics.median(run[key] for run in of_runs) for key in of_runs[0]}
    return {"variant": name, "points": points, "cpu_seconds": median["cpu_seconds"], "seconds": median["seconds"],
            "peak_memory_mib": median["peak_memory_bytes"] / 2 ** 20, "digest": digest}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    harness.add_common_options(parser)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--scan", type=pathlib.Path, help="a cloud instead of a generated one")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    work = harness.prepare(options)
    module = pathlib.Path(options.program).resolve().parent.parent / "python"
    python = "/usr/bin/python3"
    cloud = options.scan or harness.made(work / f"python-{options.points}.ply",
                                         [options.program, "generate", "torus", "--points", options.points, "--noise", "0.1",
                                          "-o", work / f"python-{options.points}.ply"])
    arrays = [work / f"python-{name}" for name in ("points.npy", "normals.npy", "attributes.npz")]
    points = int(harness.run([python, "-c", ARRAYS, module, cloud, *arrays])["stdout"])
    meshes = {name: work / f"python-{name}.ply" for name in ("program", "run", "reconstruct")}
    calls = {"program": [options.program, "reconstruct", cloud, "-o", meshes["program"], "--threads", "2", "--progress", "none"],
             "run": [python, "-c", RUN, module, cloud, meshes["run"]],
             "reconstruct": [python, "-c", RECONSTRUCT, module, *arrays, meshes["reconstruct"]]}
    results = harness.alternate({name: lambda words=words: harness.run(words) for name, words in calls.items()}, options.repeats)
    rows = [row_of(name, points, results[name], hashlib.sha256(meshes[name].read_bytes()).hexdigest()[:12]) for name in calls]
    print(harness.table(rows, list(rows[0])))
    ratios = {row["variant"]: {key: row[key] / rows[0][key] for key in ("cpu_seconds", "seconds", "peak_memory_mib")}
              for row in rows[1:]}
    for name, ratio in ratios.items():
        print(f"{name}() over the program: CPU {ratio['cpu_seconds']:.3f}, seconds {ratio['seconds']:.3f}, "
              f"memory {ratio['peak_memory_mib']:.3f}")
    same = len({row["digest"] for row in rows}) == 1
    print(f"same bytes: {same}")
    for path in (*meshes.values(), *arrays):
        path.unlink()
    cheap = all(ratio[key] < 1.05 for ratio in ratios.values() for key in ("cpu_seconds", "peak_memory_mib"))
    return 0 if same and cheap else 1


if __name__ == "__main__":
    sys.exit(main())
