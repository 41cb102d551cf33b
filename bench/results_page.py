#!/usr/bin/env python3
"""The page of results: plots of the figures that the pages of docs/results have in their tables. Writes docs/results/README.md
and its plots in docs/images/results. A figure is changed on the page that has it; this page is made again then.

usage: bench/results_page.py [--check]

--check writes nothing and ends with 1 where the page or a plot is not what the script makes. Plots are compared where they were
drawn by the same version of matplotlib, and need Debian's python3-matplotlib."""
import argparse
import pathlib
import re
import sys
import tempfile

import interpreter

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "docs" / "results"
PAGE = RESULTS / "README.md"
IMAGES = ROOT / "docs" / "images" / "results"
DRAWN_BY = re.compile(rb"Matplotlib v([\d.]+)")

HEAD = """\
# Results

Figures of the benchmarks as plots. Each comes from a table of the page that is named below it, with the machine, the commands and
what was measured beside. `bench/results_page.py` makes this page of those tables; do not edit it.
"""


def tables(page):
    """[(column names, [cells of a row])] of a page of docs/results."""
    found, rows = [], None
    for line in (RESULTS / page).read_text(encoding="utf-8").splitlines():
        if not line.startswith("|"):
            rows = None
            continue
        cells = [cell.strip() for cell in line.strip()[1:-1].split("|")]
        if rows is None:
            rows = []
            found.append((cells, rows))
        elif not set("".join(cells)) <= set("-: "):
            rows.append(cells)
    return found


def table(page, *columns):
    """The rows of the one table whose first columns have these names, as {column: cell}."""
    matching = [(names, rows) for names, rows in tables(page) if names[:len(columns)] == list(columns)]
    if len(matching) != 1:
        sys.exit(f"docs/results/{page}: {len(matching)} tables begin with the columns {', '.join(columns)}, not one")
    names, rows = matching[0]
    # Of columns with the same name, such as those of another program, the first counts.
    return [dict(reversed(list(zip(names, row)))) for row in rows]


def number(cell):
    """The first number of a cell, of "before → after" the last one; none where there is none."""
    found = re.match(r"\**(-?[\d,]*\.?\d+)", cell.split("→")[-1].strip())
    return float(found.group(1).replace(",", "")) if found else None


def points(rows, x, y):
    """[(x, y)] of two columns; what has no place on logarithmic axes is left out."""
    pairs = [(number(row[x]), number(row[y])) for row in rows]
    return [pair for pair in pairs if None not in pair and min(pair) > 0.0]


def bars(rows, label, columns):
    """{column: [(label, value)]}."""
    return {name: [(row[label], number(row[column])) for row in rows if number(row[column]) is not None]
            for name, column in columns.items()}


def of_group(rows, group, label, value, names):
    """{name: [(group, value)]} of a table with a row for each name of a group."""
    return {name: [(row[group], number(row[value])) for row in rows if row[label] == name] for name in names}


def whole_jobs():
    rows = table("scans.md", "scan, config", "points", "wall, s", "CPU, s", "points/s")
    for row in rows:
        row["scan"] = row["scan, config"].split(",")[0]
    return bars(rows, "scan", {"points per second": "points/s"})


def peers():
    rows = table("scans.md", "scan", "orbweave, whole job", "orbweave, same work")
    for row in rows:
        row["short"] = row["scan"].split(",")[0]
        row.update({name: "" for name, cell in row.items() if cell.startswith("none")})
    return bars(rows, "short", {"orbweave, whole job": "orbweave, whole job", "orbweave, same work": "orbweave, same work",
                                "Open3D, ball pivoting": "Open3D 0.16 ball pivoting", "CGAL, advancing front":
                                "CGAL advancing front"})


def growth():
    rows = table("scans.md", "points", "wall, s", "points/s", "peak memory")
    return {"peak memory": points(rows, "points", "peak memory")}


def levels():
    rows = table("levels.md", "level", "tiles", "triangles", "at borders", "stated error")
    return {"stated": points(rows, "triangles", "stated error"), "measured at most": points(rows, "triangles", "measured at most"),
            "measured, mean": points(rows, "triangles", "mean")}


def nodes():
    """Seconds at 10 GB/s of the two tables: oriented points, then raw ones."""
    series = {}
    found = [(names, rows) for names, rows in tables("scaling.md") if names[0] == "nodes"]
    for kind, (names, rows) in zip(("oriented", "raw"), found):
        for name, column in ((kind, names.index("after")), (f"{kind}, storage alone", names.index("storage alone"))):
            series[name] = [(number(row[0]), number(row[column])) for row in rows]
    return series


def rooms():
    rows = table("rooms.md", "scene, 100,000 points", "orbweave", "Open3D ball pivoting")
    for row in rows:
        row["scene"] = row["scene, 100,000 points"].split(":")[0]
    return bars(rows, "scene", {name: name for name in ("orbweave", "Open3D ball pivoting", "Poisson", "Poisson, trimmed")})


def signs():
    rows = table("normals.md", "cloud", "points", "agree", "disagree")
    wrong = [dict(row, ours=f"{1.0 - number(row['agree']):.6f}", other=f"{1.0 - number(row['Open3D 0.16: agree']):.6f}")
             for row in rows if number(row["Open3D 0.16: agree"]) not in (None, 1.0)]
    return bars(wrong, "cloud", {"orbweave": "ours", "Open3D": "other"})


