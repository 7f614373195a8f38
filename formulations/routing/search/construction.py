"""Construction: tours from nothing, one task at a time, in O(n²) looks at the costs for each UAV.

Insertion rules share one table: for every UAV k and task v not yet routed, the least growth of C_k that v could cause
and the node it would then stand behind. A step closes one gap and opens two, so only those are looked at; a task whose
best gap was closed looks through the whole tour again.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, leg, leg_into, n_nodes
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours, insertion_change, link
from instances.arrays import Floats, Ints
from instances.kernels import njit


class Rule(IntEnum):
    """Which task is inserted next.

    The one that loses most if it does not get its best tour (regret of the tours' costs, Potvin & Rousseau 1993); that
    of the insertion after which the tour is shortest; that of the cheapest insertion into the shortest tour.
    """

    REGRET = 0
    CHEAPEST = 1
    SHORTEST = 2


class Gaps(NamedTuple):
    """growth (m, n): least growth of tour k by task v [s], inf for a routed task; behind (m, n): the node before it;
    task (m,): the task of least growth; least (m,): that growth [s]."""

    growth: Floats
    behind: Nodes
    task: Ints
    least: Floats


@njit(cache=True, nogil=True)
def _note_least(gaps: Gaps, k: int) -> None:
    """Find the task of least growth of tour k."""
    growth = gaps.growth[k]
    v = int(np.argmin(growth))
    gaps.task[k], gaps.least[k] = v, growth[v]


@njit(cache=True, nogil=True)
def first_gaps(costs: Costs, n_tasks: int) -> Gaps:
    """Return the Gaps of empty tours."""
    m = n_nodes(costs) - n_tasks
    gaps = Gaps(np.empty((m, n_tasks)), np.empty((m, n_tasks), np.int32), np.zeros(m, np.int64), np.empty(m))
    for k in range(m):
        for v in range(n_tasks):
            gaps.growth[k, v] = leg(costs, k, n_tasks + k, v) + leg_into(costs, k, n_tasks + k, v)
            gaps.behind[k, v] = n_tasks + k
        _note_least(gaps, k)
    return gaps


@njit(cache=True, nogil=True)
def _look_again(costs: Costs, tours: Tours, gaps: Gaps, k: int, v: int) -> None:
    """Find the best gap of tour k for task v among all."""
    depot = tours.after.size - tours.cost.size + k
    least, behind, u = np.inf, depot, depot
    while True:
        change = insertion_change(costs, tours, v, u)
        if change < least:
            least, behind = change, u
        u = tours.after[u]
        if u == depot:
            break
    gaps.growth[k, v], gaps.behind[k, v] = least, behind


@njit(cache=True, nogil=True)
def insert(costs: Costs, tours: Tours, gaps: Gaps, k: int, v: int) -> None:
    """Put task v into its best gap of tour k; bring the tour's cost and the gaps up to date."""
    growth, behind = gaps.growth[k], gaps.behind[k]
    u, n = behind[v], gaps.growth.shape[1]
    tours.cost[k] += growth[v]
    link(costs, tours, v, u)
    w = tours.after[v]
    for h in range(tours.cost.size):
        gaps.growth[h, v] = np.inf
        if h != k and gaps.task[h] == v:
            _note_least(gaps, h)
    for i in range(n):
        if tours.tour[i] >= 0:
            continue
        if behind[i] == u:
            _look_again(costs, tours, gaps, k, i)
            continue
        ahead = leg(costs, k, u, i) + leg_into(costs, k, v, i) - tours.arc[u]
        after = leg(costs, k, v, i) + leg_into(costs, k, w, i) - tours.arc[v]
        if ahead < growth[i]:
            growth[i], behind[i] = ahead, u
        if after < growth[i]:
            growth[i], behind[i] = after, v
    _note_least(gaps, k)


@njit(cache=True, nogil=True)
def _most_regretted(tours: Tours, gaps: Gaps) -> tuple[int, int]:
    """Return (tour, task) of the task whose second best tour would be most costlier [s] than its best one."""
    m, n = gaps.growth.shape
    best, second, where = np.full(n, np.inf), np.full(n, np.inf), np.zeros(n, np.int64)
    for k in range(m):
        for v in range(n):
            cost = tours.cost[k] + gaps.growth[k, v]
            if cost < best[v]:
                best[v], second[v], where[v] = cost, best[v], k
            elif cost < second[v]:
                second[v] = cost
    chosen, most = -1, -np.inf
    for v in range(n):
        if tours.tour[v] < 0:
            regret = second[v] - best[v] if m > 1 else -best[v]
            if chosen < 0 or regret > most or (regret == most and best[v] < best[chosen]):
                chosen, most = v, regret
    return where[chosen], chosen


@njit(cache=True, nogil=True)
def insert_many(costs: Costs, tours: Tours, gaps: Gaps, rule: Rule, count: int) -> None:
    """Route `count` tasks more by `rule`; there must be as many left. Ties go to the lowest UAV."""
    for _ in range(count):
        if rule == Rule.REGRET:
            k, v = _most_regretted(tours, gaps)
        else:
            k = int(np.argmin(tours.cost + gaps.least if rule == Rule.CHEAPEST else tours.cost))
            v = gaps.task[k]
        insert(costs, tours, gaps, k, v)


@njit(cache=True, nogil=True)
def extend_nearest(costs: Costs, tours: Tours, near: Nodes) -> None:
    """Route all tasks left: again and again the UAV whose tour is shortest flies on to the task nearest to its last.

    near (n, q): tasks near each, among which is looked first; only where none of them is left among all. q may be 0.
    Made to be the last step: the arcs of the tours are left as they were.
    """
    m = tours.cost.size
    n = tours.after.size - m
    left = np.flatnonzero(tours.tour[:n] < 0)
    place = np.empty(n, np.int64)
    for i in range(left.size):
        place[left[i]] = i
    for held in range(left.size, 0, -1):
        k = int(np.argmin(tours.cost))
        u = tours.before[n + k]
        at, least = -1, np.inf
        for j in range(near.shape[1] if u < n else 0):
            v = near[u, j]
            if tours.tour[v] < 0 and leg(costs, k, u, v) < least:
                at, least = place[v], leg(costs, k, u, v)
        for i in range(held if at < 0 else 0):
            cost = leg(costs, k, u, left[i])
            if cost < least:
                at, least = i, cost
        v = left[at]
        left[at] = left[held - 1]
        place[left[at]] = at
        tours.cost[k] += leg(costs, k, u, v) + leg(costs, k, v, n + k) - leg(costs, k, u, n + k)
        tours.after[u], tours.before[v], tours.after[v], tours.before[n + k] = v, u, n + k, v
        tours.tour[v] = k
        tours.size[k] += 1
