"""Legs minimised over time windows: an instance without a clock none of whose routes take longer than by the clock.

Routes shorter than known ones, of longest tour U, leave little time: UAV k is at i not before the earliest arrival
e_k(i) from its depot, and leaves for j so that, however quick the rest, it is home by U. With w_k(j) the least way home

    c_kij = min { c_ij(t) : e_k(i) ≤ t ≤ U − w_k(j) − least c_ij },   at most U where that leaves no time

which is a fleet of UAVs that differ in their windows only. Every lower bound on its optimum, cut off at U, is one on
the optimum by the clock. With these legs ways home are longer and windows narrower, so it is done again a few times.
The least over all t alone is weak: in 10 m/s that turn 90° an hour 4 to 29 % below optima at 20 m/s, 0.6 % at 100.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.simple_bounds import ways_between_tasks, ways_from_depot
from instances import Instance, Travel
from instances.arrays import Floats

ROUNDS = 3
"""How often windows are narrowed."""
_DOWN, _UP = 1 - 2.0**-40, 1 + 2.0**-30
"""What costs are lowered by for rounding, and what time is lent: routes that take just U are no longer."""


def windowed(instance: Instance, upper: float) -> Instance:
    """Return the instance whose legs cost the least they can on routes of a longest tour ≤ `upper` [s]."""
    travel = instance.travel
    assert travel is not None
    costs = []
    for k, g in enumerate(travel.classes):
        courses = np.minimum(travel.cost[g], upper)
        earliest = _earliest(courses, travel.departures, instance.n_tasks, k)
        latest = np.full(courses.shape[1:], upper)
        for _ in range(ROUNDS):
            latest[instance.n_tasks + k] = np.minimum(latest[instance.n_tasks + k], 0.0)  # it takes off at once
            cost = _least(courses, travel.departures, earliest, latest, upper)
            latest = upper * _UP - cost - _ways_home(cost, instance.n_tasks, k)[None, :]
        costs.append(cost * _DOWN)
    more = {"coordinates": instance.coordinates, "endurance": instance.endurance}
    return Instance.of_travel(instance.name, Travel.of_uavs(costs), instance.n_tasks, **more)


def _earliest(courses: Floats, knots: Floats, n_tasks: int, k: int) -> Floats:
    """Return when UAV k can be at each node first [s], (N,), by Dijkstra's method, exact as later is never earlier."""
    n_nodes, depot = courses.shape[1], n_tasks + k
    arrival, left = np.full(n_nodes, np.inf), np.ones(n_nodes, dtype=bool)
    arrival[depot] = 0.0
    left[n_tasks:] = False
    left[depot] = True
    while left.any():
        i = int(np.flatnonzero(left)[arrival[left].argmin()])
        left[i] = False
        there = arrival[i] + _at(courses[:, i], knots, float(arrival[i]))
        arrival[left] = np.minimum(arrival[left], there[left])
    return arrival


def _ways_home(cost: Floats, n_tasks: int, k: int) -> Floats:
    """Return the least way home of UAV k from each node [s], (N,): over tasks, 0 from its depot."""
    home = np.zeros(len(cost))
    home[:n_tasks] = ways_from_depot(cost, ways_between_tasks(cost, n_tasks), n_tasks + k)[1]
    return home


def _at(courses: Floats, knots: Floats, time: float) -> Floats:
    """Return costs of legs that begin at `time`, of `courses` (Q, …) at `knots` (Q,)."""
    q = int(np.searchsorted(knots, time, side="right")) - 1
    if q + 1 == len(knots):
        return courses[-1]
    share = (time - knots[q]) / (knots[q + 1] - knots[q])
    return (1 - share) * courses[q] + share * courses[q + 1]


def _least(courses: Floats, knots: Floats, earliest: Floats, latest: Floats, upper: float) -> Floats:
    """Return the least cost (N, N) [s] of legs that begin between earliest (N,) and latest (N, N), else `upper`."""
    first = np.broadcast_to(earliest[:, None], latest.shape)
    least = np.minimum(_ends(courses, knots, first), _ends(courses, knots, latest))
    for knot, cost in zip(knots, courses, strict=True):
        inside = (first <= knot) & (knot <= latest)
        least[inside] = np.minimum(least, cost)[inside]
    least = np.where(first > latest, upper, least)
    np.fill_diagonal(least, 0.0)
    return least


def _ends(courses: Floats, knots: Floats, times: Floats) -> Floats:
    """Return the cost (N, N) [s] of each leg at its own time (N, N); costs are cut off, and so never infinite."""
    times = np.maximum(times, 0.0)
    q = np.minimum(np.searchsorted(knots, times, side="right") - 1, len(knots) - 1)
    after = np.minimum(q + 1, len(knots) - 1)
    span = np.where(after > q, knots[after] - knots[q], 1.0)
    share = np.clip((times - knots[q]) / span, 0.0, 1.0) * (after > q)
    i, j = np.indices(times.shape)
    return (1 - share) * courses[q, i, j] + share * courses[after, i, j]
