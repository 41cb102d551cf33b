"""Plots of measurements, drawn with matplotlib (Debian's python3-matplotlib) to SVG files."""
import pathlib

MARKS = "osD^vP"


def line_plot(path, title, x_title, y_title, series, log_x=False, log_y=False):
    """series: {name: [(x, y)]}. On a logarithmic axis all values must be positive."""
    import matplotlib  # not before something is drawn: modules that measure are imported without it, too
    matplotlib.use("svg")
    from matplotlib import pyplot, ticker
    # The same numbers make the same file, with text that can be searched.
    pyplot.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "orbweave"})
    figure, axes = pyplot.subplots(figsize=(7.2, 4.6), layout="constrained")
    for rank, (name, points) in enumerate(series.items()):
        xs, ys = zip(*sorted(points))
        axes.plot(xs, ys, marker=MARKS[rank % len(MARKS)], markersize=4, label=name)
    axes.set(title=title, xlabel=x_title, ylabel=y_title)
    for axis, is_log in ((axes.xaxis, log_x), (axes.yaxis, log_y)):
        axis.axes.set(**{f"{axis.axis_name}scale": "log" if is_log else "linear"})
        axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:,.10g}"))
    if not log_y:
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    axes.grid(color="#e4e4e4")
    axes.legend(frameon=False)
    figure.savefig(pathlib.Path(path), metadata={"Date": None})
    pyplot.close(figure)


def bar_plot(path, title, y_title, series, from_y=None):
    """series: {name: [(group, value)]}; a group without a value of a series has no bar of it there."""
    import matplotlib
    matplotlib.use("svg")
    from matplotlib import pyplot, ticker
    pyplot.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "orbweave"})
    figure, axes = pyplot.subplots(figsize=(7.2, 4.6), layout="constrained")
    groups = list(dict.fromkeys(group for values in series.values() for group, _ in values))
    width = 0.8 / len(series)
    for rank, (name, values) in enumerate(series.items()):
        places = [groups.index(group) + (rank - (len(series) - 1) / 2) * width for group, _ in values]
        drawn = axes.bar(places, [value for _, value in values], width, label=name)
        axes.bar_label(drawn, [f"{value:,.4g}" if value < 1000 else f"{value:,.0f}" for _, value in values], fontsize=7)
    axes.set(title=title, ylabel=y_title)
    axes.set_xticks(range(len(groups)), groups, rotation=20 if len(groups) > 3 else 0,
                    ha="right" if len(groups) > 3 else "center", fontsize=8)
    axes.yaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:,.10g}"))
    if from_y is not None:
        axes.set_ylim(bottom=from_y)
    axes.grid(axis="y", color="#e4e4e4")
    axes.set_axisbelow(True)
    if len(series) > 1:
        axes.legend(frameon=False)
    figure.savefig(pathlib.Path(path), metadata={"Date": None})
    pyplot.close(figure)


def picture_row(path, pictures):
    """pictures: [(title, file)], side by side in one file."""
    import matplotlib
    matplotlib.use("agg")
    from matplotlib import pyplot
    figure, row = pyplot.subplots(1, len(pictures), figsize=(2.6 * len(pictures), 2.9), layout="constrained")
    for axes, (title, file) in zip(row, pictures):
        axes.imshow(pyplot.imread(file))
        axes.set_title(title, fontsize=10)
        axes.axis("off")
    figure.savefig(pathlib.Path(path), dpi=110, metadata={"Software": None})
    pyplot.close(figure)
