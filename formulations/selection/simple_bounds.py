"""Simple bounds on what can be selected: what is within reach, and a knapsack of time. Milliseconds at any size.

A tour of cost C over the tasks S pays, for each of them, at least half its cheapest leg in and half its cheapest leg
out: with w_i = ½ (min_j c_ji + min_j c_ij) over all UAVs and legs that fit, Σ_{i∈S} w_i ≤ C. Hence, all tours together,

    Σ_{i selected} w_i ≤ Σ_k L_k,

and with prizes the fractional knapsack is a bound. Information is bounded by modular functions (`overestimates.py`).
"""

from __future__ import annotations

import numpy as np

from formulations.selection.fleet import Group, groups_of
from formulations.selection.overestimates import first_overestimates
from formulations.selection.selection import SelectionProblem
from instances.arrays import Bools, Floats

_MARGIN = 1 + 1e-9
"""Far more than the rounding of these sums."""


def simple_bound(problem: SelectionProblem) -> float:
    """Return an upper bound on the worth of every selection, valid in floating point."""
    groups = groups_of(problem.instance)
    reachable = np.logical_or.reduce([group.within() for group in groups])
    time = sum(len(group.uavs) * group.cap for group in groups) * _MARGIN
    weight = _shares(groups, reachable)
    within = problem.worth.value(np.flatnonzero(reachable).tolist())
    bounds = (
        over.constant + _knapsack(np.where(reachable, over.slope, 0.0), weight, time)
        for over in first_overestimates(problem.worth, reachable)
    )
    return max(0.0, min(within, *bounds)) * _MARGIN + 2 * problem.worth.rounding


def _shares(groups: list[Group], reachable: Bools) -> Floats:
    """Return w_i [s] of each task that is within reach, 0 for others, (n,)."""
    into = np.minimum.reduce([np.minimum(g.legs.out, g.legs.between.min(axis=0)) for g in groups])
    away = np.minimum.reduce([np.minimum(g.legs.home, g.legs.between.min(axis=1)) for g in groups])
    return np.where(reachable, 0.5 * (np.where(reachable, into, 0.0) + np.where(reachable, away, 0.0)), 0.0)


def _knapsack(profit: Floats, weight: Floats, room: float) -> float:
    """Return the value of the fractional knapsack; items of no profit are left out."""
    items = np.flatnonzero(profit > 0)
    with np.errstate(divide="ignore"):
        order = items[np.argsort(-(profit[items] / weight[items]), kind="stable")]
    taken = np.cumsum(weight[order])
    whole = taken <= room
    total = float(profit[order][whole].sum())
    broken = order[~whole][:1]
    before = float(weight[order][whole].sum())
    return total + sum(float(profit[i] * (room - before) / weight[i]) for i in broken)
