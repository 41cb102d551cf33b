#!/usr/bin/env python3
"""Ball pivoting alone against Open3D's, one core each, on the same clouds in the same run.

A torus of 2M points at 1.3 spacings and the Stanford dragon of 437,645 points at 0.00069. Neither reading nor
writing counts. Programs alternate; figures are medians. The exit status is 1 when the ratio is below 10.

usage: bench/workloads/kernel.py DATA_DIR [--repeats N]
"""
import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402
import harness  # noqa: E402

TORUS_POINTS = 2_000_000
DRAGON_RADIUS = 0.00069
LEAST_RATIO = 10.0
COLUMNS = ["cloud", "points", "points_per_second", "open3d_points_per_second", "ratio", "triangles",
           "open3d_triangles", "two_threads_speedup", "verdict"]


def workloads(options, work):
    torus = harness.generated(options.program, work, "torus", TORUS_POINTS)
    yield "torus 2M", torus, 1.3 * harness.spacing("torus", TORUS_POINTS)
    mesh = pathlib.Path(options.data) / "stanford" / "dragon_vrip.ply"
    if mesh.exists():
        yield "dragon_vrip", harness.oriented(options.program, work, mesh), DRAGON_RADIUS
    else:
        print(f"skipped, no such file: {mesh}")


def kernel(options, cloud, radius, threads):
    bench = pathlib.Path(options.program).parent / "bench_kernel"
    return lambda: json.loads(harness.run([bench, cloud, repr(radius), 1, threads])["stdout"])


def open3d(cloud, radius):
    words = [harness.peer_python(), harness.PEERS / "open3d_peer.py", cloud, "--radii", repr(radius)]
    return lambda: json.loads(harness.run(words)["stdout"])


def measure(options, name, cloud, radius):
    results = harness.alternate({"one": kernel(options, cloud, radius, 1),
                                 "open3d": open3d(cloud, radius),
                                 "two": kernel(options, cloud, radius, 2)}, options.repeats)
    one = harness.spread([r["wall_seconds"][0] for r in results["one"]])
    two = harness.spread([r["wall_seconds"][0] for r in results["two"]])
    peer = harness.spread([r["kernel_seconds"] for r in results["open3d"]])
    points = results["one"][0]["points"]
    ratio = peer["median"] / one["median"]
    return {"cloud": name, "points": points, "radius": radius,
            "points_per_second": points / one["median"],
            "open3d_points_per_second": points / peer["median"], "ratio": ratio,
            "triangles": results["one"][0]["triangles"],
            "open3d_triangles": results["open3d"][0]["triangles"],
            "two_threads_speedup": one["median"] / two["median"],
            "seconds": one, "open3d_seconds": peer, "two_threads_seconds": two,
            "verdict": "ok" if ratio >= LEAST_RATIO else "too slow"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="directory of real scans, with stanford/")
    parser.add_argument("--repeats", type=int, default=5)
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows = [measure(options, *workload) for workload in workloads(options, work)]
    print("\n" + harness.table(rows, COLUMNS))
    harness.write_results(options, "kernel", rows)
    return 0 if all(row["verdict"] == "ok" for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
