"""Trade-off: quality against time, methods that prove set against methods that only search; and against n."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.ticker import FixedLocator, NullLocator

from reports.figures.style import INK, PAPER, RC, SOONEST, gap_scale, legend_below, new_figure, plain, styles
from reports.figures.svg import Drawn
from reports.metrics.means import shifted_geometric_mean

DRAWN = 1500
"""Instances drawn for a method at most; beyond, an even sample of them."""


@rc_context(RC)
def tradeoff(runs: pd.DataFrame) -> Drawn | None:
    """Draw one small mark an instance and method, and one large mark a method: its typical time and mean gap."""
    solved = runs[np.isfinite(runs["gap_best"]) & runs["elapsed"].notna()]
    if solved.empty:
        return None
    style = styles(runs["method"])
    each = solved.groupby(["method", "digest"]).agg(gap=("gap_best", "median"), elapsed=("elapsed", "median"))
    proves = solved.groupby("method")["proves"].any()
    figure = new_figure(height=3.8)
    axes = figure.add_subplot()
    for method, of in each.groupby(level="method"):
        look, exact = style[str(method)], bool(proves[method])
        shown = of.iloc[:: max(1, len(of) // DRAWN)]
        face = look.colour if exact else "none"
        axes.scatter(
            shown["elapsed"].clip(lower=SOONEST), 100 * shown["gap"], s=11, marker=look.marker, facecolors=face,
            edgecolors=look.colour, linewidths=0.7, alpha=0.45, rasterized=len(each) > 2000,
        )  # fmt: skip
        typical = shifted_geometric_mean(of["elapsed"])
        name = f"{method} ({'proves' if exact else 'searches'})"
        axes.scatter(
            [max(typical, SOONEST)], [100 * of["gap"].mean()], s=80, marker=look.marker, label=name, zorder=4,
            facecolors=look.colour if exact else PAPER, edgecolors=INK if exact else look.colour, linewidths=1.4,
        )  # fmt: skip
    axes.set_xscale("log")
    plain(axes.xaxis)
    gap_scale(axes, 100 * float(each["gap"].min()))
    decades = np.log10(each["elapsed"].clip(lower=SOONEST).quantile([0.0, 1.0]).to_numpy(float) * [0.9, 1.1])
    low, high = max(0.7 * SOONEST, 10.0 ** np.floor(decades[0])), 10.0 ** np.ceil(decades[1])
    axes.set(xlabel="time of the solve [s]", xlim=(low, high))
    legend_below(figure, axes, columns=3)
    caption = (
        "Each small mark is an instance (median over seeds): the time the method took and the gap of its routes to "
        "the best known or found. The large mark is the method's shifted geometric mean time and mean gap. Filled: "
        "methods that can prove optimality; hollow: methods that only search. Lower and further left is better."
    )
    return Drawn("tradeoff", "Exact and heuristic: quality against time", caption, figure)


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
