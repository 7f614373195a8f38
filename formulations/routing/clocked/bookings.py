"""Bookings: when tours reach their nodes, and how much later they are home for each second that they are late there.

    A_p                      arrival at the p-th node of a tour, exact
    S_p = Π (1 + c'_ij)      sensitivity ∂C_k/∂A_p: the product over the legs behind it, c' at their departures

so that putting v between u and w makes the tour longer by about (A'_w − A_w)·S_w: three legs looked up, whatever the
tour's length. That is asked of few places: the others are ruled out by the costs of their era, one of few in which
time is cut, at whose middle they are known without a clock. While tasks are taken out and put in again bookings of what
lies behind are a little old; tours are flown exactly, leg by leg, where they may be kept, and booked anew then.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.clocked.waiting import LIMIT, wait
from formulations.routing.clocks import Clocks, knot_at
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours
from instances.arrays import Floats
from instances.kernels import njit

ERAS = 8
"""Eras at most."""


class Eras(NamedTuple):
    """Costs [s] at the middle of each of few eras, in tables that are cheap to index.

    out[g·N + v, e·N + w], into[g·N + v, e·N + u] : to w from v and to v from u; row (m,) : g·N of each UAV; of_knot :
    e·N of each knot.
    """

    out: NDArray[np.float32]
    into: NDArray[np.float32]
    row: Nodes
    of_knot: Nodes


class Bookings(NamedTuple):
    """Of every node; a depot is departed from at 0, or when its UAV has waited. Few arrays: each costs to pass.

    times (n+m, 4): columns DEPARTS [s]; SENSE, S; SINCE, the time between the knot before and the departure [s]; RISE,
    1 + c' of the leg flown from the node. marks (n+m, 2): KNOT before and ERA of its departure. scale (m,): what the
    time of each UAV is multiplied by, for its endurance; waits (m, 3): who may wait before take-off (`Waits.table`);
    growth (m, 4): room for what `recreate` needs of tours.
    """

    times: Floats
    marks: Nodes
    scale: Floats
    waits: Floats
    growth: Floats


DEPARTS, SENSE, SINCE, RISE = range(4)
KNOT, ERA = range(2)


def empty_bookings(n_nodes: int, scale: Floats, waits: Floats) -> Bookings:
    """Return bookings of empty tours."""
    times = np.zeros((n_nodes, 4))
    times[:, [SENSE, RISE]] = 1.0
    return Bookings(times, np.zeros((n_nodes, 2), np.int32), scale, waits, np.zeros((scale.size, 4)))


def eras_of(clocks: Clocks, horizon: float) -> Eras:
    """Return the eras of clocks, as many as `ERAS` at most up to `horizon` [s]."""
    knots = clocks.knots[:-1]
    last = max(1, int(np.searchsorted(knots, horizon)))
    of_knot = np.minimum(np.arange(len(knots)) * min(ERAS, last) // last, min(ERAS, last) - 1).astype(np.int32)
    middles = [float(knots[of_knot == e][:2].mean()) for e in range(of_knot.max() + 1)]
    n = clocks.lines.shape[1]
    out, into = (
        np.stack([_at(clocks, time).transpose(axes) for time in middles], axis=2).reshape(-1, len(middles) * n)
        for axes in ((0, 1, 2), (0, 2, 1))
    )
    return Eras(
        out.astype(np.float32), into.astype(np.float32), (clocks.classes * n).astype(np.int32), of_knot * np.int32(n)
    )


def _at(clocks: Clocks, time: float) -> Floats:
    """Return the costs (G, N, N) [s] of legs that begin at `time` [s]."""
    q = int(np.searchsorted(clocks.knots, time, side="right")) - 1
    costs: Floats = clocks.lines[..., q, 0] + clocks.lines[..., q, 1] * (time - clocks.knots[q])
    return costs


@njit(cache=True, nogil=True)
def book_tour(clocks: Clocks, eras: Eras, tours: Tours, bookings: Bookings, k: int) -> None:
    """Fly tour k by the clock: book its nodes and its cost."""
    lines, knots, of_knot = clocks.lines, clocks.knots, eras.of_knot  # once: in a loop references are counted
    after, before, times, marks = tours.after, tours.before, bookings.times, bookings.marks
    depot = after.size - tours.cost.size + k
    g, u, time, begins, product, waits = clocks.classes[k], depot, 0.0, 0.0, 1.0, False
    while after[depot] != depot:
        w, q = after[u], marks[u, KNOT]  # most often still the knot, which the processor need not wait for
        if time < knots[q] or time >= knots[q + 1]:
            q = knot_at(clocks, time)
        since, slope = time - knots[q], lines[g, u, w, q, 1]
        marks[u, KNOT], marks[u, ERA] = q, of_knot[q]
        times[u, DEPARTS], times[u, SINCE], times[u, RISE] = time, since, 1.0 + slope
        time += lines[g, u, w, q, 0] + slope * since
        u = w
        if u == depot:
            if waits or time <= bookings.waits[k, LIMIT]:
                break
            begins, tours.cost[k], product = _wait(clocks, tours, bookings, k)
            waits, time = True, begins
    if not waits:
        tours.cost[k] = time * bookings.scale[k]
    times[depot, SENSE], u = product, before[depot]
    while u != depot:
        product *= times[u, RISE]
        times[u, SENSE] = product
        u = before[u]


@njit(cache=True, nogil=True)
def fly_tour(clocks: Clocks, tours: Tours, bookings: Bookings, k: int) -> None:
    """Set the cost of tour k to what it takes by the clock, and book nothing else."""
    lines, knots, after, marks = clocks.lines, clocks.knots, tours.after, bookings.marks
    depot = after.size - tours.cost.size + k
    g, u, time = clocks.classes[k], depot, 0.0
    while after[depot] != depot:
        w, q = after[u], marks[u, KNOT]
        if time < knots[q] or time >= knots[q + 1]:
            q = knot_at(clocks, time)
        time += lines[g, u, w, q, 0] + lines[g, u, w, q, 1] * (time - knots[q])
        u = w
        if u == depot:
            break
    tours.cost[k] = time * bookings.scale[k]
    if time > bookings.waits[k, LIMIT]:
        tours.cost[k] = _wait(clocks, tours, bookings, k)[1]


@njit(cache=True, nogil=True)
def _wait(clocks: Clocks, tours: Tours, bookings: Bookings, k: int) -> tuple[float, float, float]:
    """Return what `wait` does of tour k."""
    stops, u = np.empty(tours.size[k] + 2, np.int64), tours.after.size - tours.cost.size + k
    for i in range(stops.size):
        stops[i] = u
        u = tours.after[u]
    return wait(clocks, clocks.classes[k], stops, bookings.waits[k])


@njit(cache=True, nogil=True)
def book_all(clocks: Clocks, eras: Eras, tours: Tours, bookings: Bookings) -> None:
    """Fly all tours by the clock."""
    for k in range(tours.cost.size):
        book_tour(clocks, eras, tours, bookings, k)


@njit(cache=True, nogil=True)
def insertion(clocks: Clocks, tours: Tours, bookings: Bookings, v: int, u: int) -> tuple[float, float, int]:
    """Return (about how much its tour's cost [s] changes, departure [s], knot before) of task v put behind node u."""
    lines, knots, times = clocks.lines, clocks.knots, bookings.times
    a, b, w = np.uint32(u), np.uint32(v), np.uint32(tours.after[np.uint32(u)])  # unsigned: see `recreate.best_by_era`
    k, q, since = np.uint32(tours.tour[a]), np.uint32(bookings.marks[a, KNOT]), times[a, SINCE]
    g = np.uint32(clocks.classes[k])
    there = lines[g, a, b, q, 0] + lines[g, a, b, q, 1] * since
    straight = lines[g, a, w, q, 0] + lines[g, a, w, q, 1] * since if a != w else 0.0
    time = times[a, DEPARTS] + there
    q = np.uint32(knot_at(clocks, time))
    on = lines[g, b, w, q, 0] + lines[g, b, w, q, 1] * (time - knots[q])
    return (there + on - straight) * times[w, SENSE] * bookings.scale[k], time, int(q)


@njit(cache=True, nogil=True)
def reverse(tours: Tours, k: int) -> None:
    """Turn tour k round; booking it is the caller's business."""
    depot = tours.after.size - tours.cost.size + k
    after, before, arc, back = tours.after, tours.before, tours.arc, tours.back
    u = depot
    while True:  # links first, then what legs cost: those of u now belong to the leg that led to it
        w = after[u]
        after[u], before[u] = before[u], w
        u = w
        if u == depot:
            break
    first_arc, first_back = arc[depot], back[depot]
    while True:
        w = after[u]
        arc[u], back[u] = (back[w], arc[w]) if w != depot else (first_back, first_arc)
        u = w
        if u == depot:
            break
