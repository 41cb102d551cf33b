#!/usr/bin/env python3
"""The comparative study of the base paper with today's numbers: all methods on all its models, time of the method,
peak memory and mesh size, regressions, plots, pictures, and the accuracy of the hole fill, each beside the paper's
figures. Writes docs/study.md with its plots and pictures in docs/images/study, and build/bench/study.json.

usage: bench/study/study.py DATA_DIRECTORY [--repeats N] [--again]

DATA_DIRECTORY/stanford holds the models; those that are absent are left out, and the page says so. Needs bench_study
and bench_fill (built where CGAL is installed) and Debian's python3-matplotlib."""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "bench"))
import interpreter  # noqa: E402

interpreter.need("matplotlib")
import plots  # noqa: E402

BIN = ROOT / "build" / "release" / "bin"
PROGRAM = BIN / "bench_study"
PAGE = ROOT / "docs" / "study.md"
IMAGES = ROOT / "docs" / "images" / "study"
METHODS = ["ball_pivoting", "cocone", "tight_cocone", "crust", "power_crust"]
NAMES = {"ball_pivoting": "ball pivoting", "cocone": "Cocone", "tight_cocone": "Tight Cocone", "crust": "Crust",
         "power_crust": "Power Crust"}
# Model, points in the paper, ball radius of its table 1.
MODELS = [("bun_zipper_res4.ply", 453, 0.012), ("bun_zipper_res3.ply", 1889, 0.0055),
          ("bun_zipper_res2.ply", 8171, 0.0028), ("bun_zipper.ply", 35947, 0.0015),
          ("dragon_vrip_res4.ply", 5205, 0.0035), ("dragon_vrip_res3.ply", 22998, 0.002),
          ("dragon_vrip_res2.ply", 100250, 0.0011), ("happy_vrip_res4.ply", 7108, 0.0024),
          ("happy_vrip_res3.ply", 32328, 0.0015), ("happy_vrip_res2.ply", 144647, 0.0007)]
# The paper's regressions over the number of points: slope, intercept.
PAPER_SECONDS = {"crust": (0.0055445, -21.204), "power_crust": (0.0043864, -25.643),
                 "tight_cocone": (0.0022699, -10.568), "ball_pivoting": (0.0007672, -3.221)}
PAPER_MEGABYTES = {"crust": (0.002643, 0.3888), "power_crust": (0.0049222, -0.6787),
                   "tight_cocone": (0.0018191, 0.1775), "ball_pivoting": (0.0006766, 0.3166)}
PAPER_TRIANGLES = {"crust": (2.8467, 2296.0), "tight_cocone": (1.9653, 473.1), "ball_pivoting": (1.9322, 685.2)}
# The paper's table 5: vertices and polygons of Power Crust.
PAPER_POWER = {1889: (17272, 12085), 5205: (50872, 35738), 7108: (65100, 44927), 8171: (79840, 56195),
               22998: (235724, 166179), 35947: (354655, 247621), 100250: (1081151, 772715),
               144647: (1526626, 1084386)}
# What no method can do without, and the ratio that is asked for.
NEEDS = {"cocone": (["points"], 1.5), "tight_cocone": (["points"], 1.7), "crust": (["points", "points_and_poles"], 1.3),
         "power_crust": (["bounded_points", "balls"], 1.3)}
NOISE_VARIANCE = 1e-6


def run(*words):
    command = [str(word) for word in words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"exit status {done.returncode} from: {' '.join(command)}\n{done.stderr}")
    return done.stdout


def measure(method, model, *options):
    return json.loads(run(PROGRAM, method, model, *options))


def regression(pairs):
    """Slope, intercept and R^2 of the least squares line."""
    xs, ys = zip(*pairs)
    mean_x, mean_y = statistics.fmean(xs), statistics.fmean(ys)
    spread = sum((x - mean_x) ** 2 for x in xs)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in pairs) / spread
    intercept = mean_y - slope * mean_x
    total = sum((y - mean_y) ** 2 for y in ys)
    rest = sum((y - slope * x - intercept) ** 2 for x, y in pairs)
    return slope, intercept, 1.0 - rest / total if total > 0 else 1.0


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]) + "\n"


