#!/usr/bin/env python3
"""Whole jobs of raw scans beside other programs, normals included, in turn, and what further radii cost.

  autzen   the airborne tile, with the radii that configs/airborne-lidar.toml finds
  bunny    the ten range scans of the Stanford bunny, merged, with the radii that configs/raw-scans.toml finds

Open3D and MeshLab estimate normals from 16 neighbours and pivot a ball at each of these radii; CGAL's advancing front
needs neither. A program that fails, or has not ended after --limit seconds, has a row that says so. "orbweave, same work" takes
no outliers out and fills no hole. Programs that are missing are named and left out. Seconds are those of whole
processes, reading and writing included; ratios are to the first row.

usage: bench/peers/raw_peers.py DATA_DIR [autzen|bunny]... [--repeats N] [--limit SECONDS]
"""
import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

for folder in (".", "quality"):
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / folder))
import interpreter  # noqa: E402

interpreter.need("numpy", "scipy")

import harness  # noqa: E402
import numpy as np  # noqa: E402
import scans  # noqa: E402
from meshes import read_ply, write_cloud  # noqa: E402

ADVANCING_FRONT = harness.ROOT / "build/release/bin/bench_advancing_front"
SAME_WORK = ["cleaning.outlier_sigma=0", "cleaning.auto=false", "fill.enabled=false"]
COLUMNS = ["program", "points", "triangles", "seconds", "cpu_seconds", "ratio", "peak_mib"]


class Scan:
    """A raw cloud: the job that the program runs, and one merged file with directions to the scanner for peers."""

    def __init__(self, options, work, name):
        data = pathlib.Path(options.data)
        self.name, self.settings = name, []
        if name == "autzen":
            self.files = [data / "lidar/autzen_stadium_tile_las12_pf2.las"]
            self.job = harness.ROOT / "configs/airborne-lidar.toml"
        else:
            conf = data / "stanford/bunny_scans/bun.conf"
            self.files = [conf.parent / file for file, _, _ in scans.read_poses(conf)] if conf.exists() else [conf]
            self.job = harness.ROOT / "configs/raw-scans.toml"
            self.settings = [f"input.poses={conf.resolve()}"]
        self.cloud = work / f"peers-{name}.ply"
        self.missing = next((file for file in self.files if not file.exists()), None)
        if self.missing is None:
            self._write_cloud(options.program, work)

    def _write_cloud(self, program, work):
        if self.name == "bunny":
            scans.merged(pathlib.Path(self.settings[0].split("=")[1]), self.cloud)
            return
        converted = work / "peers-converted.ply"
        harness.run([program, "convert", self.files[0], converted])
        positions = scans.positions_of(converted)
        rows = np.zeros(len(positions), [(axis, "<f8") for axis in ("x", "y", "z", "sx", "sy", "sz")])
        # Peers with float coordinates would lose a tile on a map.
        for axis, values in zip("xyz", (positions - np.floor(positions.mean(0))).T):
            rows[axis] = values
        rows["sz"] = 1
        write_cloud(self.cloud, rows)


def own(options, scan, mesh, settings):
    result = harness.run_job(options.program, scan.job, scan.files, mesh, [*scan.settings, *settings])
    return {"points": result["report"]["input"]["points_read"], "triangles": result["report"]["mesh"]["triangles"],
            "report": result["report"], **measured(result)}


def measured(result):
    return {"seconds": result["wall_seconds"], "cpu_seconds": result["user_seconds"] + result["system_seconds"],
            "peak_mib": result["peak_memory_bytes"] / (1 << 20)}


