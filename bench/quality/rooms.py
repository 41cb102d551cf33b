#!/usr/bin/env python3
"""A furnished room seen from four tripods, and a house seen from the air, with the truth known: how much of each
surface is right, beside Open3D's ball pivoting and screened Poisson reconstruction.

Scans come from `orbweave generate room` and `house`, with noise of 0.2 spacings, mixed pixels, a person who walks
through two scans, and trees. This program runs the job files of configs/; Open3D gets the same points, with normals
turned towards the true places of the scanners. F-score: harmonic mean of the share of the mesh within two spacings
of the truth and of the share of the truth within two spacings of the mesh, by area (`orbweave compare`). Of Poisson's
mesh and its trimmed one the better counts. A peer that exceeds --peer-seconds or --peer-memory is stopped and has
no F-score. The last table has what patches that close their loops whole were said to be worth, and what they were.
Filled: area of patches without panes. A pane counts as closed flat where
the mesh is within two spacings of it, by the root mean square of points spread over the pane. The exit status is 1 where a
peer's F-score is higher, more than 3 % are filled, triangles cross, or fewer than 90 % of the panes up to 48 spacings
are closed flat, or a wider one is neither flat nor listed.

usage: bench/quality/rooms.py [--points N,...] [--seed N,...] [--only SCENE] [--no-peers]
"""
import argparse
import itertools
import json
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
import numpy as np  # noqa: E402
import patch_truth  # noqa: E402
from meshes import read_ply, write_cloud  # noqa: E402

NOISE = 0.2  # spacings
LIMIT = 48  # edge lengths: of fill.max_diameter = "auto"
TRIPODS = np.array([[1.2, 1.6, 1.5], [5.2, 1.2, 1.6], [4.4, 3.7, 1.55], [2.6, 4.4, 1.5]])
CONFIGS = {"room": "configs/terrestrial-scan.toml", "house": "configs/airborne-lidar.toml"}
POISSON_DEPTH = 10
PEER_CORES = {"bpa": 1, "poisson": os.cpu_count()}  # that a method makes use of
COLUMNS = ["scene", "seed", "points", "program", "wall_seconds", "cpu_seconds", "precision", "recall", "f_score", "mean_spacings",
           "opposite", "components", "crossing_pairs", "filled", "panes", "panes_flat", "doubtful", "peak_gib", "stopped"]
PANE_COLUMNS = ["scene", "seed", "points", "pane", "width_spacings", "closed", "reason", "rms_spacings", "confidence",
                "verdict"]


def positions_of(vertex):
    return np.stack([np.asarray(vertex[axis], float) for axis in "xyz"], 1)


