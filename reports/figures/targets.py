"""Time to target, and the runtime distribution aggregated over many targets.

Time to target: the share of runs within a given gap of the best by a time (R. M. Aiex, M. G. C. Resende, C. C. Ribeiro,
TTT plots, Optim. Lett. 1 (2007) 355–366). Aggregated over runs and targets it is the ECDF of COCO (N. Hansen et al.,
COCO: a platform for comparing continuous optimizers, Optim. Methods Softw. 36 (2021) 114–144).
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.figures.chart import Axis, Chart
from reports.figures.static import drawn
from reports.figures.steps import step_panel
from reports.figures.style import SOONEST, styles
from reports.figures.svg import Drawn
from reports.metrics.targets import time_to_target

PANELS = [0.05, 0.01, 0.0]
"""Targets with a panel each: gaps to the best."""
LADDER = [0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0]
"""Targets of the aggregated distribution."""


def time_to_target_plot(runs: pd.DataFrame) -> Drawn | None:
    """Draw, for each target, the share of runs that had reached it by a time; None where none was. runs : with gaps."""
    times = time_to_target(runs, PANELS)
    span, look = _span(times, runs), styles(runs["method"])
    if span is None:
        return None
    axis = Axis("time", "s", "log", span)
    panels = [
        step_panel(
            dict(iter(times[target].clip(lower=span[0]).groupby(runs["method"]))), look, axis, "runs",
            f"within {100 * target:g} %" if target else "the best itself",
        )
        for target in PANELS
    ]  # fmt: skip
    caption = (
        "Share of runs (every instance and seed) whose routes were within 5 % and 1 % of the best known or found, "
        "or as good as it, by the given time. Higher and further left is better; a line that ends below 100 % shows "
        "runs that never got there."
    )
    return drawn("time-to-target", "Time to target", caption, Chart(panels, len(PANELS), 2.7, shared=True))


def runtime_distribution(runs: pd.DataFrame) -> Drawn | None:
    """Draw the share of (run, target) pairs reached by a time, over the ladder of targets; None where none was."""
    times = time_to_target(runs, LADDER)
    span = _span(times, runs)
    if span is None:
        return None
    pairs = {method: of.clip(lower=span[0]).to_numpy().ravel() for method, of in times.groupby(runs["method"])}
    panel = step_panel(pairs, styles(runs["method"]), Axis("time", "s", "log", span), "runs × targets")
    spelled = ", ".join(f"{100 * target:g}" for target in LADDER)
    caption = (
        "Share of all pairs of a run and a target that were reached by the given time; the targets are gaps of "
        f"{spelled} % to the best known or found. One line sums up how soon a method gets how good. Higher and "
        "further left is better."
    )
    return drawn("ecdf", "Runtime distribution over all targets", caption, Chart([panel]))


def _span(times: pd.DataFrame, runs: pd.DataFrame) -> tuple[float, float] | None:
    finite = times.to_numpy()[np.isfinite(times.to_numpy())]
    if not finite.size:
        return None
    end = max(float(runs["time_limit"].max()), float(finite.max()))
    return max(SOONEST, min(float(finite.min()), end / 10)), end
