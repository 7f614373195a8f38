"""Recreate by the clock: insert removed tasks where they raise a guide least.

All places are compared by the costs of their eras, the best two of them to first order by the clock. The places looked
at and the guides are those of `formulations.routing.search.recreate`.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.bookings import DEPARTS, ERA, KNOT, SENSE, SINCE, Bookings, Eras
from formulations.routing.clocks import Clocks
from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Measure
from formulations.routing.search.problem_data import GranularNeighbourhood, Nodes
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.recreate import RecreateParameters, growth
from formulations.routing.search.tours import Tours, link, longest
from instances.arrays import Bools, Floats
from instances.kernels import njit


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
    lines, knots, first, per_second = clocks.lines, clocks.knots, clocks.first, clocks.per_second
    classes, of_knot, scales, times, marks = (
        clocks.classes,
        eras.of_knot,
        bookings.scale,
        bookings.times,
        bookings.marks,
    )
    tour, cost, after = tours.tour, tours.cost, tours.after
    for i in range(count):
        v = queue[i]
        places = best_by_era(eras, near, tours, marks, scales, v, guide, scale, parameters, parameters.blink, rng)
        if places[0] < 0:
            places = best_by_era(eras, near, tours, marks, scales, v, guide, scale, parameters, 0.0, rng)
        best, best_u, best_change, best_time, best_q = np.inf, -1, 0.0, 0.0, 0
        for u in places:
            if u < 0:
                break
            k, w = tour[u], after[u]
            g, q, since = classes[k], marks[u, KNOT], times[u, SINCE]
            there = lines[g, u, v, q, 0] + lines[g, u, v, q, 1] * since
            straight = lines[g, u, w, q, 0] + lines[g, u, w, q, 1] * since if u != w else 0.0
            time = times[u, DEPARTS] + there
            q = first[int(min(time * per_second, first.size - 1.0))]
            while knots[q + 1] <= time:
                q += 1
            on = lines[g, v, w, q, 0] + lines[g, v, w, q, 1] * (time - knots[q])
            change = (there + on - straight) * times[w, SENSE] * scales[k]
            value = growth(cost[k] * scale, change * scale, guide, parameters.tie)
            if value < best or best_u < 0:
                best, best_u, best_change, best_time, best_q = value, u, change, time, q
        k, w = tour[best_u], after[best_u]
        link(costs, tours, v, best_u)
        marks[v, KNOT], marks[v, ERA] = best_q, of_knot[best_q]
        times[v, DEPARTS], times[v, SINCE], times[v, SENSE] = best_time, best_time - knots[best_q], times[w, SENSE]
        cost[k] += best_change
        touched[k] = True


@njit(cache=True, nogil=True)
def best_by_era(
    eras: Eras,
    near: GranularNeighbourhood,
    tours: Tours,
    marks: Nodes,
    scales: Floats,
    v: int,
    guide: Measure,
    scale: float,
    parameters: RecreateParameters,
    blink: float,
    rng: Rng,
) -> tuple[int, int]:
    """Return the best two nodes to put task v behind, by eras, −1 if none; 1 / scale [s] is the guide's unit."""
    out, into, row = eras.out, eras.into, eras.row
    tasks, depots, tour, cost, before, after = (
        near.tasks,
        near.depots,
        tours.tour,
        tours.cost,
        tours.before,
        tours.after,
    )
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
        g, u, b = row[k], node, before[node]
        e, f, w = marks[u, ERA], marks[b, ERA], after[u]
        change = into[g + v, e + u] + out[g + v, e + w] - out[g + u, e + w]
        ahead = into[g + v, f + b] + out[g + v, f + node] - out[g + b, f + node]
        if ahead < change:
            u, change = b, ahead
        value = growth(cost[k] * scale, change * scales[k] * scale, guide, parameters.tie)
        if value < best or best_u < 0:
            best, best_u, second, second_u = value, u, best, best_u
        elif value < second and u != best_u:
            second, second_u = value, u
    return best_u, second_u