def noise():
    rows = table("noise.md", "scene", "cleaning")
    return of_group(rows, "scene", "cleaning", "mean", ("none", "before", "place by place"))


def edges():
    """A roof without noise: before and after patches may be creased."""
    rows = table("holes.md", "shape", "radius 4")
    roof = next(cells for cells in rows if cells["shape"].startswith("roof"))
    sizes = [(name, float(name.split()[-1])) for name in roof if name != "shape"]
    return {"smooth patch": [(size, float(roof[name].split("→")[0])) for name, size in sizes],
            "patch that may be creased": [(size, number(roof[name])) for name, size in sizes]}


def disk():
    rows = table("disk.md", "job", "predicted", "measured")
    return bars(rows, "job", {"predicted": "predicted", "measured": "measured"})


# Heading, file, what is drawn and how, sentence, page.
PLOTS = [
    ("Whole jobs on real scans", "whole_jobs", whole_jobs, {"kind": "bar", "y_title": "points per second"},
     "From the scan file to the mesh file, normals, cleaning and holes included.", "scans.md"),
    ("Beside other programs", "peers", peers, {"kind": "bar", "y_title": "seconds"},
     "\"Same work\" is the reconstruction of the same points with normals. MeshLab's ball pivoting had not "
     "ended after 100 s: it has no bar.", "scans.md"),
    ("Peak memory of growing jobs", "growth", growth,
     {"kind": "line", "x_title": "points", "y_title": "MiB", "log_x": True}, "Raw scans of a torus from six places, cleaned, in a budget of 2 GiB.", "scans.md"),
    ("Surfaces with the truth known", "rooms", rooms, {"kind": "bar", "y_title": "F-score", "from_y": 0.8},
     "The axis does not begin at 0. Higher is better.", "rooms.md"),
    ("Sides of normals that are wrong", "signs", signs, {"kind": "bar", "y_title": "share of the points"},
     "Clouds on which a program is right about every point are left out. Lower is better.", "normals.md"),
    ("Noise that grows with the distance", "noise", noise, {"kind": "bar", "y_title": "mean distance from the truth, spacings"},
     "Without cleaning, with one radius for the cloud, and place by place. Lower is better.", "noise.md"),
    ("Holes across an edge", "edges", edges,
     {"kind": "line", "x_title": "radius of the hole, spacings", "y_title": "RMS distance from the truth, spacings"},
     "A roof of two slopes of 30 degrees without noise, a disc cut out at its edge.", "holes.md"),
    ("Levels of detail", "levels", levels,
     {"kind": "line", "x_title": "triangles of the level", "y_title": "error (the mesh is 2.9 wide)", "log_x": True,
      "log_y": True}, "What a tileset says of each level, and what was measured.", "levels.md"),
    ("A billion points on many machines", "nodes", nodes,
     {"kind": "line", "x_title": "nodes", "y_title": "seconds", "log_x": True, "log_y": True},
     "Simulated by a model that measurements on two cores feed, with storage of 10 GB/s.", "scaling.md"),
    ("Room on disk", "disk", disk, {"kind": "bar", "y_title": "MB"},
     "What a plan says before the job, and what the job took.", "disk.md"),
]


def page_text():
    text = HEAD
    for heading, name, _, how, sentence, page in PLOTS:
        text += (f"\n## {heading}\n\n![{heading}: {how['y_title']}](../images/results/{name}.svg)\n\n{sentence} "
                 f"[The table]({page}).\n")
    return text


def draw(folder):
    import plots
    for heading, name, series_of, how, _, _ in PLOTS:
        options = dict(how)
        kind = options.pop("kind")
        if kind == "line":
            plots.line_plot(folder / f"{name}.svg", heading, options.pop("x_title"), options.pop("y_title"), series_of(),
                            **options)
        else:
            plots.bar_plot(folder / f"{name}.svg", heading, options.pop("y_title"), series_of(), **options)


def drawn_by(path):
    found = DRAWN_BY.search(path.read_bytes()) if path.is_file() else None
    return found.group(1) if found else None


def differing_plots():
    with tempfile.TemporaryDirectory() as folder:
        draw(pathlib.Path(folder))
        new = sorted(pathlib.Path(folder).glob("*.svg"))
        there = {path.name for path in IMAGES.glob("*.svg")}
        wrong = sorted(there ^ {path.name for path in new})
        for path in new:
            old = IMAGES / path.name
            if path.name in there and drawn_by(old) == drawn_by(path) and old.read_bytes() != path.read_bytes():
                wrong.append(path.name)
        return wrong


def check():
    wrong = [] if PAGE.is_file() and PAGE.read_text(encoding="utf-8") == page_text() else [PAGE.name]
    for _, name, series_of, *_ in PLOTS:
        if any(not values for values in series_of().values()):
            wrong.append(f"{name}: a series without a value")
    if interpreter.with_packages("matplotlib") is None:
        print("results page: matplotlib is missing, no plot is compared")
    else:
        interpreter.need("matplotlib")
        wrong += differing_plots()
    if wrong:
        sys.exit(f"results page: {', '.join(wrong)}: not what bench/results_page.py makes; run it")
    print(f"results page: {len(PLOTS)} plots are those of the tables")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    if parser.parse_args().check:
        return check()
    interpreter.need("matplotlib")
    IMAGES.mkdir(parents=True, exist_ok=True)
    draw(IMAGES)
    PAGE.write_text(page_text(), encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
