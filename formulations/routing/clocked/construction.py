"""Greedy construction by the clock: the rules of `greedy`, gaps compared to first order and booked exactly."""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.annealing import Search
from formulations.routing.clocked.bookings import DEPARTS, Bookings, book_tour, insertion
from formulations.routing.clocked.problem import ClockedProblem
from formulations.routing.clocks import Clocks, leg_at
from formulations.routing.recorder import Recorder
from formulations.routing.search.problem_data import NeighbourhoodParameters, Nodes
from formulations.routing.search.tours import Tours, link, to_routes
from formulations.routing.solver import Result
from instances.arrays import Floats
from instances.kernels import njit


def greedy_by_clock(recorder: Recorder, variant: str) -> Result:
    """Construct routes; where endurance leaves them in the air, anew of scaled costs, as `greedy` does."""
    problem = ClockedProblem(recorder.instance, NeighbourhoodParameters())
    endurance = problem.endurance
    tours, in_time = _constructed(recorder, problem, variant)
    for reference in (float(tours.cost.max()), endurance.most):
        if endurance.limited and recorder.routes is None and in_time:
            endurance.refer(reference)
            _, in_time = _constructed(recorder, problem, variant)
    return recorder.result("finished" if in_time else "time")


def _constructed(recorder: Recorder, problem: ClockedProblem, variant: str) -> tuple[Tours, bool]:
    """Offer routes to the recorder; return them, and whether they were finished in time."""
    tours = problem.tours()
    search = problem.search(tours, 1)
    in_time = variant == "nearest" or _insert_all(search, variant, recorder)
    _extend_nearest(search)
    recorder.incumbent(to_routes(tours))
    return tours, in_time


def _insert_all(search: Search, variant: str, recorder: Recorder) -> bool:
    """Insert all tasks by a rule, until time is up; return whether all are."""
    tours, (n, m) = search.tours, search.data.size
    growth, behind = np.empty((m, n)), np.empty((m, n), np.int32)
    for k in range(m):
        look(search.clocks, tours, search.bookings, k, growth[k], behind[k])
    for _ in range(n):
        if recorder.remaining <= 0.0:
            return False
        k, v = _chosen(tours.cost, growth, variant)
        _put(search, k, v, int(behind[k, v]))
        growth[:, v] = np.inf
        look(search.clocks, tours, search.bookings, k, growth[k], behind[k])
    return True


def _chosen(cost: Floats, growth: Floats, variant: str) -> tuple[int, int]:
    """Return UAV and task of the next insertion; ties go to the lowest UAV, then task."""
    if variant != "regret":
        k = int(np.argmin(cost + growth.min(axis=1) if variant == "cheapest" else cost))
        return k, int(np.argmin(growth[k]))
    reached = cost[:, None] + growth
    best = reached.min(axis=0)
    second = np.partition(reached, 1, axis=0)[1] if len(cost) > 1 else np.zeros_like(best)
    left = np.flatnonzero(np.isfinite(best))
    regret = second[left] - best[left]
    v = int(left[np.lexsort((left, best[left], -regret))[0]])
    return int(np.argmin(reached[:, v])), v


def _extend_nearest(search: Search) -> None:
    """Route all tasks left: again and again the UAV whose tour is shortest flies on to where it is soonest."""
    tours, bookings, n = search.tours, search.bookings, search.data.size[0]
    left = np.flatnonzero(tours.tour[:n] < 0)
    while len(left):
        k = int(np.argmin(tours.cost))
        u = int(tours.before[n + k])
        time, g = float(bookings.times[u, DEPARTS]) if u < n else 0.0, int(search.clocks.classes[k])
        v = int(left[np.argmin([leg_at(search.clocks, g, u, int(i), time) for i in left])])
        _put(search, k, v, u)
        left = left[left != v]


def _put(search: Search, k: int, v: int, u: int) -> None:
    """Put task v behind node u of tour k."""
    link(search.data.costs, search.tours, v, u)
    book_tour(search.clocks, search.eras, search.tours, search.bookings, k)


@njit(cache=True, nogil=True)
def look(clocks: Clocks, tours: Tours, bookings: Bookings, k: int, growth: Floats, behind: Nodes) -> None:
    """Find the best gap of tour k for every task that is on no tour, +inf for the others."""
    depot = tours.after.size - tours.cost.size + k
    for v in range(growth.size):
        growth[v] = np.inf
        if tours.tour[v] >= 0:
            continue
        u = depot
        while True:
            change = insertion(clocks, tours, bookings, v, u)[0]
            if change < growth[v]:
                growth[v], behind[v] = change, u
            u = tours.after[u]
            if u == depot:
                break
