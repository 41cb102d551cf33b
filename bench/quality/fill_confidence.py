"""Confidence of patches against what became of them: discs of up to 32 spacings, as in `discs`."""
import statistics

import fill_discs
import harness

RADII = (4, 8, 12, 16, 20, 24, 28, 32)
NEAR = 2.0  # spacings: what the confidence is the chance of
CLASSES = ((0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 0.9), (0.9, 1.01))
COLUMNS = ["confidence", "holes", "mean_confidence", "near", "median_rms", "models"]


def class_rows(holes):
    for low, high in CLASSES:
        members = [h for h in holes if low <= h["engine"]["confidence"] < high]
        if not members:
            continue
        models = sorted({h["model"] for h in members})
        yield {"confidence": f"{low:.2f} .. {min(high, 1.0):.2f}", "holes": len(members),
               "mean_confidence": statistics.fmean(h["engine"]["confidence"] for h in members),
               "near": statistics.fmean(h["engine"]["rms"] <= NEAR for h in members),
               "median_rms": statistics.median(h["engine"]["rms"] for h in members), "models": " ".join(models)}


def misses(rows):
    for row in rows:
        if row["holes"] >= 20 and abs(row["near"] - row["mean_confidence"]) > 0.2:
            yield (f"{row['confidence']}: {row['near']:.2f} near where {row['mean_confidence']:.2f} was told")


def run(options, work):
    holes = []
    for name, path, radii in fill_discs.MODELS:
        if options.only and options.only not in name:
            continue
        mesh = fill_discs.model_mesh(options, work, name, path, radii)
        for radius in RADII if mesh else ():
            found = fill_discs.refilled(options, mesh, radius, "--count", options.count)
            holes += [{"model": name, **hole} for hole in found if hole["engine"]["triangles"]]
    rows = list(class_rows(holes))
    print(harness.table(rows, COLUMNS))
    print(f"\nnear: share of the patches whose root mean squared distance is at most {NEAR} spacings")
    harness.write_results(options, "fill_confidence", rows, {"holes": holes})
    return list(misses(rows))
