"""Trade-off: quality against time, methods that prove set against methods that only search."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context

from reports.figures.style import INK, PAPER, RC, gap_scale, legend_below, new_figure, plain, styles
from reports.figures.svg import Drawn
from reports.metrics.means import shifted_geometric_mean

SOONEST = 1e-3
"""Times below this [s] are drawn as this: they are not resolved."""
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