def limited(options, words):
    """harness.run() of a peer, or in words why it has no result: it failed, or had not ended within the limit."""
    # The launcher of MeshLab's display leaves the program behind unless the whole group is stopped: timeout does so.
    begin = time.monotonic()
    limit = ["timeout", "--kill-after=5", str(options.limit), *words]
    done = subprocess.run(["/usr/bin/time", "-q", "-f", "\n%e %U %S %M", *[str(word) for word in limit]],
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if time.monotonic() - begin >= options.limit:
        return f"none after {options.limit} s"
    if done.returncode != 0:
        print(f"exit status {done.returncode} from {' '.join(map(str, words))}\n{done.stderr[-1000:]}")
        return f"ended with status {done.returncode}"
    wall, user, system, peak = done.stderr.split()[-4:]
    return {"wall_seconds": float(wall), "user_seconds": float(user), "system_seconds": float(system),
            "peak_memory_bytes": int(peak) * 1024, "stdout": done.stdout}


def open3d(options, scan, mesh, radii):
    return [harness.peer_python(), harness.PEERS / "open3d_scans.py", scan.cloud, "--method", "bpa", "--radii",
            ",".join(repr(radius) for radius in radii), "--mesh", mesh]


MESHLAB_NORMALS = """ <filter name="Compute normals for point sets">
  <Param type="RichInt" value="16" name="K"/>
  <Param type="RichInt" value="0" name="smoothIter"/>
  <Param type="RichBool" value="true" name="flipFlag"/>
  <Param type="RichPoint3f" x="0" y="0" z="1e6" name="viewPos"/>
 </filter>
"""
MESHLAB_PIVOT = """ <filter name="Surface Reconstruction: Ball Pivoting">
  <Param type="RichAbsPerc" value="{}" min="0" max="1e9" name="BallRadius"/>
  <Param type="RichFloat" value="20" name="Clustering"/>
  <Param type="RichFloat" value="90" name="CreaseThr"/>
  <Param type="RichBool" value="false" name="DeleteFaces"/>
 </filter>
"""


def meshlab(scan, mesh, radii):
    script = mesh.with_suffix(".mlx")
    filters = MESHLAB_NORMALS + "".join(MESHLAB_PIVOT.format(repr(radius)) for radius in radii)
    script.write_text(f"<!DOCTYPE FilterScript>\n<FilterScript>\n{filters}</FilterScript>\n", encoding="utf-8")
    return ["env", "QT_QPA_PLATFORM=offscreen", "xvfb-run", "-a", "meshlabserver", "-i", scan.cloud, "-o", mesh, "-s",
            script]


def peer_row(options, name, words, mesh):
    """The row of a peer; without seconds where it has no result."""
    mesh.unlink(missing_ok=True)
    result = limited(options, words)
    if isinstance(result, str):
        return {"program": name, "triangles": result}
    points = len(read_ply(mesh, last="vertex")["vertex"]["x"])
    found = json.loads(harness.run([options.program, "inspect", mesh, "--json"])["stdout"])
    return {"program": name, "points": points, "triangles": found["triangles"], **measured(result)}


def peers(options, work, scan, radii):
    """[(name, words, mesh)] of those that are here."""
    mesh = work / f"peers-{scan.name}-other.ply"
    found = []
    if interpreter.with_packages("open3d"):
        found.append(("Open3D ball pivoting", open3d(options, scan, mesh, radii), mesh))
    else:
        print("left out, no Python with it: Open3D")
    if shutil.which("meshlabserver") and shutil.which("xvfb-run"):
        found.append(("MeshLab ball pivoting", meshlab(scan, mesh, radii), mesh))
    else:
        print("left out, no meshlabserver with xvfb-run: MeshLab")
    if ADVANCING_FRONT.exists():
        found.append(("CGAL advancing front", [ADVANCING_FRONT, scan.cloud, mesh], mesh))
    else:
        print(f"left out, no {ADVANCING_FRONT.name}: CGAL")
    return found


def median_row(rows):
    """The first of equal runs with the medians of their figures; a run without a result stands for all."""
    row = next((row for row in rows if "seconds" not in row), rows[0])
    for key in ("seconds", "cpu_seconds", "peak_mib"):
        if key in row:
            row = {**row, key: statistics.median(each[key] for each in rows)}
    return row


def measure(options, work, name):
    scan = Scan(options, work, name)
    if scan.missing:
        print(f"skipped, no such file: {scan.missing}")
        return []
    mesh = work / f"peers-{name}.ply-mesh.ply"
    radii = own(options, scan, mesh, [])["report"]["radii"]["values"]
    runs = {"orbweave, whole job": lambda: own(options, scan, mesh, []),
            "orbweave, same work": lambda: own(options, scan, mesh, SAME_WORK)}
    for peer, words, target in peers(options, work, scan, radii):
        runs[peer] = lambda peer=peer, words=words, target=target: peer_row(options, peer, words, target)
    rows = [{**median_row(results), "program": peer, "scan": name}
            for peer, results in harness.alternate(runs, options.repeats).items()]
    for row in rows:
        row.pop("report", None)
        if "seconds" in row:
            row["ratio"] = row["seconds"] / rows[0]["seconds"]
    print(f"\n{name}, radii {', '.join(f'{radius:.4g}' for radius in radii)}\n{harness.table(rows, COLUMNS)}")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="directory of real scans")
    parser.add_argument("scans", nargs="*", help="autzen, bunny; both where none is named")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--limit", type=int, default=120, help="seconds that a peer may take")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows = [row for name in options.scans or ["autzen", "bunny"] for row in measure(options, work, name)]
    harness.write_results(options, "raw_peers", rows)


if __name__ == "__main__":
    main()
