"""Focus: the longest tour and a few others searched alone, from the beginning, as an instance of their own.

Where a few tours decide and the others have time to spare, most steps of a search of the whole are spent elsewhere;
here all of them go to tours around the longest one, and an annealing of few tasks is soon over (POPMUSIC, Taillard &
Voss 2002). Some of the tours taken along are short ones from anywhere, which may come to help.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.routing.search.costs import Costs
from formulations.routing.search.ground import Ground, survey
from formulations.routing.search.neighbours import Neighbours
from formulations.routing.search.randomness import below, uniform
from formulations.routing.search.tours import Tours, clear, copy_tours, empty_tours, lay_out, sum_costs

MOST = 6
"""Tours searched together, at most."""
FROM_ANYWHERE = 0.3
"""Share of draws that look for a short tour anywhere; the others step from a task chosen to a near one."""
NEAR = 12
"""Near tasks that such a step may go to."""
DRAWS = 50
"""Draws for each tour wanted, after which there are fewer."""


class Part(NamedTuple):
    """Some tours as an instance of their own.

    ground: theirs; tours: theirs as they were; best: those found with the smallest max_k C_k; nodes (s+w,): the node of
    the whole for each of theirs, tasks first.
    """

    ground: Ground
    tours: Tours
    best: Tours
    nodes: NDArray[np.int32]


@njit(cache=True, nogil=True)
def _task_on(tours: Tours, k: int, rng: NDArray[np.uint64]) -> int:
    """Return a random task of tour k, its depot where there is none."""
    n = tours.after.size - tours.cost.size
    v = n + k
    if tours.size[k] > 0:
        for _ in range(1 + below(rng, tours.size[k])):
            v = tours.after[v]
    return v


@njit(cache=True, nogil=True)
def around_longest(near: Neighbours, tours: Tours, wanted: int, rng: NDArray[np.uint64]) -> NDArray[np.int32]:
    """Return the longest tour and up to `wanted` − 1 others: near those chosen already, or short ones from anywhere."""
    m = tours.cost.size
    n = tours.after.size - m
    chosen = np.empty(wanted, np.int32)
    taken = np.zeros(m, np.uint8)
    chosen[0] = np.argmax(tours.cost)
    taken[chosen[0]] = 1
    count = 1
    for _ in range(DRAWS * wanted):
        if count == wanted:
            break
        v = _task_on(tours, chosen[below(rng, count)], rng)
        if uniform(rng) < FROM_ANYWHERE or v >= n or near.tasks.shape[1] == 0:
            h, g = below(rng, m), below(rng, m)
            k = h if tours.cost[h] < tours.cost[g] else g
        else:
            k = tours.tour[near.tasks[v, below(rng, min(NEAR, near.tasks.shape[1]))]]
        if not taken[k]:
            taken[k] = 1
            chosen[count] = k
            count += 1
    return chosen[:count]


@njit(cache=True, nogil=True)
def _nodes_of(tours: Tours, uavs: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the tasks of some tours in their order, then their depots."""
    n = tours.after.size - tours.cost.size
    nodes = np.empty(tours.size[uavs].sum() + uavs.size, np.int32)
    count = 0
    for k in uavs:
        v = tours.after[n + k]
        while v < n:
            nodes[count] = v
            count += 1
            v = tours.after[v]
    nodes[count:] = n + uavs
    return nodes


def part_of(ground: Ground, tours: Tours, uavs: NDArray[np.int32]) -> Part:
    """Return the tours of some UAVs as an instance of their own."""
    nodes = _nodes_of(tours, uavs)
    n_tasks = nodes.size - uavs.size
    cost = np.ascontiguousarray(ground.costs.out[np.ix_(nodes, nodes)])
    cost.setflags(write=False)  # like an instance's own: the kernels are compiled for that type
    own = survey(cost, n_tasks)
    part = Part(own, empty_tours(n_tasks, uavs.size), empty_tours(n_tasks, uavs.size), nodes)
    ends = np.cumsum(tours.size[uavs])
    for j, tasks in enumerate(np.split(np.arange(n_tasks, dtype=np.int32), ends[:-1])):
        lay_out(own.costs, part.tours, j, tasks)
    sum_costs(part.tours)
    copy_tours(part.tours, part.best)
    return part


@njit(cache=True, nogil=True)
def put_back(costs: Costs, nodes: NDArray[np.int32], found: Tours, tours: Tours) -> None:
    """Give the UAVs of a part, whose nodes these are, the tours `found` for them, in `tours` of the whole."""
    w = found.cost.size
    s, n = nodes.size - w, tours.after.size - tours.cost.size
    homeless = np.empty(s, np.int32)
    for depot in nodes[s:]:
        clear(costs, tours, depot - n, homeless)
    for j in range(w):
        own = _nodes_of(found, np.array([j], np.int32))[:-1]
        lay_out(costs, tours, nodes[s + j] - n, nodes[own])
    sum_costs(tours)
