"""Recreate by the clock: insert removed tasks where they raise a guide least.

All places are compared by the costs of their eras, the best two of them to first order by the clock. The places looked
at and the guides are those of `formulations.routing.search.recreate`.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.bookings import ERA, Bookings, Eras, insertion_change, note
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
) -> tuple[int, float]:
    """Return (node to put task v behind, change of that tour's cost [s]); the node is −1 where all was overlooked.

    1 / scale [s] is the guide's unit.
    """
    tasks, depots, tour, cost, before, after = (
        near.tasks,
        near.depots,
        tours.tour,
        tours.cost,
        tours.before,
        tours.after,
    )
    out, into, marks, classes = eras.out, eras.into, bookings.marks, clocks.classes
    scales = bookings.scale
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
        e, f, w = marks[u, ERA], marks[b, ERA], after[u]
        change = into[g, v, e, u] + out[g, v, e, w] - out[g, u, e, w]
        ahead = into[g, v, f, b] + out[g, v, f, node] - out[g, b, f, node]
        if ahead < change:
            u, change = b, ahead
        value = growth(cost[k] * scale, change * scales[k] * scale, guide, parameters.tie)
        if value < best or best_u < 0:
            best, best_u, second, second_u = value, u, best, best_u
        elif value < second and u != best_u:
            second, second_u = value, u
    change = insertion_change(clocks, tours, bookings, v, best_u) if best_u >= 0 else 0.0
    if second_u < 0 or second_u == best_u:
        return best_u, change
    other, tie = insertion_change(clocks, tours, bookings, v, second_u), parameters.tie
    best = growth(cost[tour[best_u]] * scale, change * scale, guide, tie)
    second = growth(cost[tour[second_u]] * scale, other * scale, guide, tie)
    return (best_u, change) if best <= second else (second_u, other)


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
    """Insert queue[:count] into the tours, in that order; their costs are nearly right then.

    touched : marks the tours that took some.
    """
    unit = longest(tours.cost)
    scale = 1.0 / unit if unit > 0.0 else 1.0
    for i in range(count):
        v = queue[i]
        u, change = best_insertion(
            clocks, eras, near, tours, bookings, v, guide, scale, parameters, parameters.blink, rng
        )
        if u < 0:
            u, change = best_insertion(clocks, eras, near, tours, bookings, v, guide, scale, parameters, 0.0, rng)
        k = tours.tour[u]
        link(costs, tours, v, u)
        note(clocks, eras, tours, bookings, v)
        tours.cost[k] += change
        touched[k] = True
