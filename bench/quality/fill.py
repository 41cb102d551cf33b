#!/usr/bin/env python3
"""The hole pass: how well it restores what was cut out, and what it costs.

  discs    delete and refill: 50 random discs each of 4, 8 and 16 spacings on the bunny, the dragon and
           the lion scan, beside CGAL's triangulate_refine_and_fair_hole on the same holes
  confidence  discs of up to 32 spacings: what patches are said to be worth, and what they were
  table6   table 6 of Abdel-Wahab et al. 2005: a hole of radius 0.025 in the back of the 8171-point bunny
  hybrid   section 4.4 of that paper: an incomplete bunny of 28,060 points, with and without the fill
  cost     seconds against number and size of holes; the fill's share of a clean job of 10M points

Needs bench_fill, which is built where CGAL is installed. The exit status is 1 when a target is missed: a
hole of `discs` stays open or its patch cuts the mesh, the RMS distance of a class is not below CGAL's, a mean height
error of `table6` exceeds 0.0008, a class of `confidence` is off by more than 0.2, `hybrid` leaves a hole, the share of `cost` reaches a tenth.

usage: bench/quality/fill.py DATA_DIR [discs|confidence|table6|hybrid|cost]...
"""
import argparse
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy", "matplotlib")

import fill_confidence  # noqa: E402
import fill_cost  # noqa: E402
import fill_discs  # noqa: E402
import fill_hybrid  # noqa: E402
import fill_table6  # noqa: E402
import harness  # noqa: E402

PARTS = {"discs": fill_discs.run, "confidence": fill_confidence.run, "table6": fill_table6.run, "hybrid": fill_hybrid.run,
         "cost": fill_cost.run}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="directory of real scans, with stanford/ and points_normals/")
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; none: all")
    parser.add_argument("--count", type=int, default=50, help="discs of each radius and model")
    parser.add_argument("--only", help="models of `discs` whose name contains this")
    parser.add_argument("--worst", type=int, default=0, metavar="N",
                        help="write meshes of the N holes of each class that fare worst beside CGAL's")
    parser.add_argument("--points", type=int, default=10_000_000, help="of the clean job of `cost`")
    parser.add_argument("--repeats", type=int, default=3, help="of the measurements of `cost`")
    parser.add_argument("--kernel", default="biharmonic", choices=["biharmonic", "triharmonic"])
    harness.add_common_options(parser)
    options = parser.parse_intermixed_args()
    unknown = [part for part in options.parts if part not in PARTS]
    if unknown:
        parser.error(f"no part {unknown[0]}; there are {', '.join(PARTS)}")
    work = harness.prepare(options)
    options.bench_fill = os.path.join(os.path.dirname(options.program), "bench_fill")
    if not os.access(options.bench_fill, os.X_OK):
        sys.exit(f"no program {options.bench_fill}: it is built where CGAL is installed (libcgal-dev)")
    missed = []
    for part in options.parts or PARTS:
        print(f"\n-- {part}", flush=True)
        missed += [f"{part}: {text}" for text in PARTS[part](options, work)]
    print("missed: " + "; ".join(missed) if missed else "all targets hold")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
