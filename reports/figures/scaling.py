"""Scaling: the gap of each method against the number of tasks n."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.ticker import FixedLocator, NullLocator

from reports.figures.style import RC, gap_scale, legend_below, new_figure, plain, styles
from reports.figures.svg import Drawn


@rc_context(RC)
def gap_against_n(runs: pd.DataFrame) -> Drawn | None:
    """Draw median and quartiles of the gap to the best at each n; None where there is only one n."""
    solved = runs[np.isfinite(runs["gap_best"])]
    sizes = np.sort(solved["n_tasks"].astype(float).unique())
    if len(sizes) < 2:
        return None
    style = styles(runs["method"])
    methods = sorted(solved["method"].unique())
    figure = new_figure()
    axes = figure.add_subplot()
    for i, method in enumerate(methods):
        mine = solved[solved["method"] == method].groupby("n_tasks")["gap_best"]
        groups = 100 * mine.quantile([0.25, 0.5, 0.75]).unstack()
        look = style[str(method)]
        n = groups.index.to_numpy(float) * (1 + 0.018 * (i - (len(methods) - 1) / 2))
        low, middle, high = groups.to_numpy(float).T
        axes.errorbar(
            n, middle, [middle - low, high - middle], color=look.colour, linestyle=look.dash, marker=look.marker,
            markersize=4.5, elinewidth=1.0, linewidth=1.3, label=str(method),
        )  # fmt: skip
    axes.set_xscale("log")
    shown = sizes if len(sizes) <= 8 else sizes[np.unique(np.linspace(0, len(sizes) - 1, 8).astype(int))]
    axes.xaxis.set_major_locator(FixedLocator(shown.tolist()))
    axes.xaxis.set_minor_locator(NullLocator())
    plain(axes.xaxis)
    gap_scale(axes, 100 * float(solved["gap_best"].min()))
    axes.set(xlabel="number of tasks n")
    legend_below(figure, axes)
    caption = (
        "Gap to the best known or found at the end of the run against the number of tasks: the median over all runs "
        "that found routes, with bars from the lower to the upper quartile (methods are set apart sideways so that "
        "they can be told apart). Lower is better; the scale is linear below 0.1 %."
    )
    return Drawn("gap-n", "Gap against the number of tasks", caption, figure)
