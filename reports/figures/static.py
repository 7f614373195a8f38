"""Static: a chart drawn by matplotlib, for paper and for pages without a script."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullFormatter, NullLocator

from reports.figures.chart import Axis, Chart, Panel, Series, marks
from reports.figures.style import PAPER, RC, new_figure, plain
from reports.figures.svg import Drawn

LINEAR_BELOW = 0.1
"""Gaps [%] below which their scale is linear."""
LINEAR_SHARE = 0.5
"""Length of that part, in decades."""
RASTER_ABOVE = 2000
"""Marks of a panel above which they are kept as pixels."""


def drawn(key: str, title: str, caption: str, chart: Chart) -> Drawn:
    """Return `chart` as a figure with its words."""
    return Drawn(key, title, caption, draw(chart), chart)


@rc_context(RC)
def draw(chart: Chart) -> Figure:
    """Return `chart` as a matplotlib figure, its legend below it."""
    rows = -(-len(chart.panels) // chart.columns)
    looks = list(chart.looks)
    legend = len(looks) > 1 and not chart.titled
    figure = new_figure(height=chart.height * rows + (0.5 if legend else 0.1))
    grid = figure.subplots(rows, chart.columns, sharex=chart.shared, sharey=chart.shared, squeeze=False)
    for number, axes in enumerate(grid.flat):
        if number >= len(chart.panels):
            axes.set_visible(False)
            continue
        panel = chart.panels[number]
        crowded = sum(len(series.values["x"]) for series in panel.series if series.kind == "points") > RASTER_ABOVE
        for series in panel.series:
            rank = looks.index(series.name) if series.name in looks else 0
            _series(axes, panel, series, rank, crowded)
        _frame(axes, panel)
        _labels(axes, panel)
        if chart.shared:  # the last row may be short: the panel above the hole is the lowest of its column
            lowest = number + chart.columns >= len(chart.panels)
            axes.tick_params(labelbottom=lowest)
            axes.set_xlabel(panel.x.words if lowest else "")
        if number % chart.columns and panel.y == chart.panels[number - 1].y:
            axes.tick_params(labelleft=False)
            axes.set_ylabel("")
        elif chart.shared and rows > 1:
            axes.set_ylabel("")
            figure.supylabel(panel.y.words, fontsize=RC["axes.labelsize"])
    if legend:
        _legend(figure, chart)
    return figure


def _frame(axes: Axes, panel: Panel) -> None:
    """Give `axes` scales, ends, ticks, words and rules."""
    for side in ("x", "y"):
        _scale(axes, side, getattr(panel, side), panel.span(side))
    axes.set(xlabel=panel.x.words, ylabel=panel.y.words)
    if panel.title:
        axes.set_title(panel.title, loc="left")
    for rule in panel.rules:
        line = axes.axvline if rule.axis == "x" else axes.axhline
        line(rule.at, color=rule.look.colour, linestyle=rule.look.dash, linewidth=1.0, zorder=1.5)


def _scale(axes: Axes, side: Literal["x", "y"], axis: Axis, span: tuple[float, float]) -> None:
    """Set scale, ends and ticks of one axis."""
    this = getattr(axes, f"{side}axis")
    if axis.scale == "log":
        getattr(axes, f"set_{side}scale")("log")
        if span[1] / span[0] < 200:
            this.set_major_locator(LogLocator(subs=(1, 2, 5)))
        plain(this)
    elif axis.scale == "gap":
        getattr(axes, f"set_{side}scale")("symlog", linthresh=LINEAR_BELOW, linscale=LINEAR_SHARE)
        plain(this)
    if axis.names:
        getattr(axes, f"set_{side}ticks")(range(len(axis.names)), axis.names)
        axes.grid(visible=False, axis=side)
        span = span[::-1] if side == "y" else span  # the first on top
    elif axis.ticks:
        this.set_major_locator(FixedLocator(list(axis.ticks)))
        this.set_minor_locator(NullLocator())
        this.set_minor_formatter(NullFormatter())
    elif axis.scale == "linear":
        this.set_major_locator(MaxNLocator("auto", steps=[1, 2, 2.5, 5, 10]))
    getattr(axes, f"set_{side}lim")(*span)


def _series(axes: Axes, panel: Panel, series: Series, rank: int, crowded: bool) -> None:
    """Draw one series."""
    values, look = series.values, series.look
    values["x"] = values["x"] * series.aside
    style: dict[str, Any] = {"color": look.colour, "alpha": series.opacity, "linewidth": series.width}
    if "low" in values:
        _spread(axes, series, values)
    if series.kind == "points":
        hollow = {"facecolors": "none", "edgecolors": look.colour, "linewidths": 1.0}
        axes.scatter(
            values["x"], values["y"], s=series.size**2, marker=look.marker,
            **(hollow if series.hollow else {"color": look.colour}), alpha=series.opacity, rasterized=crowded, zorder=3,
        )  # fmt: skip
        return
    drawstyle = "steps-post" if series.kind == "step" else "default"
    axes.plot(values["x"], values["y"], linestyle=look.dash, drawstyle=drawstyle, **style)
    x, y = marks(panel, series, rank)
    axes.plot(x, y, look.marker, color=look.colour, markersize=series.size, linestyle="none", alpha=series.opacity)


def _labels(axes: Axes, panel: Panel) -> None:
    """Write labels beside points, on the side where there is room, and above what they would overprint."""
    dots = axes.figure.get_dpi() / 72
    letter, middle = 7.5 * dots, axes.transAxes.transform((0.5, 0.5))[0]
    points = [series for series in panel.series if series.kind == "points"]
    places = [axes.transData.transform(np.column_stack([one.values["x"], one.values["y"]])) for one in points]
    taken = [(x - 0.5 * letter, x + 0.5 * letter, y) for of in places for x, y in of]
    for series, of in zip(points, places, strict=True):
        for (x, y), word in zip(of, series.values[series.labels] if series.labels else [], strict=False):
            way, length = (1 if x < middle else -1), 0.65 * letter * len(word)
            left, right = sorted((x + 0.7 * letter * way, x + (0.7 * letter + length) * way))
            height = y
            for start, end, other in sorted(taken, key=lambda box: box[2]):
                if start < right and left < end and abs(other - height) < 1.2 * letter:
                    height = other + 1.2 * letter
            taken.append((left, right, height))
            shift = (0.7 * 7.5 * way, (height - y) / dots - 3)
            at, align = tuple(axes.transData.inverted().transform((x, y))), "left" if way > 0 else "right"
            axes.annotate(word, at, shift, textcoords="offset points", ha=align, fontsize=7.5).set_in_layout(False)


def _spread(axes: Axes, series: Series, values: dict[str, Any]) -> None:
    """Draw the spread of a series."""
    x, y, low, high, colour = (*(values[key] for key in ("x", "y", "low", "high")), series.look.colour)
    if series.spread == "band":
        step: Any = "post" if series.kind == "step" else None
        axes.fill_between(x, low, high, color=colour, alpha=0.22, linewidth=0, step=step)
    elif series.spread == "bars":
        axes.vlines(x, low, high, color=colour, linewidth=1.0)
    else:
        axes.hlines(y, low, high, color=colour, linewidth=2.0)


def _legend(figure: Figure, chart: Chart) -> None:
    """Put a legend below `figure`: as many columns as fit."""
    looks = chart.looks
    handles = [_handle(name, series) for name, series in looks.items()]
    fitting = max(1, min(4, len(looks), int(112 / (max(map(len, looks)) + 9))))
    figure.legend(handles=handles, loc="outside lower center", ncols=fitting, handlelength=3.2)


def _handle(name: str, series: Series) -> Line2D:
    look = series.look
    points = series.kind == "points"
    dash: Any = "none" if points else look.dash
    marker = look.marker if points or series.size else ""
    return Line2D(
        [], [], color=look.colour, linestyle=dash, marker=marker, markersize=5, label=name,
        markerfacecolor=PAPER if series.hollow else look.colour,
    )  # fmt: skip


def transformed(axis: Axis, values: Any) -> Any:
    """Return where `values` lie on the scale of gaps, as matplotlib has it; as they are on any other."""
    if axis.scale != "gap":
        return values
    v = np.asarray(values, dtype=float)
    linear = LINEAR_SHARE / (1 - 1 / 10)
    with np.errstate(divide="ignore", invalid="ignore"):
        beyond = np.sign(v) * LINEAR_BELOW * (linear + np.log10(np.abs(v) / LINEAR_BELOW))
    return np.where(np.abs(v) <= LINEAR_BELOW, v * linear, beyond)