class Scene:
    def __init__(self, options, work, name, points, seed):
        self.name, self.points, self.seed, self.work = name, points, seed, work
        self.stem = f"{name}-{points}-seed{seed}"
        self.truth = work / f"{self.stem}-truth.ply"
        merged = work / f"{self.stem}.ply"
        self.program = options.program
        words = [options.program, "generate", name, "--points", points, "--noise", NOISE, "--seed", seed]
        harness.made(merged, words + ["-o", merged, "--truth", self.truth])
        self.scans = [merged]
        self.settings = []
        if name == "room":
            harness.made(work / f"{self.stem}.toml", words + ["--separate", "-o", merged])
            job = (work / f"{self.stem}.toml").read_text(encoding="utf-8")
            poses = job.split("pose = ")[1].split("]")[0] + "]"
            self.scans = [work / f"{self.stem}_{scan}.ply" for scan in range(4)]
            self.settings = ["input.pose=" + poses.replace("\n", " ")]
        truth = read_ply(self.truth)
        corners = positions_of(truth["vertex"]).reshape(-1, 3, 3)
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        self.area = areas.sum()
        self.spacing = float(np.sqrt(self.area / points))
        pane = np.asarray(truth["vertex"]["pane"])[::3]
        self.panes = {number: corners[pane == number].reshape(-1, 3) for number in range(1, pane.max() + 1)}
        self.merged = merged

    def cloud_for_peers(self):
        """The points in world coordinates with directions to their scanners."""
        path = self.work / f"{self.stem}-peer.ply"
        vertex = read_ply(self.merged)["vertex"]
        xyz = positions_of(vertex)
        if self.name == "room":
            direction = TRIPODS[np.asarray(vertex["scan"])] - xyz
        else:
            direction = np.tile([0.0, 0.0, 1.0], (len(xyz), 1))
        columns = np.zeros(len(xyz), [(name, "<f8") for name in ("x", "y", "z", "sx", "sy", "sz")])
        for axis, name in enumerate("xyz"):
            columns[name] = xyz[:, axis]
            columns["s" + name] = direction[:, axis]
        write_cloud(path, columns)
        return path

    def pane_error(self, number, mesh):
        """Root mean square distance of points spread over a pane to the mesh, spacings."""
        corners = self.panes[number]
        pane = self.work / "pane.obj"
        pane.write_text("".join("v %r %r %r\n" % tuple(map(float, corner)) for corner in corners) +
                        "".join(f"f {k} {k + 1} {k + 2}\n" for k in range(1, len(corners), 3)), encoding="utf-8")
        words = [self.program, "compare", pane, mesh, "--samples", 2000, "--json"]
        return json.loads(harness.run(words)["stdout"])["by_area"]["a_to_b"]["rms"] / self.spacing

    def judged(self, mesh):
        """Precision, recall, F-score, mean distance in spacings, share of opposite normals."""
        words = [self.program, "compare", mesh, self.truth, "--within", repr(2 * self.spacing), "--json"]
        found = json.loads(harness.run(words)["stdout"])["by_area"]
        within = found["within"][0]
        return {"precision": within["precision"], "recall": within["recall"], "f_score": within["f_score"],
                "mean_spacings": found["a_to_b"]["mean"] / self.spacing, "opposite": found["opposite_normals"]}


def pane_row(scene, number, report, mesh):
    corners = scene.panes[number]
    low, high = corners.min(axis=0), corners.max(axis=0)
    across = int(np.argmin(high - low))
    sides = np.delete(high - low, across)
    width = 2 * sides.prod() / sides.sum() / scene.spacing
    rms = scene.pane_error(number, mesh)
    row = {"scene": scene.name, "seed": scene.seed, "points": scene.points, "pane": f"{number}: {sides[0]:.2g} x {sides[1]:.2g}",
           "width_spacings": round(float(width), 1), "rms_spacings": rms, "area": float(sides.prod())}
    near = [hole for hole in report["holes"]
            if np.linalg.norm(np.array(hole["center"]) - (low + high) / 2) < 0.5 * sides.min()]
    hole = max(near, key=lambda hole: hole["diameter"], default=None)
    if hole is not None:
        row.update(closed=hole["filled"], reason=hole["reason"], confidence=hole["confidence"])
    is_flat = rms <= 2.0
    is_listed = hole is not None and not hole["filled"]
    return {**row, "flat": is_flat, "verdict": "ok" if is_flat or (is_listed and width > 0.85 * LIMIT) else "missed"}


def ours(scene, options):
    mesh = scene.work / f"{scene.stem}-mesh.ply"
    result = harness.run_job(options.program, harness.ROOT / CONFIGS[scene.name], scene.scans, mesh, scene.settings)
    report = result["report"]
    facts = report["mesh"]
    panes = [pane_row(scene, number, report, mesh) for number in scene.panes] if scene.name == "room" else []
    filled = (facts["patch_area"] - sum(row["area"] for row in panes if row.get("closed"))) / facts["area"]
    within = [row for row in panes if row["width_spacings"] <= LIMIT]
    patches = patch_truth.patch_rows(scene.program, scene.work, mesh, report, scene.truth, scene.spacing)
    return panes, patches, {"scene": scene.name, "seed": scene.seed, "points": report["input"]["points_read"], "program": "orbweave",
                   "wall_seconds": result["wall_seconds"],
                   "cpu_seconds": result["user_seconds"] + result["system_seconds"],
                   "peak_gib": result["peak_memory_bytes"] / 2**30, **scene.judged(mesh), "components": facts["components"],
                   "crossing_pairs": facts["patch_crossing_pairs"], "filled": filled,
                   "panes": len(within), "panes_flat": sum(row["flat"] for row in within),
                   "doubtful": sum(hole.get("confidence", 1.0) < 0.5 for hole in report["holes"] if hole["filled"]),
                   "radii": report["radii"]["values"]}


