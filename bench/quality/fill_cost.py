"""What the hole pass costs: by number and size of holes, and on a clean job."""
import json
import math
import pathlib
import statistics

import harness
import plots

POINTS = 2_000_000
NUMBERS = (0, 1, 10, 100, 1_000, 10_000)
RIM_EDGES = (10, 20, 50, 100, 200, 500, 1_000, 2_000)
SMALL_SPACINGS = 2.0  # radius of the holes that are counted
MOST_SHARE = 0.1
COLUMNS = ["series", "holes", "rim_edges", "filled", "points_added", "seconds", "hole_seconds"]


def surface(options, work, shape):
    cloud = harness.generated(options.program, work, shape, POINTS)
    mesh = work / f"fill-cost-{shape}.ply"
    return harness.made(mesh, [options.program, "reconstruct", cloud, "-o", mesh, "--no-fill", "--radii",
                               repr(1.3 * harness.spacing(shape, POINTS)), "--progress", "none"])


def measured(options, series, mesh, radius, count):
    words = [options.bench_fill, "--threads", 2, "cost", mesh, "--radius", f"{radius:g}", "--count", count,
             "--repeats", options.repeats]
    facts = json.loads(harness.run(words)["stdout"])
    whole, holes = harness.spread(facts["seconds"]), harness.spread(facts["hole_seconds"])
    return {**facts, "series": series, "seconds": whole["median"], "hole_seconds": holes["median"],
            "whole": whole, "of_holes": holes}


def by_number(options, work):
    mesh = surface(options, work, "torus")
    return [measured(options, "number", mesh, SMALL_SPACINGS, count) for count in NUMBERS]


def by_size(options, work):
    """One hole; a rim of n edges lies about n / 2 pi spacings around its centre, less on its zigzag."""
    mesh = surface(options, work, "sphere")
    return [measured(options, "size", mesh, edges / (2 * math.pi) / 1.1, 1) for edges in RIM_EDGES]


def clean_job(options, work):
    """The fill's share by the report's stages, and by the seconds of whole jobs with and without it."""
    cloud = harness.generated(options.program, work, "torus", options.points)
    radius = repr(1.3 * harness.spacing("torus", options.points))
    mesh = work / "fill-clean.ply"
    results = harness.alternate(
        {"with": lambda: harness.reconstruct(options.program, cloud, mesh, ["--radii", radius]),
         "without": lambda: harness.reconstruct(options.program, cloud, mesh, ["--radii", radius, "--no-fill"])},
        options.repeats)
    stages = [harness.stages(result["report"]) for result in results["with"]]
    seconds = {name: statistics.median(taken[name]["seconds"] for taken in stages) for name in stages[0]}
    wall = {name: harness.spread([result["wall_seconds"] for result in taken]) for name, taken in results.items()}
    return {"points": options.points, "stage_seconds": seconds, "wall_seconds": wall,
            "fill_seconds": seconds.get("holes", 0.0), "fill_share": seconds.get("holes", 0.0) / sum(seconds.values()),
            "wall_share": wall["with"]["median"] / wall["without"]["median"] - 1.0}


def draw(options, rows):
    out = pathlib.Path(options.out)
    number = [row for row in rows if row["series"] == "number" and row["holes"]]
    size = [row for row in rows if row["series"] == "size" and row["holes"]]
    plots.line_plot(out / "fill_cost_number.svg", "Filling small holes in a torus of 2M points", "holes", "seconds",
                    {"whole pass, in core": [(row["holes"], row["seconds"]) for row in number],
                     "its holes alone, summed": [(row["holes"], row["hole_seconds"]) for row in number]},
                    log_x=True, log_y=True)
    plots.line_plot(out / "fill_cost_size.svg", "Filling one hole in a sphere of 2M points", "edges of the rim", "seconds",
                    {"the hole": [(row["rim_edges"], row["hole_seconds"]) for row in size]}, log_x=True, log_y=True)


def run(options, work):
    rows = by_number(options, work) + by_size(options, work)
    print(harness.table(rows, COLUMNS))
    draw(options, rows)
    clean = clean_job(options, work)
    print(f"\nclean job of {clean['points']:,} points: the fill takes {clean['fill_seconds']:.2f} s, "
          f"{100 * clean['fill_share']:.1f}% of its stages; whole jobs take with it, noise included, "
          f"{100 * clean['wall_share']:.1f}% longer")
    harness.write_results(options, "fill_cost", rows, {"clean_job": clean})
    left_open = [row for row in rows if row["filled"] < row["holes"]]
    missed = [f"{row['holes'] - row['filled']} of {row['holes']} holes left open" for row in left_open]
    return missed + ([f"share {clean['fill_share']:.3f}"] if clean["fill_share"] >= MOST_SHARE else [])
