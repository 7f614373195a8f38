"""Performance profiles: for how many instances a method is within a factor of the best method.

    ρ_s(τ) = share of instances p with r_{p,s} ≤ τ,   r_{p,s} = t_{p,s} / min_s t_{p,s}

Source: E. D. Dolan and J. J. Moré, Benchmarking optimization software with performance profiles, Math. Program. 91
(2002) 201–213. The figure of an instance is the median over seeds, infinite where the method failed. Profiles of more
than two methods depend on who takes part (Gould & Scott, ACM TOMS 43, 2016), which the captions say.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.figures.chart import Axis, Chart
from reports.figures.static import drawn
from reports.figures.steps import step_panel
from reports.figures.style import SOONEST, Style, styles
from reports.figures.svg import Drawn
from reports.metrics.targets import time_to_proof, time_to_target
from reports.statistics.blocks import blocks


def time_profile(runs: pd.DataFrame) -> Drawn | None:
    """Draw the profile of the time until within 1 % of the best; None where no run got there. runs : with gaps."""
    measured = runs.assign(_time=time_to_target(runs, [0.01])[0.01])
    caption = (
        "Of the instances a method ran on, the share on which it was within 1 % of the best known or "
        "found in at most τ times the time of the soonest method. At τ = 1 it was the soonest; the right end is the "
        f"share it reached at all within its limit. {_READING}"
    )
    chart = _profile(measured, styles(runs["method"]), "times the soonest method's time, τ")
    return None if chart is None else drawn("profile-time", "Profile of time to 1 %", caption, chart)


def proof_profile(runs: pd.DataFrame) -> Drawn | None:
    """Draw the profile of the time until the proof of optimality, of the methods that prove; None without a proof."""
    able = runs[runs["proves"]]
    caption = (
        "Of the instances a method ran on, the share that it proved optimal in at most τ times the time of the "
        f"soonest proof; only methods that can prove take part. {_READING}"
    )
    measured = able.assign(_time=time_to_proof(able))
    chart = _profile(measured, styles(runs["method"]), "times the soonest proof's time, τ")
    return None if chart is None else drawn("profile-proof", "Profile of time to proof", caption, chart)


_READING = "Higher is better. With three methods or more, compare each with the best only."


def quality_profile(runs: pd.DataFrame) -> Drawn | None:
    """Draw the profile of the cost of the routes: share of instances within a gap of the best."""
    gaps = 100 * blocks(runs, "gap_best")
    finite = gaps.to_numpy(float)[np.isfinite(gaps.to_numpy(float))]
    if not finite.size:
        return None
    axis = Axis(
        "gap to the best known or found, at most", "%", "gap", (0.0, max(1.0, float(np.quantile(finite, 0.99))))
    )
    caption = (
        "Of the instances a method ran on, the share on which its routes (median over seeds) are within the given "
        "gap of the best known or found at the end of the run. At 0 % it found the best; what is missing to 100 % "
        "at the right end it did not solve, or worse than the scale shows. Higher is better; the scale is linear "
        "below 0.1 %."
    )
    panel = step_panel({m: gaps[m].dropna() for m in gaps}, styles(runs["method"]), axis, "instances")
    return drawn("profile-quality", "Profile of quality", caption, Chart([panel]))


def ratios(table: pd.DataFrame) -> pd.DataFrame:
    """Return r_{p,s} of a table instances × methods, for the instances somebody finished; infinite where one failed."""
    least = table.min(axis=1)
    reached = np.isfinite(least)
    found: pd.DataFrame = table[reached].div(least[reached], axis=0)
    return found


def _profile(runs: pd.DataFrame, look: dict[str, Style], label: str) -> Chart | None:
    if runs.empty:
        return None
    table = ratios(blocks(runs, "_time").clip(lower=SOONEST))
    finite = table.to_numpy(float)[np.isfinite(table.to_numpy(float))]
    if not finite.size:
        return None
    axis = Axis(label, scale="log", span=(1.0, max(2.0, float(finite.max()) * 1.2)))
    return Chart([step_panel({m: table[m].dropna() for m in table}, look, axis, "instances")])
