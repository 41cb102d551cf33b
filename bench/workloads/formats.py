#!/usr/bin/env python3
"""Every sample file: read with the right number of points and bounds, or refused with a message.

What is right is decoded here, apart from the program (expected_clouds.py); of compressed LAS the header's word counts.
What that decoder cannot make sense of has to be refused; a file below samples/corrupt/ may be. LAZ files are
compared with their LAS twins, every coordinate, and so are the files that hold one cloud in several formats. Then the
speed of reading. The exit status is 1 when a file is read or refused wrongly, or twins differ.

usage: bench/workloads/formats.py DATA_DIR
"""
import argparse
import json
import os
import pathlib
import statistics
import struct
import subprocess
import sys
from xml.etree import ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import numpy as np  # noqa: E402
import harness  # noqa: E402
import expected_clouds  # noqa: E402

# Files of the same cloud below DATA_DIR, and what has to be the same: all values in order, positions in order, or the
# positions in any order.
TWINS = [("samples/laz/lone-star.laz", "lidar/lone-star_las11_pf1.las", "values"),
         ("samples/laz/pine_plot.laz", "lidar/pine_plot_tls_las12_pf0.las", "values"),
         ("samples/laz/1_4_w_evlr.laz", "samples/las/1_4_w_evlr.las", "values"),
         ("samples/laz/simple.laz", "samples/las/1.2-with-color.las", "values"),
         ("samples/laz/extra.laz", "samples/las/extrabytes.las", "values"),
         ("samples/laz/autzen_trim.laz", "samples/las/autzen_trim_7.las", "positions"),
         ("samples/laz/simple.copc.laz", "samples/las/1.2-with-color.las", "set"),
         ("samples/ascii/ripple.txt", "samples/ascii/ripple.pts", "positions"),
         ("samples/ply/ripple_bin.ply", "samples/ply/ripple_ascii.ply", "positions")]
SAME = {"values": ["digest", "digest_of_attributes"], "positions": ["digest"], "set": ["digest_of_set"]}
FAST = ["samples/laz/lone-star.laz", "lidar/lone-star_las11_pf1.las", "samples/laz/pine_plot.laz",
        "lidar/pine_plot_tls_las12_pf0.las", "samples/laz/autzen_trim.laz", "samples/las/autzen_trim_7.las",
        "lidar/autzen_stadium_tile_las12_pf2.las", "photogrammetry/pueblito_las14_pf7.las",
        "samples/e57/bunnyDouble.e57", "samples/e57/bunnyInt32.e57", "samples/pcd/Zaghetto.pcd",
        "samples/ascii/ripple.ptx", "samples/ascii/ripple.pts"]


def inspected(program, path):
    """(exit status, facts or None, message)"""
    done = subprocess.run([program, "inspect", path, "--json"], capture_output=True, text=True, check=False)
    message = (done.stderr.strip().splitlines() or [""])[-1].replace("orbweave: error: ", "").replace(f"{path}: ", "")
    return done.returncode, json.loads(done.stdout) if done.returncode == 0 else None, message


def wrong(found, wanted):
    """What a cloud that was read differs in, as words; empty where it is right."""
    points = found.get("points", found.get("vertices"))
    if points != wanted["points"]:
        return f"{points:,} points, not {wanted['points']:,}"
    if wanted["box"] is None or points == 0:
        return ""
    rounding = wanted.get("rounding", 1e-15) * np.abs(wanted["box"]).max()
    for name, corner, outward in zip(("min", "max"), wanted["box"], (-1, 1)):
        off = np.array(found["bounds"][name]) - corner
        if (off * outward > wanted["within"]).any() if "within" in wanted else (np.abs(off) > rounding).any():
            return f"bounds {name} {found['bounds'][name]}, not {corner.tolist()}"
    return ""


def wanted_of(options, path):
    """What the file holds, as decoded here; None where that cannot be known."""
    try:
        wanted = expected_clouds.expected(path)
    except (ValueError, LookupError, AttributeError, struct.error, ElementTree.ParseError):
        return None
    if path.suffix == ".laz" and wanted["points"] > 0:
        left_out = sum(digests(options, [path])[path].get("left_out", {}).values())
        wanted["points"] -= left_out
        wanted["note"] += f", {left_out} of them withheld" if left_out else ""
    return wanted


def row_of(options, path):
    name = str(path.relative_to(options.data))
    status, found, message = inspected(options.program, path)
    wanted = wanted_of(options, path)
    row = {"file": name, "status": status, "message": message, "points": "", "expected": "", "verdict": "right"}
    may_refuse = wanted is None or "corrupt" in path.parts
    if found is None:
        row["verdict"] = "refused" if may_refuse and status == 3 and message else "WRONG: " + message
        return row
    if wanted is None:
        row["verdict"] = "WRONG: not refused"
        return row
    row["points"] = found.get("points", found.get("vertices"))
    row["expected"], row["note"] = wanted["points"], wanted["note"]
    if differs := wrong(found, wanted):
        row["verdict"] = "WRONG: " + differs
    return row


def digests(options, paths):
    """{path: facts} of bench_formats."""
    words = [options.bench_formats, *(options.data / path for path in paths)]
    lines = harness.run(words)["stdout"].splitlines()
    return {path: json.loads(line) for path, line in zip(paths, lines)}


def twin_rows(options):
    present = [twins for twins in TWINS if all((options.data / path).exists() for path in twins[:2])]
    found = digests(options, sorted({path for twins in present for path in twins[:2]}))
    for one, other, what in present:
        same = all(found[one].get(key) == found[other].get(key) is not None for key in SAME[what])
        yield {"one": one, "other": other, "points": found[one].get("points", 0), "compared": what,
               "verdict": "same" if same else "WRONG: " + (found[one].get("refused") or "they differ")}


def speed_rows(options):
    paths = [path for path in FAST if (options.data / path).exists()]
    runs = [digests(options, paths) for _ in range(options.repeats)]
    for path in paths:
        facts = [run[path] for run in runs]
        if "refused" in facts[0]:
            continue
        seconds = statistics.median(fact["seconds"] for fact in facts)
        size = (options.data / path).stat().st_size
        yield {"file": path, "points": facts[0]["points"], "mib": size / (1 << 20), "seconds": seconds,
               "points_per_second": facts[0]["points"] / seconds, "mib_per_second": size / (1 << 20) / seconds}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path, help="directory with samples/, lidar/, photogrammetry/")
    parser.add_argument("--repeats", type=int, default=5, help="of the measurements of speed")
    harness.add_common_options(parser)
    options = parser.parse_args()
    harness.prepare(options)
    options.bench_formats = os.path.join(os.path.dirname(options.program), "bench_formats")
    rows = [row_of(options, path) for path in sorted((options.data / "samples").rglob("*")) if path.is_file()]
    print(harness.table(rows, ["file", "points", "expected", "verdict", "note"]))
    print("\nrefused:\n" + "\n".join(f"  {row['file']}: {row['message']}" for row in rows if row["message"]))
    twins, speeds = list(twin_rows(options)), list(speed_rows(options))
    print("\n" + harness.table(twins, ["one", "other", "points", "compared", "verdict"]))
    print("\n" + harness.table(speeds, ["file", "points", "mib", "seconds", "points_per_second", "mib_per_second"]))
    harness.write_results(options, "formats", rows, {"twins": twins, "speed": speeds})
    missed = [row for row in rows + twins if row["verdict"].startswith("WRONG")]
    print(f"{len(missed)} of {len(rows) + len(twins)} are wrong" if missed else "all are right")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
