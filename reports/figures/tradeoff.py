"""Trade-off: quality against time, methods that prove set against methods that only search; and against n."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from reports.figures.chart import Axis, Chart, Panel, Series
from reports.figures.static import drawn
from reports.figures.style import SOONEST, styles
from reports.figures.svg import Drawn
from reports.metrics.means import shifted_geometric_mean

DRAWN = 1500
"""Instances drawn for a method at most; beyond, an even sample of them."""
QUARTILES = [0.25, 0.5, 0.75]


def tradeoff(runs: pd.DataFrame) -> Drawn | None:
    """Draw one small mark an instance and method, and one large mark a method: its typical time and mean gap."""
    solved = runs[np.isfinite(runs["gap_best"]) & runs["elapsed"].notna()]
    if solved.empty:
        return None
    look = styles(runs["method"])
    told = {"gap": ("gap_best", "median"), "elapsed": ("elapsed", "median"), "instance": ("instance", "first")}
    each = solved.groupby(["method", "digest"]).agg(**told)
    proves = solved.groupby("method")["proves"].any()
    small, large = list[Series](), list[Series]()
    for method, of in each.groupby(level="method"):
        name, hollow = str(method), not bool(proves[method])
        shown = of.iloc[:: max(1, len(of) // DRAWN)]
        times, gaps = shown["elapsed"].clip(lower=SOONEST), 100 * shown["gap"]
        more = {"instance": shown["instance"].to_numpy(str)}
        small.append(Series(name, times, gaps, look[name], "points", more=more, size=4, hollow=hollow, opacity=0.6))
        typical, mean = max(shifted_geometric_mean(of["elapsed"]), SOONEST), 100 * of["gap"].mean()
        more = {"instance": np.array([f"typical of {len(of)}"])}
        large.append(Series(name, [typical], [mean], look[name], "points", more=more, size=9.0, hollow=hollow))
    x = Axis("time of the solve", "s", "log")
    panel = Panel(x, Axis("gap to the best", "%", "gap"), [*small, *large])
    caption = (
        "Each small mark is an instance (median over seeds): the time the method took and the gap of its routes to "
        "the best known or found. The large mark is the method's shifted geometric mean time and mean gap. Filled: "
        "methods that can prove optimality; hollow: methods that only search. Lower and further left is better."
    )
    return drawn("tradeoff", "Exact and heuristic: quality against time", caption, Chart([panel], height=3.4))


def gap_against_n(runs: pd.DataFrame) -> Drawn | None:
    """Draw median and quartiles of the gap to the best at each n; None where there is only one n."""
    solved = runs[np.isfinite(runs["gap_best"])]
    sizes = np.sort(solved["n_tasks"].astype(float).unique())
    if len(sizes) < 2:
        return None
    look, methods, series = styles(runs["method"]), sorted(solved["method"].unique()), []
    for i, method in enumerate(methods):
        gaps = 100 * solved[solved["method"] == method].groupby("n_tasks")["gap_best"].quantile(QUARTILES).unstack()
        n = gaps.index.to_numpy(float)
        low, middle, high = gaps.to_numpy(float).T
        aside = 1 + 0.018 * (i - (len(methods) - 1) / 2)
        mine = Series(str(method), n, middle, look[str(method)], low=low, high=high, spread="bars", aside=aside)
        series.append(replace(mine, width=1.3))
    shown = sizes if len(sizes) <= 8 else sizes[np.unique(np.linspace(0, len(sizes) - 1, 8).astype(int))]
    x = Axis("number of tasks n", scale="log", ticks=shown.tolist())
    panel = Panel(x, Axis("gap to the best", "%", "gap"), series)
    caption = (
        "Gap to the best known or found at the end of the run against the number of tasks: the median over all runs "
        "that found routes, with bars from the lower to the upper quartile (methods are set apart sideways so that "
        "they can be told apart). Lower is better; the scale is linear below 0.1 %."
    )
    return drawn("gap-n", "Gap against the number of tasks", caption, Chart([panel]))
