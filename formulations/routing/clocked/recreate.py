"""Recreate by the clock: insert removed tasks where they raise a guide least.

All places are compared by the costs of their eras and the guide's growth to second order, the best two of them by the
guide itself and to first order by the clock. A change c of a tour's length L raises the guide by

    (L + c)^p − L^p ≈ c · (p L^(p−1) + c · p (p−1)/2 L^(p−2)),        or max(0, L + c − cap) − max(0, L − cap) + τ c,

so that three numbers of every tour, worked out once a step and wherever a task is put, do for all places on it.
The places looked at and the guides are those of `formulations.routing.search.recreate`.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.bookings import DEPARTS, ERA, KNOT, SENSE, SINCE, Bookings, Eras, insertion
from formulations.routing.clocks import Clocks
from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Measure, MeasureKind, power
from formulations.routing.search.problem_data import GranularNeighbourhood, Nodes
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.recreate import RecreateParameters, growth
from formulations.routing.search.tours import Tours, link, longest
from instances.arrays import Bools
from instances.kernels import njit

LINEAR, SQUARE, BEND, BEYOND = range(4)
"""Columns of the growth of a guide: c · (LINEAR + c · SQUARE) + BEYOND · max(0, c − BEND)."""


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
    scale, tie = 1.0 / unit if unit > 0.0 else 1.0, parameters.tie
    tour, cost, times, marks = tours.tour, tours.cost, bookings.times, bookings.marks
    for k in range(cost.size):
        expand(guide, cost[k], scale, tie, bookings, k)
    for i in range(count):
        v = queue[i]
        places = best_by_era(eras, near, tours, bookings, v, parameters, parameters.blink, rng)
        if places[0] < 0:
            places = best_by_era(eras, near, tours, bookings, v, parameters, 0.0, rng)
        best, best_u, best_change, best_time, best_q = np.inf, -1, 0.0, 0.0, 0
        for u in places:
            if u < 0:
                break
            change, time, q = insertion(clocks, tours, bookings, v, u)
            value = growth(cost[tour[u]] * scale, change * scale, guide, tie)
            if value < best or best_u < 0:
                best, best_u, best_change, best_time, best_q = value, u, change, time, q
        k, w = tour[best_u], tours.after[best_u]
        link(costs, tours, v, best_u)
        marks[v, KNOT], marks[v, ERA] = best_q, eras.of_knot[best_q]
        times[v, DEPARTS], times[v, SINCE] = best_time, best_time - clocks.knots[best_q]
        times[v, SENSE] = times[w, SENSE]
        cost[k] += best_change
        expand(guide, cost[k], scale, tie, bookings, k)
        touched[k] = True


@njit(cache=True, nogil=True)
def expand(guide: Measure, cost: float, scale: float, tie: float, bookings: Bookings, k: int) -> None:
    """Book how the guide grows with a change [s] of tour k, which takes `cost` [s]; 1 / scale [s] is its unit."""
    length, row, unit = cost * scale, bookings.growth, bookings.scale[k] * scale
    row[k, SQUARE], row[k, BEND], row[k, BEYOND] = 0.0, np.inf, unit
    if guide.kind == MeasureKind.EXCESS:
        row[k, LINEAR] = unit * (tie if length < guide.cap else 1.0 + tie)
        if length < guide.cap:
            row[k, BEND] = (guide.cap - length) / unit
    elif guide.p == 1:
        row[k, LINEAR] = unit
    else:
        slope = guide.p * power(length, guide.p - 2) * unit
        row[k, LINEAR], row[k, SQUARE] = slope * length, slope * 0.5 * (guide.p - 1) * unit


@njit(cache=True, nogil=True)
def best_by_era(
    eras: Eras,
    near: GranularNeighbourhood,
    tours: Tours,
    bookings: Bookings,
    v: int,
    parameters: RecreateParameters,
    blink: float,
    rng: Rng,
) -> tuple[int, int]:
    """Return the best two nodes to put task v behind, by eras, −1 if none.

    Node numbers are made unsigned: of signed ones numba asks at each access whether they count from an array's end,
    which took an eighth of the steps' time.
    """
    out, into, row, marks, rise = eras.out, eras.into, eras.row, bookings.marks, bookings.growth
    tasks, depots, tour, before, after = near.tasks, near.depots, tours.tour, tours.before, tours.after
    n_depots, nearest = depots.shape[1], parameters.depots
    n_tasks_seen = min(parameters.width, tasks.shape[1])
    n_seen = n_tasks_seen + min(2 * nearest, n_depots)
    overlooked = below(rng, int(n_seen / blink)) if blink > 0.0 else -1
    best, best_u, second, second_u, task = np.inf, -1, np.inf, -1, np.uint32(v)
    for j in range(n_seen):
        if j < n_tasks_seen:
            node = np.uint32(tasks[task, j])
        elif j < n_tasks_seen + nearest or n_depots <= 2 * nearest:
            node = np.uint32(depots[task, j - n_tasks_seen])
        else:
            node = np.uint32(depots[task, nearest + below(rng, n_depots - nearest)])
        k = tour[node]
        if k < 0 or j == overlooked:
            continue
        g, b, w = np.uint32(row[k]), np.uint32(before[node]), np.uint32(after[node])
        e, f = np.uint32(marks[node, ERA]), np.uint32(marks[b, ERA])
        u, change = int(node), into[g + task, e + node] + out[g + task, e + w] - out[g + node, e + w]
        ahead = into[g + task, f + b] + out[g + task, f + node] - out[g + b, f + node]
        if ahead < change:
            u, change = int(b), ahead
        value = change * (rise[k, LINEAR] + change * rise[k, SQUARE])
        value += max(change - rise[k, BEND], 0.0) * rise[k, BEYOND]
        if value < best or best_u < 0:
            best, best_u, second, second_u = value, u, best, best_u
        elif value < second and u != best_u:
            second, second_u = value, u
    return best_u, second_u
