"""Task locations on the map of what stays unknown, before and after sensing; and how methods get to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.contour import QuadContourSet

from instances.arrays import Floats
from instances.environment.region import Region
from reports.figures.chart import Axis, Chart, Panel, Series
from reports.figures.static import drawn
from reports.figures.style import COLOURS, INK, PAPER, RC, Style, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes

MAP = "Blues"
"""Light where little is left unknown; one hue, so that it also reads in grey."""


@rc_context(RC)
def draw_placement(
    region: Region, points: Floats, tests: Floats, sd: tuple[Floats, Floats, Floats], prior_sd: float, title: str
) -> Drawn:
    """Return the map of the posterior sd after readings at the tasks, and two cuts through it.

    points (n, 2), tests (m, 2) [m]. sd : coordinates x (p,) and y (q,) [m] and the posterior sd (q, p), NaN outside the
    region. prior_sd : σ_f.
    """
    figure = new_figure(7.2, 3.9)
    plan, cut = figure.subplots(1, 2, width_ratios=[1.35, 1.0])
    shades = uncertainty(plan, region, sd, prior_sd)
    plan.scatter(tests[:, 0] / KM, tests[:, 1] / KM, s=2.0, color=INK, alpha=0.35, linewidths=0, zorder=3)
    tasks(plan, points)
    bar = figure.colorbar(shades, ax=plan, location="bottom", shrink=0.8, aspect=40, pad=0.02)
    bar.set_label("posterior sd after readings at the tasks [unit of the signal]")
    _cuts(cut, sd, prior_sd)
    figure.suptitle(title, fontsize=9.5)
    caption = (
        "Left: tasks (white discs) and test points (dots) over the posterior standard deviation once every task has "
        "been read; dark is unknown. Right: the same along the two middle lines of the map, as a band of two standard "
        "deviations about the mean, before (grey) and after (blue): sensing narrows the band."
    )
    return Drawn("placement", "Task locations over what stays unknown", caption, figure)


def uncertainty(axes: Axes, region: Region, sd: tuple[Floats, Floats, Floats], prior_sd: float) -> QuadContourSet:
    """Draw the map of the posterior sd and the region's outline; return the shades for a colour bar."""
    map_axes(axes, region)
    xs, ys, values = sd
    levels = prior_sd * np.array([0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0001])
    shades = _shades(len(levels) - 1)
    return axes.contourf(xs / KM, ys / KM, np.ma.masked_invalid(values), levels=levels, colors=shades, zorder=1)


def tasks(axes: Axes, points: Floats) -> None:
    """Draw task locations as discs that stand out on light and dark."""
    size = float(np.clip(1200 / max(len(points), 1), 7, 34))
    x, y = points.T / KM
    axes.scatter(x, y, s=size, color=PAPER, edgecolors=INK, linewidths=0.9, zorder=5, clip_on=False)


def _shades(count: int) -> list[str]:
    return [to_hex(colormaps[MAP](0.06 + 0.86 * i / (count - 1))) for i in range(count)]


def _cuts(axes: Axes, sd: tuple[Floats, Floats, Floats], prior_sd: float) -> None:
    """Draw ±2 sd along the middle row and the middle column of the map, before and after."""
    xs, ys, values = sd
    lines = [
        (xs / KM, values[len(ys) // 2], f"west to east at y = {ys[len(ys) // 2] / KM:.3g} km"),
        (ys / KM, values[:, len(xs) // 2], f"south to north at x = {xs[len(xs) // 2] / KM:.3g} km"),
    ]
    axes.set_axis_off()
    for k, (along, after, words) in enumerate(lines):
        panel = axes.inset_axes((0.12, 0.62 - 0.58 * k, 0.86, 0.34))
        before = np.where(np.isnan(after), np.nan, prior_sd)
        panel.fill_between(along, -2 * before, 2 * before, color=INK, alpha=0.14, linewidth=0, label="before")
        panel.fill_between(along, -2 * after, 2 * after, color=COLOURS[0], alpha=0.75, linewidth=0, label="after")
        panel.axhline(0.0, color=INK, linewidth=0.7)
        panel.set_title(words, fontsize=8)
        panel.set_ylabel("mean ± 2 sd")
        panel.set_xlabel("[km]", labelpad=1)
        if k == 0:
            panel.legend(loc="upper right", ncols=2, fontsize=7, borderpad=0.1)


def draw_placement_convergence(
    traces: Mapping[str, Sequence[tuple[float, float]]], bound: float, title: str, look: Mapping[str, Style]
) -> Drawn | None:
    """Return gap to `bound` [nats] against elapsed [s], one line a method; None where no method has a trace.

    traces : method → (elapsed [s], worth [nats]), improvements in order. look : of each method.
    """
    found = {name: np.array(trace, dtype=float) for name, trace in traces.items() if len(trace)}
    if not found:
        return None
    last = 1.4 * max(float(trace[-1, 0]) for trace in found.values())
    first = min(float(trace[0, 0]) for trace in found.values())
    series = []
    for name in sorted(found):
        elapsed, value = found[name].T
        gap = 100 * (1 - value / bound)
        series.append(Series(name, np.append(elapsed, last), np.append(gap, gap[-1]), look[name], "step"))
    x = Axis("wall clock", "s", "log", (0.7 * max(first, 1e-4), last))
    apart = min(float(np.min(one.y)) for one in series) > 0.1
    y = Axis("gap to the certificate", "%", "log" if apart else "gap")
    caption = (
        "How far each method's best placement so far lies under the certificate, which no placement can pass. Part of "
        "the gap that all share is the certificate's own: under criterion (b) it bounds the information gain, of which "
        f"the noisy test points see only a part.{'' if apart else ' The scale is linear below 0.1 %.'}"
    )
    chart = Chart([Panel(x, y, series, title)])
    return drawn("placement-convergence", "Convergence to the certificate", caption, chart)
