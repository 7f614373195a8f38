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
from instances.arrays import Bools, Ints
from instances.kernels import njit


@njit(cache=True, nogil=True)
def best_by_era(
    classes: Ints,
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
) -> tuple[int, int]:
    """Return the best two nodes to put task v behind, by eras, −1 if none; 1 / scale [s] is the guide's unit."""
    tasks, depots, tour, cost, before, after = (
        near.tasks,
        near.depots,
        tours.tour,
        tours.cost,
        tours.before,
        tours.after,
    )
    out, into, marks, scales = eras.out, eras.into, bookings.marks, bookings.scale
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
    return best_u, second_u


@njit(cache=True, nogil=True)
def better_by_clock(
    clocks: Clocks,
    tours: Tours,
    bookings: Bookings,
    v: int,
    places: tuple[int, int],
    guide: Measure,
    scale: float,
    tie: float,
) -> tuple[int, float]:
    """Return the better of two nodes to put task v behind, to first order, and the change of its tour's cost [s]."""
    one, two = places
    change = insertion_change(clocks, tours, bookings, v, one)
    if two < 0 or one == two:
        return one, change
    other = insertion_change(clocks, tours, bookings, v, two)
    first = growth(tours.cost[tours.tour[one]] * scale, change * scale, guide, tie)
    second = growth(tours.cost[tours.tour[two]] * scale, other * scale, guide, tie)
    return (one, change) if first <= second else (two, other)


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
    unit, classes = longest(tours.cost), clocks.classes
    scale = 1.0 / unit if unit > 0.0 else 1.0
    for i in range(count):
        v = queue[i]
        found = best_by_era(classes, eras, near, tours, bookings, v, guide, scale, parameters, parameters.blink, rng)
        if found[0] < 0:
            found = best_by_era(classes, eras, near, tours, bookings, v, guide, scale, parameters, 0.0, rng)
        u, change = better_by_clock(clocks, tours, bookings, v, found, guide, scale, parameters.tie)
        k = tours.tour[u]
        link(costs, tours, v, u)
        note(clocks, eras, tours, bookings, v)
        tours.cost[k] += change
        touched[k] = True