def peers(scene, radii, options):
    cloud = scene.cloud_for_peers()
    rows = []
    for method, words in (("bpa", ["--radii", ",".join(map(repr, radii))]),
                          ("poisson", ["--depth", POISSON_DEPTH, "--trimmed", scene.work / "peer-trimmed.ply"])):
        mesh = scene.work / "peer.ply"
        command = [harness.peer_python(), harness.PEERS / "open3d_scans.py", cloud, "--method", method, "--mesh", mesh,
                   *words]
        result = harness.run_within(command, PEER_CORES[method] * options.peer_seconds, options.peer_memory * 2**30)
        row = {"scene": scene.name, "seed": scene.seed, "points": scene.points, "wall_seconds": result["wall_seconds"],
               "cpu_seconds": result["cpu_seconds"], "peak_gib": result["peak_memory_bytes"] / 2**30}
        if "stopped" in result:
            rows.append({**row, "program": f"Open3D {method}", "stopped": result["stopped"]})
            continue
        facts = json.loads(result["stdout"].splitlines()[-1])
        for name, path in ((method, mesh), (method + " trimmed", scene.work / "peer-trimmed.ply")):
            if name != "bpa trimmed":
                rows.append({**row, "points": facts["points"], "program": f"Open3D {name}",
                             "wall_seconds": facts["seconds"], **scene.judged(path)})
    return rows


def misses(scene, row, panes, others):
    if any(other.get("f_score", 0.0) >= row["f_score"] for other in others):
        yield "F-score"
    if row["filled"] > 0.03:
        yield f"filled {100 * row['filled']:.1f} %"
    if row["crossing_pairs"]:
        yield "crossings"
    if panes and row["panes_flat"] < 0.9 * row["panes"]:
        yield "panes"
    if any(pane["verdict"] != "ok" for pane in panes if pane["width_spacings"] > LIMIT):
        yield "wide panes"


def numbers(text):
    return [int(number) for number in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", default="1000000", help="N,...: sizes of the clouds (1000000)")
    parser.add_argument("--seed", default="1", help="N,...: seeds of the scenes (1)")
    parser.add_argument("--only", choices=sorted(CONFIGS), help="one of the two scenes")
    parser.add_argument("--no-peers", action="store_true", help="this program alone")
    parser.add_argument("--peer-seconds", type=float, default=600.0, help="a peer that takes more, of each core that it uses, is stopped (600)")
    parser.add_argument("--peer-memory", type=float, default=10.0, help="GiB: a peer that takes more is stopped (10)")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows, pane_rows, all_patches, missed = [], [], [], []
    for name in [options.only] if options.only else sorted(CONFIGS, reverse=True):
        for seed, points in itertools.product(numbers(options.seed), numbers(options.points)):
            scene = Scene(options, work, name, points, seed)
            panes, patches, row = ours(scene, options)
            all_patches += patches
            others = [] if options.no_peers else peers(scene, row["radii"], options)
            rows += [row, *others]
            pane_rows += panes
            missed += [f"{name} {points}, seed {seed}: {what}" for what in misses(scene, row, panes, others)]
            print(f"{name}, {points}, seed {seed}: F-score {row['f_score']:.4f}", flush=True)
            for other in others:
                print(f"  {other['program']}: {other.get('stopped') or round(other['f_score'], 4)}", flush=True)
    print("\n" + harness.table(rows, COLUMNS))
    if pane_rows:
        print("\n" + harness.table(pane_rows, PANE_COLUMNS))
    whole = [patch for patch in all_patches if patch["open_edges"] == 0]
    confidence = list(patch_truth.class_rows("all", whole))
    print("\n" + harness.table(confidence, patch_truth.COLUMNS))
    harness.write_results(options, "rooms", rows, {"panes": pane_rows, "confidence": confidence})
    print("missed: " + "; ".join(missed) if missed else "all targets hold")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