def measure_model(model, radius, repeats):
    results = {"empty": measure("none", model)["peak_memory_bytes"]}
    results["triangulations"] = {}
    for method in METHODS:
        options = ["--repeats", repeats] + (["--radius", radius] if method == "ball_pivoting" else [])
        line = measure(method, model, *options)
        once = measure(method, model, *options[2:])
        results[method] = {"seconds": statistics.median(line["seconds"]), "samples": line["seconds"],
                           "peak_memory_bytes": once["peak_memory_bytes"], "mesh": line["mesh"]}
    samples = measure("triangulations", model, "--repeats", repeats)["seconds"]
    for name in samples[0]:
        results["triangulations"][name] = statistics.median(sample[name] for sample in samples)
    return results


def ratio(result, method):
    return result[method]["seconds"] / sum(result["triangulations"][name] for name in NEEDS[method][0])


def regression_rows(results, value, paper, digits):
    rows = []
    for method in METHODS:
        slope, intercept, square = regression([(n, value(r, method)) for n, r in results.items()])
        theirs = paper.get(method)
        rows.append([NAMES[method], f"{slope:.{digits}g}", f"{intercept:.3g}", f"{square:.4f}",
                     f"{theirs[0]:.{digits}g}, {theirs[1]:g}" if theirs else "-"])
    return rows


def seconds(result, method):
    return result[method]["seconds"]


def megabytes(result, method):
    return (result[method]["peak_memory_bytes"] - result["empty"]) / 1e6


def triangles(result, method):
    return result[method]["mesh"]["triangles"]


def draw(results):
    IMAGES.mkdir(parents=True, exist_ok=True)
    for name, title, unit, value in (("time", "Time of the method, one thread", "CPU seconds", seconds),
                                     ("memory", "Peak memory beyond the loaded points", "MB", megabytes),
                                     ("size", "Mesh size", "triangles", triangles)):
        series = {NAMES[m]: [(n, max(value(r, m), 1e-4)) for n, r in results.items()] for m in METHODS}
        plots.line_plot(IMAGES / f"{name}.svg", title, "points", unit, series, log_x=True, log_y=True)


def size_rows(results):
    rows = []
    for n, result in sorted(results.items()):
        mesh = result["power_crust"]["mesh"]
        theirs = PAPER_POWER.get(n)
        if not theirs:
            continue
        rows.append([n, mesh["vertices"], theirs[0], f"{100 * mesh['vertices'] / theirs[0] - 100:+.1f}%", mesh["polygons"],
                     theirs[1], f"{100 * mesh['polygons'] / theirs[1] - 100:+.1f}%"])
    return rows


def noise_meshes(directory):
    """Rows of the table of section 4.3, and the pictures of figures 6 and 7."""
    rows = []
    model = directory / "bun_zipper_res3.ply"
    for variance, name in ((0, "meshes.png"), (NOISE_VARIANCE, "noise.png")):
        pictures = []
        with tempfile.TemporaryDirectory() as folder:
            for method in METHODS:
                options = ["--radius", 0.0055] if method == "ball_pivoting" else []
                mesh, picture = pathlib.Path(folder) / f"{method}.obj", pathlib.Path(folder) / f"{method}.png"
                facts = measure(method, model, *options, "--noise", variance, "--mesh", mesh)["mesh"]
                rows.append([NAMES[method], f"{variance:g}", facts["triangles"], facts["boundary_loops"],
                             facts["boundary_edges"], facts["nonmanifold_edges"]])
                run(BIN / "orbweave", "inspect", mesh, "--picture", picture, "--picture-up", "y")
                pictures.append((NAMES[method], picture))
            plots.picture_row(IMAGES / name, pictures)
    return sorted(rows, key=lambda row: list(NAMES.values()).index(row[0]))


