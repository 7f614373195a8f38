"""Convergence: the median gap over time of each method, with its quartiles, over every run."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context
from numpy.typing import NDArray

from reports.figures.style import RC, gap_scale, legend_below, new_figure, plain, styles
from reports.figures.svg import Drawn
from reports.metrics.integrals import finished_traces

POINTS = 160
"""Points of time at which the runs are compared."""


def convergence(runs: pd.DataFrame) -> Drawn:
    """Draw the gap to the best known or found over time: median and quartiles of all runs of each method.

    runs : with gaps (`metrics.with_gaps`).
    """
    times = _times(runs)
    style = styles(runs["method"])
    figure = new_figure()
    with rc_context(RC):
        axes = figure.add_subplot()
        for method, group in runs.groupby("method", sort=True):
            low, middle, high = np.quantile(_gaps(group, times), [0.25, 0.5, 0.75], axis=0, method="nearest")
            look = style[str(method)]
            axes.plot(
                times, 100 * middle, color=look.colour, linestyle=look.dash, drawstyle="steps-post", label=str(method)
            )
            axes.fill_between(times, 100 * low, 100 * high, color=look.colour, alpha=0.13, linewidth=0, step="post")
        axes.set_xscale("log")
        plain(axes.xaxis)
        gap_scale(axes, 0.0)
        axes.set(xlabel="time [s]", xlim=(times[0], times[-1]))
        legend_below(figure, axes)
    caption = (
        f"Gap of each run's routes so far to the best known or found, over {runs['digest'].nunique()} instances: the "
        "line is the median run, the band its quartiles. A line begins where half of the runs have routes. Lower and "
        "further left is better; the scale is linear below 0.1 %."
    )
    return Drawn("convergence", "Convergence", caption, figure)


def _times(runs: pd.DataFrame) -> NDArray[np.float64]:
    earliest = min((trace[0, 0] for trace in runs["trace"] if len(trace) and trace[0, 0] > 0), default=1e-3)
    last = max(float(runs["time_limit"].max()), 2e-3)
    return np.geomspace(min(max(earliest, 1e-3), last / 2), last, POINTS)


def _gaps(runs: pd.DataFrame, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the gap of each run at each time, shape (runs, times), infinite before the first routes."""
    gaps = np.full((len(runs), len(times)), np.inf)
    for i, (trace, best) in enumerate(zip(finished_traces(runs), runs["best"], strict=True)):
        if len(trace) and np.isfinite(best):
            z = np.minimum.accumulate(np.where(np.isnan(trace[:, 1]), np.inf, trace[:, 1]))
            latest = np.searchsorted(trace[:, 0], times, side="right") - 1
            value = np.where(latest >= 0, z[np.maximum(latest, 0)], np.inf)
            gaps[i] = np.maximum(0.0, (value - best) / best if best > 0 else np.where(value > best, np.inf, 0.0))
    return gaps
