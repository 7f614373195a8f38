"""Giant tour: all tours as one ring with a copy of the depot where each begins, one behind the other in one array.

Where UAVs are alike, fly from one site and legs cost the same both ways, any ring through all tasks and depots is a set
of tours (Christofides & Eilon 1969). Edge assembly exchanges legs of such rings; moves are made in tour_blocks.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours, empty_tours, fill, sum_costs
from instances.arrays import Floats, Ints
from instances.kernels import njit


class GiantTour(NamedTuple):
    """The ring, from depot n at position 0.

    order (N+1,), N = n+m: nodes, the first again at the end; position (N,): of each node; sums (N+1,): cost from
    position 0 on [s]; starts (m+1,): positions of depots, ascending, and N; spare (N,): room.
    """

    order: Nodes
    position: Ints
    sums: Floats
    starts: Ints
    spare: Nodes


def giant_tour(costs: AlikeCosts, order: Nodes, m: int) -> GiantTour:
    """Return the ring of this order (N+1,)."""
    total = order.size - 1
    position = np.empty(total, np.int64)
    position[order[:total]] = np.arange(total)
    starts = np.append(np.sort(position[total - m :]), total)
    ring = GiantTour(order, position, np.zeros(total + 1), starts, np.empty(total, np.int32))
    add_up(costs, ring)
    return ring


def tours_of(costs: AlikeCosts, order: Nodes, m: int) -> Tours:
    """Return the tours of a ring's `order`."""
    n = order.size - 1 - m
    tours = empty_tours(n, m)
    starts = np.append(np.flatnonzero(order[:-1] >= n), n + m)
    for k in range(m):
        fill(costs, tours, k, order[starts[k] + 1 : starts[k + 1]])
    sum_costs(tours)
    return tours


@njit(cache=True, nogil=True)
def add_up(costs: AlikeCosts, ring: GiantTour) -> None:
    """Recompute the prefix sums, so that rounding of many small changes cannot gather."""
    order, sums = ring.order, ring.sums
    sums[0] = 0.0
    for i in range(order.size - 1):
        sums[i + 1] = sums[i] + leg(costs, 0, order[i], order[i + 1])


@njit(cache=True, nogil=True)
def is_between(i: int, first: int, last: int) -> bool:
    """Return whether position i is in first..last, across the ring's end where last < first."""
    return first <= i <= last if first <= last else (i >= first or i <= last)
