#!/usr/bin/env python3
"""Real scans side by side: what a scan costs per point where it is one of many, in little memory.

A LAS scan is laid out as tiles of a square, every other one mirrored so that borders meet: as many times the points, in
many chunks. Columns: tiles, points, chunks, wall seconds, CPU microseconds per point, the stage that grew most over the
single scan and its growth per point, peak memory. The exit status is 1 where the tiles take more than twice the
CPU time per point of the single scan, a stage of a tenth of the job or more takes more than three times, or a job holds
more than its budget.

usage: bench/workloads/mosaics.py DATA_DIR [--side 3] [--only NAME] [--memory 512MiB]
"""
import argparse
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy")

import harness  # noqa: E402
import numpy  # noqa: E402
from whole_jobs import parse_bytes  # noqa: E402

SCANS = {"autzen": ("airborne-lidar", "lidar/autzen_stadium_tile_las12_pf2.las"),
         "lone-star": ("terrestrial-scan", "lidar/lone-star_las11_pf1.las"),
         "pueblito": ("terrain", "photogrammetry/pueblito_las14_pf7.las")}
MOST_GROWTH, MOST_STAGE_GROWTH, LARGE = 2.0, 3.0, 0.1
COLUMNS = ["scan", "tiles", "points", "chunks", "seconds", "us_per_point", "slowest", "slowest_growth", "peak_mib"]


def lay_out(scan, tiles, side):
    """Writes side x side tiles of a LAS file: its header with other counts and bounds, its records moved."""
    data = scan.read_bytes()
    begin, = struct.unpack_from("<I", data, 96)
    length, = struct.unpack_from("<H", data, 105)
    count, = struct.unpack_from("<I", data, 107)
    if count == 0:
        count, = struct.unpack_from("<Q", data, 247)
    records = numpy.frombuffer(data, numpy.uint8, count * length, begin).reshape(count, length)
    places = numpy.ascontiguousarray(records[:, :8]).view("<i4").astype(numpy.int64)
    low, high = places.min(axis=0), places.max(axis=0)
    header = bytearray(data[:begin])
    struct.pack_into("<I", header, 107, count * side * side)
    if data[25] >= 4:
        struct.pack_into("<Q", header, 247, count * side * side)
    scale, offset = numpy.array(struct.unpack_from("<2d", data, 131)), numpy.array(struct.unpack_from("<2d", data, 155))
    bounds = numpy.stack([low + side * (high - low), low], axis=1) * scale[:, None] + offset[:, None]
    struct.pack_into("<4d", header, 179, *bounds.ravel())
    with open(tiles, "wb") as file:
        file.write(header)
        for i in range(side):
            for k in range(side):
                turned = [low[axis] + high[axis] - places[:, axis] if number % 2 else places[:, axis]
                          for axis, number in ((0, i), (1, k))]
                moved = numpy.stack(turned, axis=1) + (high - low) * (i, k)
                tile = records.copy()
                tile[:, :8] = moved.astype("<i4").view(numpy.uint8)
                file.write(tile.tobytes())
    return count * side * side


def run(options, config, cloud, mesh):
    settings = [f'partition.memory="{options.memory}"', 'output.picture=""']
    result = harness.run_job(options.program, harness.ROOT / f"configs/{config}.toml", [cloud], mesh, settings)
    mesh.unlink()
    return result


def row_of(scan, tiles, points, result, single):
    stages = harness.stages(result["report"])
    costs = {name: 1e6 * stage["cpu_seconds"] / points for name, stage in stages.items()}
    total = sum(costs.values())
    row = {"scan": scan, "tiles": tiles, "points": points, "chunks": result["report"]["partition"]["chunks"],
           "seconds": sum(stage["seconds"] for stage in stages.values()), "us_per_point": total, "costs": costs,
           "peak_mib": result["peak_memory_bytes"] / 2**20}
    if single:
        large = [name for name in costs if costs[name] >= LARGE * total and single["costs"].get(name, 0) > 0]
        growth = {name: costs[name] / single["costs"][name] for name in large}
        row["slowest"] = max(growth, key=growth.get)
        row["slowest_growth"] = growth[row["slowest"]]
    return row


def misses_of(single, tiles, most_mib):
    growth = tiles["us_per_point"] / single["us_per_point"]
    if growth > MOST_GROWTH:
        yield f"{tiles['scan']}: {growth:.1f} times the CPU time per point of the single scan"
    if tiles["slowest_growth"] > MOST_STAGE_GROWTH:
        yield f"{tiles['scan']}: {tiles['slowest']} takes {tiles['slowest_growth']:.1f} times as much per point"
    for row in (single, tiles):
        if row["peak_mib"] > most_mib:
            yield f"{row['scan']}, {row['tiles']} tiles: {row['peak_mib']:.0f} MiB held, {most_mib:.0f} allowed"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path)
    harness.add_common_options(parser)
    parser.add_argument("--side", type=int, default=3)
    parser.add_argument("--only", choices=SCANS)
    parser.add_argument("--memory", default="512MiB")
    options = parser.parse_args()
    work = harness.prepare(options)
    most_mib = parse_bytes(options.memory) / 2**20
    rows, missed = [], []
    for name, (config, file) in SCANS.items():
        if options.only not in (None, name):
            continue
        cloud = work / f"{name}-tiles.las"
        points = lay_out(options.data / file, cloud, options.side)
        tiles = options.side**2
        single = row_of(name, 1, points // tiles, run(options, config, options.data / file, work / "tiles.ply"), None)
        many = row_of(name, tiles, points, run(options, config, cloud, work / "tiles.ply"), single)
        cloud.unlink()
        missed += misses_of(single, many, most_mib)
        rows += [single, many]
        print(harness.table(rows[-2:], COLUMNS), flush=True)
    harness.write_results(options, "mosaics", rows)
    return harness.exit_status(missed)


if __name__ == "__main__":
    sys.exit(main())
