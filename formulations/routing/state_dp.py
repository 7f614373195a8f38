"""Held–Karp over chains of states, for `subset-dp`: tours of instances with several states at a node.

    f_k({j}, b) = min_a c[(k, a), (j, b)],   f_k(S, (j, b)) = min_{i ∈ S∖j, a} f_k(S∖j, (i, a)) + c[(i, a), (j, b)]
    t_k(S) = min_{j ∈ S, b, a} f_k(S, (j, b)) + c[(j, b), (k, a)]

exact for the states there are: 2ⁿn²H² steps a depot with H states a task, and 8·nH·2ⁿ bytes. A closed tour must end in
the state of its depot that it began in, so the recursion is done for each of these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.recorder import Recorder
from instances import Instance
from instances.arrays import Floats, Ints
from instances.kernels import njit

LARGEST_TABLE = 150_000_000
"""Most entries of f: 1.2 GB."""
_STEPS = 20_000_000
"""Additions between two looks at the clock, about."""


class StateLegs(NamedTuple):
    """What UAV k pays between states.

    first (n + 1,) : of task j, its states are first[j] to first[j + 1] − 1. between (S, S) [s].
    starts, ends (D, S) [s] : from the depot and home, for each state of the depot that is to be both first and last.
    """

    first: Ints
    between: Floats
    starts: Floats
    ends: Floats


def state_legs(instance: Instance, k: int, tasks: list[int] | None = None) -> StateLegs:
    """Return what UAV k pays between states of `tasks` (all if left out) and its depot."""
    travel = instance.travel
    assert travel is not None
    cost = travel.cost[travel.classes[k], 0]
    wanted = list(instance.tasks) if tasks is None else tasks
    states = [np.flatnonzero(travel.nodes == node) for node in wanted]
    of_tasks = np.concatenate(states)
    first = np.concatenate([[0], np.cumsum([len(each) for each in states])])
    depot = np.flatnonzero(travel.nodes == instance.n_tasks + k)
    starts, ends = cost[np.ix_(depot, of_tasks)], cost[np.ix_(of_tasks, depot)].T
    if not travel.closed:
        starts, ends = starts.min(axis=0, keepdims=True), ends.min(axis=0, keepdims=True)
    between = np.ascontiguousarray(cost[np.ix_(of_tasks, of_tasks)])
    return StateLegs(first, between, np.ascontiguousarray(starts), np.ascontiguousarray(ends))


def state_tour_table(instance: Instance, k: int, clock: Recorder | None = None) -> Floats | None:
    """Return t_k(S) [s] for every set S of tasks, shape (2ⁿ,); None when the clock runs out."""
    legs, n = state_legs(instance, k), instance.n_tasks
    path = np.empty((1 << n, legs.first[-1]))
    tour = np.full(1 << n, np.inf)
    tour[0] = 0.0
    chunk = max(16, _STEPS // len(legs.between) ** 2)
    for start, end in zip(legs.starts, legs.ends, strict=True):
        for low in range(1, 1 << n, chunk):
            if clock is not None and clock.remaining <= 0:
                return None
            _extend(low, min(low + chunk, 1 << n), legs.first, start, legs.between, end, path, tour)
    return tour


@njit(cache=True)
def _extend(
    low: int, high: int, first: Ints, start: Floats, between: Floats, end: Floats, path: Floats, tour: Floats
) -> None:
    """Fill f of the sets low..high−1, and lower t where a tour of this start and end is shorter."""
    n = first.size - 1
    for s in range(low, high):
        for j in range(n):
            if not s >> j & 1:
                continue
            here = path[s, first[j] : first[j + 1]]
            rest = s ^ (1 << j)
            if rest == 0:
                here[:] = start[first[j] : first[j + 1]]
            else:
                here[:] = np.inf
            for i in range(n):
                if rest >> i & 1:
                    for a in range(first[i], first[i + 1]):
                        spent, legs = path[rest, a], between[a, first[j] : first[j + 1]]
                        for b in range(here.size):
                            total = spent + legs[b]
                            here[b] = total if total < here[b] else here[b]
            for b in range(here.size):
                tour[s] = min(tour[s], here[b] + end[first[j] + b])


def cheapest_chain(instance: Instance, k: int, tasks: list[int]) -> tuple[int, ...]:
    """Return `tasks` in the order of UAV k's cheapest tour over chains of states."""
    if not tasks:
        return ()
    legs, full = state_legs(instance, k, tasks), (1 << len(tasks)) - 1
    best = np.inf
    order: list[int] = []
    for start, end in zip(legs.starts, legs.ends, strict=True):
        path, tour = np.empty((full + 1, legs.first[-1])), np.full(full + 1, np.inf)
        _extend(1, full + 1, legs.first, start, legs.between, end, path, tour)
        if tour[full] < best or not order:
            best, order = tour[full], _walked_back(legs, path, end)
    return tuple(tasks[j] for j in order)


def _walked_back(legs: StateLegs, path: Floats, end: Floats) -> list[int]:
    """Return the tasks, numbered as in `legs`, in the order of the tour that `path` and `end` make cheapest."""
    of_state = np.repeat(np.arange(len(legs.first) - 1), np.diff(legs.first))
    order, rest, following = [], len(path) - 1, end
    while rest:
        total = np.where(rest >> of_state & 1, path[rest] + following, np.inf)
        last = int(total.argmin())
        order.append(int(of_state[last]))
        rest ^= 1 << of_state[last]
        following = legs.between[:, last]
    return order[::-1]
