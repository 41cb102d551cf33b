#!/usr/bin/env python3
"""Noise that grows with the distance: a room as a phase scanner on four tripods sees it, and as five frames of a depth
camera, with the truth known; with cleaning and without, beside another build of the program.

Scans come from `orbweave generate room` and `frames` with --noise-growth 2 and no mixed pixels or walkers, and the
program runs configs/terrestrial-scan.toml with the scanners' places. Distances are of the area of the scanned
surface, without patches, to the truth, in mean spacings; precision is the share of the area within two. Loops are
boundary loops before the fill, open edges those after it.

usage: bench/quality/noise_growth.py [--points N] [--before PROGRAM] [--only SCENE]
"""
import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
import numpy as np  # noqa: E402
from meshes import read_ply  # noqa: E402

CONFIG = "configs/terrestrial-scan.toml"
# Scene: number of scans, noise in mean spacings at the mean distance.
SCENES = {"room": (4, 0.5), "frames": (5, 1.0)}
COLUMNS = ["scene", "points", "program", "cleaning", "cpu_seconds", "vertices", "components", "loops", "open_edges",
           "mean_spacings", "rms_spacings", "p95_spacings", "precision", "recall", "untouched"]


class Scene:
    def __init__(self, options, work, name):
        self.name, self.program = name, options.program
        scans, noise = SCENES[name]
        stem = work / f"growth-{name}-{options.points}"
        merged, job = pathlib.Path(f"{stem}.ply"), pathlib.Path(f"{stem}.toml")
        self.truth = pathlib.Path(f"{stem}-truth.ply")
        harness.made(job, [options.program, "generate", name, "--points", options.points, "--noise", noise,
                           "--noise-growth", 2, "--undisturbed", "--separate", "-o", merged, "--truth", self.truth])
        poses = job.read_text(encoding="utf-8").split("pose = ")[1].split("]")[0] + "]"
        self.scans = [pathlib.Path(f"{stem}_{scan}.ply") for scan in range(scans)]
        self.settings = ["input.pose=" + poses.replace("\n", " ")]
        vertex = read_ply(self.truth)["vertex"]
        corners = np.stack([np.asarray(vertex[axis], float) for axis in "xyz"], 1).reshape(-1, 3, 3)
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        self.spacing = float(np.sqrt(areas.sum() / options.points))

    def judged(self, mesh):
        words = [self.program, "compare", mesh, self.truth, "--within", repr(2 * self.spacing), "--json"]
        found = json.loads(harness.run(words)["stdout"])["by_area"]
        distances, within = found["a_to_b"], found["within"][0]
        return {"mean_spacings": distances["mean"] / self.spacing, "rms_spacings": distances["rms"] / self.spacing,
                "p95_spacings": distances["percentile_95"] / self.spacing, "precision": within["precision"],
                "recall": within["recall"]}


def row_of(scene, work, program, name, cleaned):
    mesh = work / "growth-mesh.ply"
    settings = scene.settings + ["cleaning.auto=" + ("true" if cleaned else "false")]
    result = harness.run_job(program, harness.ROOT / CONFIG, scene.scans, mesh, settings)
    report = result["report"]
    # Patches of doorways and of what no scan saw say nothing of the cleaning.
    harness.run_job(program, harness.ROOT / CONFIG, scene.scans, mesh, settings + ["fill.enabled=false"])
    facts = report["mesh"]
    return {"scene": scene.name, "points": report["input"]["points_read"], "program": name,
            "cleaning": "auto" if cleaned else "none", "cpu_seconds": result["user_seconds"] + result["system_seconds"],
            "vertices": facts["vertices"], "components": facts["components"], "loops": len(report["holes"]),
            "open_edges": facts["boundary_edges"], **scene.judged(mesh),
            "untouched": report["cleaning"].get("untouched_share", 0.0)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=500000, help="of each scene, about (500000)")
    parser.add_argument("--before", help="another build of the program, to compare with")
    parser.add_argument("--only", choices=sorted(SCENES), help="one of the two scenes")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    programs = ([("before", options.before)] if options.before else []) + [("orbweave", options.program)]
    rows = []
    for name in [options.only] if options.only else sorted(SCENES, reverse=True):
        scene = Scene(options, work, name)
        rows.append(row_of(scene, work, options.program, "orbweave", False))
        rows += [row_of(scene, work, program, label, True) for label, program in programs]
    print(harness.table(rows, COLUMNS))
    harness.write_results(options, "noise_growth", rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
