"""Recreate by the clock: insert removed tasks where they raise a guide least, and book exactly.

All places are compared by the costs of their eras, the best two of them to first order by the clock. The places looked
at and the guides are those of `formulations.routing.search.recreate`.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.bookings import ERA, LEG, Bookings, Eras, book, insertion_change
from formulations.routing.clocks import Clocks
from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Measure
from formulations.routing.search.problem_data import GranularNeighbourhood, Nodes
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.recreate import RecreateParameters, growth
from formulations.routing.search.tours import Tours, link, longest
from instances.arrays import Bools
from instances.kernels import njit


@njit(cache=True, nogil=True)
def best_insertion(
    clocks: Clocks,
    eras: Eras,
    near: GranularNeighbourhood,
    tours: Tours,
    bookings: Bookings,
    v: int,
    guide: Measure,
    scale: float,
    parameters: RecreateParameters,
    blink: float,
    rng: Rng,
) -> int:
    """Return the node to put task v behind, or −1 where all was overlooked; 1 / scale [s] is the guide's unit."""
    tasks, depots, tour, cost, before, after = (
        near.tasks,
        near.depots,
        tours.tour,
        tours.cost,
        tours.before,
        tours.after,
    )
    out, into, times, marks, classes = eras.out, eras.into, bookings.times, bookings.marks, clocks.classes
    n_depots, nearest = depots.shape[1], parameters.depots
    n_tasks_seen = min(parameters.width, tasks.shape[1])
    n_seen = n_tasks_seen + min(2 * nearest, n_depots)
    overlooked = below(rng, int(n_seen / blink)) if blink > 0.0 else -1
    best, best_u, second, second_u = np.inf, -1, np.inf, -1
    for j in range(n_seen):
        if j < n_tasks_seen:
            node = tasks[v, j]
        elif j < n_tasks_seen + nearest or n_depots <= 2 * nearest:
            node = depots[v, j - n_tasks_seen]
        else:
            node = depots[v, nearest + below(rng, n_depots - nearest)]
        k = tour[node]
        if k < 0 or j == overlooked:
            continue
        g, u, b = classes[k], node, before[node]
        change = into[g, v, marks[u, ERA], u] + out[g, v, marks[u, ERA], after[u]] - times[u, LEG]
        ahead = into[g, v, marks[b, ERA], b] + out[g, v, marks[b, ERA], node] - times[b, LEG]
        if ahead < change:
            u, change = b, ahead
        value = growth(cost[k] * scale, change * bookings.scale[k] * scale, guide, parameters.tie)
        if value < best or best_u < 0:
            best, best_u, second, second_u = value, u, best, best_u
        elif value < second and u != best_u:
            second, second_u = value, u
    if second_u < 0 or second_u == best_u:
        return best_u
    best = _growth_at(clocks, tours, bookings, v, best_u, guide, scale, parameters.tie)
    return (
        best_u if best <= _growth_at(clocks, tours, bookings, v, second_u, guide, scale, parameters.tie) else second_u
    )


@njit(cache=True, nogil=True)
def _growth_at(
    clocks: Clocks, tours: Tours, bookings: Bookings, v: int, u: int, guide: Measure, scale: float, tie: float
) -> float:
    """Return the guide's growth, to first order, where task v is put behind node u."""
    length, change = tours.cost[tours.tour[u]], insertion_change(clocks, tours, bookings, v, u)
    return growth(length * scale, change * scale, guide, tie)


@njit(cache=True, nogil=True)
def recreate(
    clocks: Clocks,
    eras: Eras,
    costs: Costs,
    near: GranularNeighbourhood,
    tours: Tours,
    bookings: Bookings,
    queue: Nodes,
    count: int,
    guide: Measure,
    parameters: RecreateParameters,
    rng: Rng,
    touched: Bools,
) -> None:
    """Insert queue[:count] into the tours, in that order; `touched` marks the tours that took some."""
    unit = longest(tours.cost)
    scale = 1.0 / unit if unit > 0.0 else 1.0
    for i in range(count):
        v = queue[i]
        u = best_insertion(clocks, eras, near, tours, bookings, v, guide, scale, parameters, parameters.blink, rng)
        if u < 0:
            u = best_insertion(clocks, eras, near, tours, bookings, v, guide, scale, parameters, 0.0, rng)
        k = tours.tour[u]
        link(costs, tours, v, u)
        book(clocks, eras, tours, bookings, k, u)
        touched[k] = True
