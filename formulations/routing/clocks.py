"""Costs that change with time as kernels read them: between two knots a leg's cost is a line, kept side by side.

    c(t) = value_q + slope_q · (t − t_q)   from knot t_q to the next, constant after the last (`instances.Travel`)

The knot of a time is found in one step where knots are evenly spread, in few where they are not: `first` says which
knot each of many short intervals begins behind.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from instances import Instance, Travel
from instances.arrays import Floats, Ints
from instances.kernels import njit

MOST_INTERVALS = 8192
"""Intervals of the index of knots, at most."""


class Clocks(NamedTuple):
    """Costs by departure.

    lines (G, N, N, Q, 2): value [s] and slope of c(t) behind each knot, for each class, from node to node; knots (Q+1,)
    [s], the last +∞; first (B,): the last knot not behind the beginning of each interval; per_second: intervals in a
    second; classes (m,): the class of each UAV.
    """

    lines: Floats
    knots: Floats
    first: NDArray[np.int32]
    per_second: float
    classes: Ints


def clocks_of(instance: Instance) -> Clocks:
    """Return the clocks of an instance; ValueError where its nodes have several states."""
    travel = instance.travel
    if travel is None:
        travel = Travel(instance.cost[None, None], np.zeros(instance.n_depots, dtype=np.int64))
    if "states" in travel.axes:
        raise ValueError(f"instance {instance.name}: costs depend on the states of nodes")
    return clocks_at(travel.cost, travel.departures, travel.classes)


def clocks_at(cost: Floats, knots: Floats, classes: Ints) -> Clocks:
    """Return the clocks of costs (G, Q, N, N) [s] at `knots` (Q,) [s] for UAVs of `classes` (m,)."""
    return Clocks(lines_of(cost, knots), np.append(knots, np.inf), *_index(knots), classes)


def lines_of(cost: Floats, knots: Floats) -> Floats:
    """Return value and slope behind each knot, (G, N, N, Q, 2), of costs (G, Q, N, N) [s] at `knots` (Q,) [s]."""
    lines = np.zeros((*cost.shape[:1], *cost.shape[2:], len(knots), 2))
    lines[..., 0] = cost.transpose(0, 2, 3, 1)
    if len(knots) > 1:
        with np.errstate(invalid="ignore"):
            slopes = np.diff(lines[..., 0], axis=-1) / np.diff(knots)
        lines[..., :-1, 1] = np.where(np.isnan(slopes), 0.0, slopes)  # never flown: +∞ at both knots
    lines.setflags(write=False)
    return lines


def _index(knots: Floats) -> tuple[NDArray[np.int32], float]:
    if len(knots) == 1:
        return np.zeros(1, np.int32), 0.0
    count = int(min(MOST_INTERVALS, np.ceil(knots[-1] / np.diff(knots).min()) + 1))
    per_second = (count - 1) / float(knots[-1])
    begins = np.arange(count) / per_second * (1 - 1e-12)  # rounded down: `knot_at` looks further on, not back
    first = np.maximum(np.searchsorted(knots, begins, side="right") - 1, 0)
    return first.astype(np.int32), per_second


@njit(cache=True, nogil=True)
def knot_at(clocks: Clocks, time: float) -> int:
    """Return the number of the last knot that is not after `time` ≥ 0 [s], finite."""
    q = clocks.first[int(min(time * clocks.per_second, clocks.first.size - 1.0))]
    while clocks.knots[q + 1] <= time:
        q += 1
    return q


@njit(cache=True, nogil=True)
def leg_at(clocks: Clocks, g: int, i: int, j: int, time: float) -> float:
    """Return what class g takes [s] from node i to node j, departing at `time` [s]; +inf where either is infinite."""
    if time == np.inf:
        return np.inf
    q = knot_at(clocks, time)
    since = time - clocks.knots[q]
    if since <= 0.0:
        return clocks.lines[g, i, j, q, 0]
    return clocks.lines[g, i, j, q, 0] + clocks.lines[g, i, j, q, 1] * since


@njit(cache=True, nogil=True)
def arrival_home(clocks: Clocks, k: int, n_tasks: int, order: Ints) -> float:
    """Return C_k [s] of UAV k on `order`, its tasks in flying order."""
    g, here, time = clocks.classes[k], n_tasks + k, 0.0
    for there in order:
        time += leg_at(clocks, g, here, there, time)
        here = there
    return time + leg_at(clocks, g, here, n_tasks + k, time) if order.size else 0.0
