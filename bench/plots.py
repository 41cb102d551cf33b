"""Line plots as SVG, drawn here so that nothing has to be installed for them."""
import html
import math
import pathlib

WIDTH, HEIGHT = 720, 460
LEFT, RIGHT, TOP, BOTTOM = 84, 24, 48, 64
COLORS = ["#1b6ca8", "#c4442d", "#3a8f4d", "#7a4fa0", "#b8860b", "#4d4d4d"]
MARKS = ["circle", "square", "diamond"]


def _ticks(low, high, log):
    """Round values within [low, high]."""
    if log:
        return [10.0 ** e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)]
    step = 10.0 ** math.floor(math.log10((high - low) / 4 or 1.0))
    for factor in (1, 2, 5, 10):
        if (high - low) / (step * factor) <= 6:
            step *= factor
            break
    return [i * step for i in range(math.floor(low / step), math.ceil(high / step) + 1)]


class _Axis:
    """Data to pixels along one axis; its ends are the outermost ticks."""

    def __init__(self, values, log, begin, end):
        self.log, self.begin, self.end = log, begin, end
        low, high = min(values), max(values)
        if not log:
            low = min(low, 0.0)
        if low == high:
            high = low * 2 if low > 0 else 1.0
        self.ticks = _ticks(low, high, log)

    def __call__(self, value):
        scale = math.log10 if self.log else float
        low, high = scale(self.ticks[0]), scale(self.ticks[-1])
        return self.begin + (scale(value) - low) / (high - low) * (self.end - self.begin)


def _number(value):
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:g}"


def _text(x, y, words, anchor="middle", size=13, extra=""):
    return (f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" {extra}>'
            f"{html.escape(words)}</text>")


def _mark(shape, x, y, color):
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{color}"/>'
    turn = f' transform="rotate(45 {x:.1f} {y:.1f})"' if shape == "diamond" else ""
    return f'<rect x="{x - 3.5:.1f}" y="{y - 3.5:.1f}" width="7" height="7" fill="{color}"{turn}/>'


def _frame(x_axis, y_axis):
    parts = []
    for tick in x_axis.ticks:
        x = x_axis(tick)
        parts.append(f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#e4e4e4"/>')
        parts.append(_text(x, HEIGHT - BOTTOM + 18, _number(tick)))
    for tick in y_axis.ticks:
        y = y_axis(tick)
        parts.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="#e4e4e4"/>')
        parts.append(_text(LEFT - 8, y + 4, _number(tick), "end"))
    parts.append(f'<path d="M{LEFT} {TOP}V{HEIGHT - BOTTOM}H{WIDTH - RIGHT}" stroke="#333" fill="none"/>')
    return parts


def _series(rank, name, points, x_axis, y_axis):
    color, mark = COLORS[rank % len(COLORS)], MARKS[rank % len(MARKS)]
    places = [(x_axis(x), y_axis(y)) for x, y in sorted(points)]
    line = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    parts = [f'<path d="{line}" stroke="{color}" stroke-width="1.8" fill="none"/>']
    parts += [_mark(mark, x, y, color) for x, y in places]
    y = TOP + 10 + 19 * rank
    parts.append(f'<rect x="{LEFT + 10}" y="{y - 12}" width="{22 + 7.2 * len(name):.0f}" height="18" fill="#fff"/>')
    parts.append(_mark(mark, LEFT + 20, y - 3, color))
    parts.append(_text(LEFT + 30, y + 1, name, "start"))
    return parts


def line_plot(path, title, x_title, y_title, series, log_x=False, log_y=False):
    """series: {name: [(x, y)]}. On a logarithmic axis all values must be positive."""
    everything = [point for points in series.values() for point in points]
    x_axis = _Axis([x for x, _ in everything], log_x, LEFT, WIDTH - RIGHT)
    y_axis = _Axis([y for _, y in everything], log_y, HEIGHT - BOTTOM, TOP)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
             f'height="{HEIGHT}" font-family="sans-serif" fill="#222">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>', _text(WIDTH / 2, 26, title, size=16)]
    parts += _frame(x_axis, y_axis)
    for rank, (name, points) in enumerate(series.items()):
        parts += _series(rank, name, points, x_axis, y_axis)
    parts.append(_text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 16, x_title))
    middle = (TOP + HEIGHT - BOTTOM) / 2
    parts.append(_text(18, middle, y_title, extra=f'transform="rotate(-90 18 {middle:.1f})"'))
    pathlib.Path(path).write_text("\n".join(parts + ["</svg>"]) + "\n", encoding="utf-8")