def accuracy(data):
    """Rows of table 6, over the places of bench/quality/fill_table6.py, and figure 11."""
    with tempfile.TemporaryDirectory() as folder:
        run(sys.executable, ROOT / "bench" / "quality" / "fill.py", data, "table6", "--out", folder, "--work",
            pathlib.Path(folder) / "work")
        found = json.loads((pathlib.Path(folder) / "fill_table6.json").read_text())["overall"]
    series = {"the paper": [(row["neighborhood_radius"], row["paper_mean"]) for row in found],
              "this program": [(row["neighborhood_radius"], row["mean"]) for row in found]}
    plots.line_plot(IMAGES / "accuracy.svg", "Mean height error in a hole of the bunny's back",
                    "radius of the neighbourhood", "mean height error", series, log_y=True)
    return [[row["neighborhood_radius"]] + [f"{row[start + key]:.6f}" for key in ("mean", "median", "min", "max")
                                            for start in ("", "paper_")] for row in found]


def page(results, absent, noise, heights, repeats):
    largest = results[max(results)]
    text = f"""# The comparative study

The base paper (Abdel-Wahab, Hussein, Taha, Gaber, GVIP 05) compares Crust, Power Crust, Tight Cocone and ball pivoting
on Stanford models and chooses ball pivoting. This page repeats its measurements with the methods of this program.
`bench/study/study.py` writes it; do not edit it.

All figures are of one thread. Times are CPU seconds of the method alone, the median of {repeats}, without the start of
the process and without files. Memory is the peak of a process that runs the method once, less that of a process that
loads the points and ends. Ball pivoting has the radii of the paper's table 1 and normals from the faces; the Voronoi
methods have no normals. Models that were not there: {", ".join(absent) or "none"}.

The paper's figures are of a 3 GHz Pentium 4 and of its authors' programs; compare ratios, not seconds.

## Ball radii (table 1)

"""
    text += table(["points", "radius"], [[points, radius] for _, points, radius in MODELS if points in results])
    text += """
## Times, in CPU seconds

"""
    text += table(["points"] + [NAMES[m] for m in METHODS] + ["Delaunay alone"],
                  [[n] + [f"{seconds(r, m):.3f}" for m in METHODS] + [f"{r['triangulations']['points']:.3f}"]
                   for n, r in sorted(results.items())])
    text += "\n![Time of the method](images/study/time.svg)\n\n## Regression of time over points (table 2)\n\n"
    text += table(["method", "slope, s per point", "intercept, s", "R^2", "the paper's slope, intercept"],
                  regression_rows(results, seconds, PAPER_SECONDS, 4))
    base = {m: regression([(n, seconds(r, m)) for n, r in results.items()])[0] for m in METHODS}
    text += f"""
Slopes over that of ball pivoting: Tight Cocone {base['tight_cocone'] / base['ball_pivoting']:.1f} (the paper: 3.0),
Power Crust {base['power_crust'] / base['ball_pivoting']:.1f} (5.7), Crust {base['crust'] / base['ball_pivoting']:.1f}
(7.2). In the paper the order is ball pivoting, Tight Cocone, Power Crust, Crust. Ball pivoting gains more than the others
because its walk is vectorised, while theirs wait for the triangulation. Power Crust and Crust change places because
the regular triangulation of the weighted poles takes {largest['triangulations']['balls'] / largest['triangulations']['points']:.1f} times the Delaunay
triangulation of the points here, that of points and poles
{largest['triangulations']['points_and_poles'] / largest['triangulations']['points']:.1f} times (largest model).

## Peak memory

"""
    text += table(["points"] + [NAMES[m] + ", MB" for m in METHODS],
                  [[n] + [f"{megabytes(r, m):.1f}" for m in METHODS] for n, r in sorted(results.items())])
    text += "\n![Peak memory](images/study/memory.svg)\n\n## Regression of memory over points (table 3)\n\n"
    text += table(["method", "slope, MB per point", "intercept, MB", "R^2", "the paper's slope, intercept"],
                  regression_rows(results, megabytes, PAPER_MEGABYTES, 4))
    text += "\n## Mesh size\n\n"
    text += table(["points"] + [NAMES[m] for m in METHODS],
                  [[n] + [triangles(r, m) for m in METHODS] for n, r in sorted(results.items())])
    text += "\nPolygons of Power Crust are cut into triangles here.\n"
    text += "\n![Mesh size](images/study/size.svg)\n\n## Regression of mesh size over points (table 4)\n\n"
    text += table(["method", "triangles per point", "intercept", "R^2", "the paper's slope, intercept"],
                  regression_rows(results, triangles, PAPER_TRIANGLES, 5))
    text += "\n## Vertices and polygons of Power Crust (table 5)\n\n"
    text += table(["points", "vertices", "the paper's", "difference", "polygons", "the paper's", "difference"],
                  size_rows(results))
    text += "\nThe rows that the paper marks with impossible numbers are left out.\n"
    text += "\n## Edges that are not like those of a closed surface\n\n"
    text += table(["points", "method", "boundary edges", "edges of more than two triangles", "components", "Euler number"],
                  [[n, NAMES[m], r[m]["mesh"]["boundary_edges"], r[m]["mesh"]["nonmanifold_edges"],
                    r[m]["mesh"]["components"], r[m]["mesh"]["euler_characteristic"]]
                   for n, r in sorted(results.items()) for m in METHODS])
    text += "\nCrust is measured without manifold extraction, as in the paper.\n"
    text += "\n## Time over the triangulations that a method cannot do without\n\n"
    text += table(["points"] + [f"{NAMES[m]} (asked: {NEEDS[m][1]})" for m in NEEDS],
                  [[n] + [f"{ratio(r, m):.2f}" for m in NEEDS] for n, r in sorted(results.items())])
    text += """
Cocone and Tight Cocone need the Delaunay triangulation of the points; Crust also that of points and poles; Power Crust
that of the points with eight bounding ones, and the regular triangulation of the weighted poles. Each is timed alone
in the same run, sequential, with filtered exact predicates, spatially sorted: made by CGAL from a range of points,
with nothing read out of it. The methods triangulate faster than that. Points are inserted into plain arrays
([Methods](methods.md#triangulations)), which takes """ + f"{largest['triangulations']['points_here'] / largest['triangulations']['points']:.2f}" + """ of CGAL's time on the largest model. Polar balls are
degenerate but for rounding, and pairs of doubles decide about them before CGAL's exact numbers do.

## Meshes (figure 6)

The bunny of 1,889 points. As in the paper, Crust is not a manifold, Power Crust and Tight Cocone are watertight, and ball
pivoting leaves holes where the ball is too large for the shape.

![The meshes of all methods](images/study/meshes.png)

## Noise (section 4.3)

The bunny of 1,889 points with Gaussian noise of variance 1e-6 in each coordinate. The paper sees most holes in ball
pivoting and Crust, fewest in Tight Cocone, then Power Crust.

![The meshes of all methods, with noise: figure 7](images/study/noise.png)

"""
    text += table(["method", "variance", "triangles", "holes", "boundary edges", "edges of more than two triangles"], noise)
    text += """
## Accuracy of the hole fill (table 6, figure 11)

Height errors of the patch of a hole of radius 0.025 in the back of the bunny of 8,171 points, over four places
(`bench/quality/fill_table6.py`; the paper does not say where its own was), by the radius of the neighbourhood, each beside
the paper's. The paper's mean errors are larger than the radius of its hole: its heights are hardly in the same unit.

"""
    text += table(["radius"] + [name + who for name in ("mean", "median", "min", "max") for who in ("", ", the paper's")],
                  heights)
    text += "\n![Mean height error by radius](images/study/accuracy.svg)\n"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=11)
    parser.add_argument("--again", action="store_true", help="write the page from build/bench/study.json")
    options = parser.parse_args()
    if not PROGRAM.exists():
        sys.exit(f"no program {PROGRAM}: it is built where CGAL is installed (libcgal-dev)")
    directory = options.data / "stanford"
    output = ROOT / "build" / "bench"
    results, absent = {}, []
    if options.again:
        results = {int(n): result for n, result in json.loads((output / "study.json").read_text()).items()}
    for name, points, radius in MODELS:
        if not (directory / name).exists():
            absent.append(name)
            continue
        if options.again:
            continue
        print(f"{name}: {points:,} points", flush=True)
        results[points] = measure_model(directory / name, radius, options.repeats)
    if len(results) < 3:
        sys.exit(f"too few models in {directory}")
    output.mkdir(parents=True, exist_ok=True)
    (output / "study.json").write_text(json.dumps(results, indent=1))
    draw(results)
    PAGE.write_text(page(results, absent, noise_meshes(directory), accuracy(options.data), len(next(iter(results.values()))['crust']['samples'])))
    print(f"written: {PAGE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
