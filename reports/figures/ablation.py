"""Ablation: what each option of a solver is worth, against the same solver with its defaults, instance by instance.

For each variant and instance: the ratio of the time to the proof (a run without one counts twice its limit) and the
difference of the gap between its own routes and bound. The figure shows the mean over instances (of the ratio the
geometric mean) with its bootstrap interval.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from reports.figures.chart import Axis, Chart, Panel, Rule, Series
from reports.figures.static import drawn
from reports.figures.style import Style, styles
from reports.figures.svg import Drawn
from reports.metrics.means import SHIFT, penalised
from reports.metrics.targets import time_to_proof
from reports.statistics import bootstrap_interval

_FACTORS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)


class Worth(NamedTuple):
    """What a variant is worth: means with the ends of their intervals, over `instances` both ran on."""

    method: str
    instances: int
    ratio: tuple[float, float, float]
    gap: tuple[float, float, float]
    proved: float


def worth(runs: pd.DataFrame, solver: str) -> list[Worth]:
    """Return what each variant of `solver` is worth against its defaults, the default itself first.

    ratio : time to proof over the default's (above 1: slower). gap : own gap minus the default's. proved : share of
    runs.
    """
    own = runs[runs["solver"] == solver]
    times = penalised(time_to_proof(own), own["time_limit"]) + SHIFT
    table = times.groupby([own["digest"], own["method"]]).median().unstack()
    gaps = own["gap"].clip(lower=0).fillna(1.0).groupby([own["digest"], own["method"]]).median().unstack()
    shares = own.groupby("method")["proved"].mean()
    default = str(own.loc[own["options"] == "{}", "method"].iloc[0])
    found = []
    for method in [default, *sorted(str(m) for m in table if m != default)]:
        both = table[[default, method]].dropna().index if method != default else table[default].dropna().index
        ratio = np.log((table.loc[both, method] / table.loc[both, default]).to_numpy(float))
        gap = (gaps.loc[both, method] - gaps.loc[both, default]).to_numpy(float)
        r_low, r_high = bootstrap_interval(ratio)
        factors = float(np.exp(ratio.mean())), float(np.exp(r_low)), float(np.exp(r_high))
        found.append(Worth(method, len(both), factors, (float(gap.mean()), *bootstrap_interval(gap)), shares[method]))
    return found


def ablated_solvers(runs: pd.DataFrame) -> list[str]:
    """Return the solvers that prove and were run with their defaults and with other options at the same limits."""
    able = runs[runs["proves"]]
    variants = able.groupby("solver")["options"].agg(lambda options: len(set(options)) > 1 and "{}" in set(options))
    return [str(solver) for solver in variants.index[variants.to_numpy(bool)]]


def ablation(runs: pd.DataFrame, solver: str) -> Drawn:
    """Draw what each variant of `solver` is worth in time to proof and in gap."""
    rows = worth(runs, solver)
    look = styles(runs["method"])
    names = Axis("variant", names=[f"{_variant(r.method, solver)}   ({100 * r.proved:.0f} % proved)" for r in rows])
    factors = np.array([r.ratio for r in rows])
    low, high = min(0.45, 0.9 * factors.min()), max(2.2, 1.1 * factors.max())
    ticks = [t for t in _FACTORS if low <= t <= high]
    panels = [
        _panel(Axis("time to proof, times the default's", scale="log", span=(low, high), ticks=ticks), names, 1.0,
               [(r.method, look[r.method], r.ratio) for r in rows]),
        _panel(Axis("gap minus the default's", "% points"), names, 0.0,
               [(r.method, look[r.method], (100 * r.gap[0], 100 * r.gap[1], 100 * r.gap[2])) for r in rows]),
    ]  # fmt: skip
    caption = (
        f"What each option of {solver} is worth: every variant against the same solver with its defaults, over the "
        f"instances both ran on ({min(r.instances for r in rows)} at least). Left: geometric mean of the ratio of "
        "times to proof (a run without one counts twice its limit); right of 1 is slower. Right: mean difference of "
        "the gap between own routes and bound. Bars are 95 % bootstrap intervals; one that crosses the line shows "
        "no effect."
    )
    chart = Chart(panels, 2, 0.85 + 0.3 * len(rows))
    return drawn(f"ablation-{solver}", f"What strengthening {solver} is worth", caption, chart)


def _variant(method: str, solver: str) -> str:
    return "defaults" if method == solver else method.removeprefix(f"{solver} ").strip("()")


def _panel(x: Axis, names: Axis, default: float, rows: list[tuple[str, Style, tuple[float, float, float]]]) -> Panel:
    """Return a dot a row with its interval, about the default's value."""
    series = [
        Series(name, [mean], [i], look, "points", [low], [high], "across", size=6)
        for i, (name, look, (mean, low, high)) in enumerate(rows)
    ]
    return Panel(x, names, series, rules=[Rule("x", default)])
