"""What a plan that ignores turns loses: the gap to the best against the spacing of the tasks, in turning radii."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.figures.chart import Axis, Chart, Panel, Series
from reports.figures.static import drawn
from reports.figures.style import styles
from reports.figures.svg import Drawn
from reports.statistics.bootstrap import bootstrap_interval


def loss_against_spacing(runs: pd.DataFrame) -> Drawn | None:
    """Draw each method's mean loss at every spacing ratio, with its interval; None where all have one, or none."""
    told = runs[np.isfinite(runs["spacing"]) & np.isfinite(runs["gap_best"])]
    ratios = np.sort(told["spacing"].unique())
    if len(ratios) < 2:
        return None
    look, series = styles(runs["method"]), []
    each = told.groupby(["method", "spacing", "digest"])["gap_best"].median()
    methods = sorted(told["method"].unique())
    for i, method in enumerate(methods):
        losses = 100 * each[method]
        mean = losses.groupby(level="spacing").mean()
        ends = np.array([bootstrap_interval(of) for _, of in losses.groupby(level="spacing")])
        low, high = np.where(np.isnan(ends), mean.to_numpy()[:, None], ends).T
        aside = 1 + 0.018 * (i - (len(methods) - 1) / 2)
        name, at = str(method), mean.index.to_numpy(float)
        series.append(Series(name, at, mean, look[name], low=low, high=high, spread="bars", aside=aside, width=1.3))
    panel = Panel(Axis("spacing ratio ρ, times the turning radius", scale="log", ticks=ratios.tolist()),
                  Axis("loss", "%", "gap"), series)  # fmt: skip
    caption = (
        "How much longer the longest tour is than the best found on the same instance, against the spacing ratio "
        "ρ = √(area / n) / turning radius: the mean over instances (medians over seeds) with its 95 % interval by "
        "bootstrap. Methods are set apart sideways so that they can be told apart; the scale is linear below 0.1 %."
    )
    return drawn("loss-spacing", "Loss against the spacing of the tasks", caption, Chart([panel]))
