"""Convergence: the gap of each method over time, the median of all runs, and a panel a method with its quartiles."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context

from instances.arrays import Floats
from reports.figures.style import FAINT, RC, SOONEST, gap_scale, legend_below, new_figure, plain, styles
from reports.figures.svg import Drawn
from reports.metrics.integrals import finished_traces

POINTS = 160
"""Points of time at which the runs are compared."""
PANELS = 9
"""Methods with a panel of their own at most: those with the least gap in the end."""


@rc_context(RC)
def convergence(runs: pd.DataFrame) -> Drawn:
    """Draw the median gap to the best known or found over time, a line a method. runs : with gaps."""
    times = _times(runs)
    style = styles(runs["method"])
    figure = new_figure()
    axes = figure.add_subplot()
    for method, (_, middle, _) in _quartiles(runs, times).items():
        look = style[method]
        axes.plot(
            times, 100 * middle, color=look.colour, linestyle=look.dash, drawstyle="steps-post", label=method,
            marker=look.marker, markersize=4, markevery=(list(style).index(method) * 3 % 28, 28),
        )  # fmt: skip
    axes.set_xscale("log")
    plain(axes.xaxis)
    gap_scale(axes, 0.0)
    axes.set(xlabel="time [s]", xlim=(times[0], times[-1]))
    legend_below(figure, axes)
    caption = (
        "Gap of the routes so far to the best known or found: the median of each method's runs over "
        f"{runs['digest'].nunique()} instances and all seeds. A line begins where half of the runs have routes. "
        "Lower and further left is better; the scale is linear below 0.1 %."
    )
    return Drawn("convergence", "Convergence", caption, figure)


@rc_context(RC)
def convergence_panels(runs: pd.DataFrame) -> Drawn:
    """Draw median and quartiles of each method in a panel of its own, the other medians behind it."""
    times = _times(runs)
    style = styles(runs["method"])
    quartiles = _quartiles(runs, times)
    kept = sorted(sorted(quartiles, key=lambda m: (quartiles[m][1][-1], m))[:PANELS])
    columns = min(3, len(kept))
    rows = -(-len(kept) // columns)
    figure = new_figure(height=0.5 + 1.45 * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, method in zip(grid.flat, kept, strict=False):
        for other in kept:
            axes.plot(times, 100 * quartiles[other][1], color=FAINT, linewidth=0.6, drawstyle="steps-post")
        low, middle, high = 100 * quartiles[method]
        look = style[method]
        axes.fill_between(times, low, high, color=look.colour, alpha=0.22, linewidth=0, step="post")
        axes.plot(times, middle, color=look.colour, drawstyle="steps-post")
        axes.set_xscale("log")
        plain(axes.xaxis)
        gap_scale(axes, 0.0)
        axes.set(ylabel="", xlim=(times[0], times[-1]))
        axes.set_title(method, fontsize=8.5)
    for axes in list(grid.flat)[len(kept) :]:
        axes.set_visible(False)
    figure.supxlabel("time [s]", fontsize=9)
    figure.supylabel("gap to the best [%]", fontsize=9)
    left_out = f" The {PANELS} methods with the least gap in the end are shown." if len(quartiles) > PANELS else ""
    caption = (
        "The same, a panel a method: line and band are the median run and the quartiles, which show how much "
        f"instances and seeds differ; the thin lines are the other methods' medians.{left_out}"
    )
    return Drawn("convergence-panels", "Convergence with quartiles", caption, figure)


def _times(runs: pd.DataFrame) -> Floats:
    earliest = min((trace[0, 0] for trace in runs["trace"] if len(trace)), default=SOONEST)
    last = max(float(runs["time_limit"].max()), 2 * SOONEST)
    return np.geomspace(min(max(earliest, SOONEST), last / 2), last, POINTS)


def _quartiles(runs: pd.DataFrame, times: Floats) -> dict[str, Floats]:
    """Return lower quartile, median, upper quartile of the gap at each time, shape (3, times), for each method."""
    return {
        str(method): np.quantile(_gaps(group, times), [0.25, 0.5, 0.75], axis=0, method="nearest")
        for method, group in runs.groupby("method", sort=True)
    }


def _gaps(runs: pd.DataFrame, times: Floats) -> Floats:
    """Return the gap of each run at each time, shape (runs, times), infinite before the first routes."""
    gaps = np.full((len(runs), len(times)), np.inf)
    for i, (trace, best) in enumerate(zip(finished_traces(runs), runs["best"], strict=True)):
        if len(trace) and np.isfinite(best):
            z = np.minimum.accumulate(np.where(np.isnan(trace[:, 1]), np.inf, trace[:, 1]))
            latest = np.searchsorted(trace[:, 0], times, side="right") - 1
            value = np.where(latest >= 0, z[np.maximum(latest, 0)], np.inf)
            gaps[i] = np.maximum(0.0, (value - best) / best if best > 0 else np.where(value > best, np.inf, 0.0))
    return gaps
