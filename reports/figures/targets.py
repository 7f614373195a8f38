"""Time to target, and the runtime distribution aggregated over many targets.

Time to target: the share of runs within a given gap of the best by a time (R. M. Aiex, M. G. C. Resende, C. C. Ribeiro,
TTT plots, Optim. Lett. 1 (2007) 355–366). Aggregated over runs and targets it is the ECDF of COCO (N. Hansen et al.,
COCO: a platform for comparing continuous optimizers, Optim. Methods Softw. 36 (2021) 114–144).
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context

from reports.figures.steps import step_axes, step_figure
from reports.figures.style import RC, SOONEST, legend_below, new_figure, styles
from reports.figures.svg import Drawn
from reports.metrics.targets import time_to_target

PANELS = [0.05, 0.01, 0.0]
"""Targets with a panel each: gaps to the best."""
LADDER = [0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0]
"""Targets of the aggregated distribution."""


@rc_context(RC)
def time_to_target_plot(runs: pd.DataFrame) -> Drawn | None:
    """Draw, for each target, the share of runs that had reached it by a time; None where none was. runs : with gaps."""
    times = time_to_target(runs, PANELS)
    span, look = _span(times, runs), styles(runs["method"])
    if span is None:
        return None
    figure = new_figure(height=3.1)
    panels = figure.subplots(1, len(PANELS), sharey=True)
    for axes, target in zip(panels, PANELS, strict=True):
        reached = dict(iter(times[target].clip(lower=span[0]).groupby(runs["method"])))
        step_axes(axes, reached, look, span, "time [s]", value="log")
        axes.set_title(f"within {100 * target:g} %" if target else "the best itself")
    panels[0].set_ylabel("share of runs [%]")
    legend_below(figure, panels[0])
    caption = (
        "Share of runs (every instance and seed) whose routes were within 5 % and 1 % of the best known or found, "
        "or as good as it, by the given time. Higher and further left is better; a line that ends below 100 % shows "
        "runs that never got there."
    )
    return Drawn("time-to-target", "Time to target", caption, figure)


def runtime_distribution(runs: pd.DataFrame) -> Drawn | None:
    """Draw the share of (run, target) pairs reached by a time, over the ladder of targets; None where none was."""
    times = time_to_target(runs, LADDER)
    span = _span(times, runs)
    if span is None:
        return None
    pairs = {method: of.clip(lower=span[0]).to_numpy().ravel() for method, of in times.groupby(runs["method"])}
    figure = step_figure(pairs, styles(runs["method"]), span, "time [s]", "runs × targets", value="log")
    spelled = ", ".join(f"{100 * target:g}" for target in LADDER)
    caption = (
        "Share of all pairs of a run and a target that were reached by the given time; the targets are gaps of "
        f"{spelled} % to the best known or found. One line sums up how soon a method gets how good. Higher and "
        "further left is better."
    )
    return Drawn("ecdf", "Runtime distribution over all targets", caption, figure)


def _span(times: pd.DataFrame, runs: pd.DataFrame) -> tuple[float, float] | None:
    finite = times.to_numpy()[np.isfinite(times.to_numpy())]
    if not finite.size:
        return None
    end = max(float(runs["time_limit"].max()), float(finite.max()))
    return max(SOONEST, min(float(finite.min()), end / 10)), end
