"""Decomposition: the longest tour and a few others searched alone, from the beginning, as an instance of their own.

Where a few tours decide and the others have time to spare, most steps of a search of the whole are spent elsewhere;
here all of them go to tours around the longest one, and an annealing of few tasks is soon over (POPMUSIC, Taillard &
Voss 2002). Some of the tours taken along are short ones from anywhere, which may come to help.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs
from formulations.routing.search.problem_data import (
    GranularNeighbourhood,
    NeighbourhoodParameters,
    Nodes,
    ProblemData,
    data_between,
)
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.tours import Tours, clear, duplicate, empty_tours, fill, link, sum_costs
from instances.kernels import njit


class DecompositionParameters(NamedTuple):
    """Which tours make a subproblem, and how deep it is searched.

    most: tours searched together, at most: few enough to be solved nearly to the optimum.
    anywhere: share of draws that look for a short tour anywhere; the others step from a task chosen to a near one.
    near: near tasks that such a step may go to.
    draws: for each tour wanted, after which there are fewer.
    depth: steps are depth · s² / w for s tasks of w tours, 2.5 times those of a founder of that size.
    least: steps at least.
    perturbed: share that begins with a perturbation, half as long, not from scratch.
    """

    most: int = 6
    anywhere: float = 0.3
    near: int = 12
    draws: int = 50
    depth: float = 5.0
    least: int = 10_000
    perturbed: float = 0.3


class Subproblem(NamedTuple):
    """Some tours as an instance of their own.

    data: theirs; whole: the tours they are of; tours: theirs as they were; best: those found with the smallest
    max_k C_k; nodes (s+w,): the node of the whole for each of theirs, tasks first.
    """

    data: ProblemData
    whole: Tours
    tours: Tours
    best: Tours
    nodes: Nodes


@njit(cache=True, nogil=True)
def task_on(tours: Tours, k: int, rng: Rng) -> int:
    """Return a random task of tour k, its depot where there is none."""
    n = tours.after.size - tours.cost.size
    v = n + k
    if tours.size[k] > 0:
        for _ in range(1 + below(rng, tours.size[k])):
            v = tours.after[v]
    return v


@njit(cache=True, nogil=True)
def around(
    near: GranularNeighbourhood, tours: Tours, first: int, wanted: int, parameters: DecompositionParameters, rng: Rng
) -> Nodes:
    """Return tour `first` and up to `wanted` − 1 others: near those chosen already, or short ones from anywhere."""
    m = tours.cost.size
    n = tours.after.size - m
    chosen = np.empty(wanted, np.int32)
    taken = np.zeros(m, np.uint8)
    chosen[0] = first
    taken[chosen[0]] = 1
    count = 1
    for _ in range(parameters.draws * wanted):
        if count == wanted:
            break
        v = task_on(tours, chosen[below(rng, count)], rng)
        if uniform(rng) < parameters.anywhere or v >= n or near.tasks.shape[1] == 0:
            h, g = below(rng, m), below(rng, m)
            k = h if tours.cost[h] < tours.cost[g] else g
        else:
            k = tours.tour[near.tasks[v, below(rng, min(parameters.near, near.tasks.shape[1]))]]
        if not taken[k]:
            taken[k] = 1
            chosen[count] = k
            count += 1
    return chosen[:count]


def _nodes_of(tours: Tours, uavs: Nodes) -> Nodes:
    """Return the tasks of some tours in their order, then their depots."""
    n, nodes = tours.after.size - tours.cost.size, []
    for depot in n + uavs:
        v = tours.after[depot]
        while v < n:
            nodes.append(v)
            v = tours.after[v]
    return np.array([*nodes, *(n + uavs)], np.int32)


def subproblem(data: ProblemData, tours: Tours, uavs: Nodes, parameters: NeighbourhoodParameters) -> Subproblem:
    """Return the tours of some UAVs as an instance of their own."""
    nodes = _nodes_of(tours, uavs)
    n_tasks = nodes.size - uavs.size
    own = data_between(data, nodes, uavs, parameters)
    empty = empty_tours(n_tasks, uavs.size)
    part = Subproblem(own, tours, empty, empty, nodes)
    ends = np.cumsum(tours.size[uavs])
    for j, tasks in enumerate(np.split(np.arange(n_tasks, dtype=np.int32), ends[:-1])):
        fill(own.costs, part.tours, j, tasks)
    sum_costs(part.tours)
    return part._replace(best=duplicate(part.tours))


@njit(cache=True, nogil=True)
def merge(costs: Costs, nodes: Nodes, found: Tours, tours: Tours) -> None:
    """Give the UAVs of a subproblem, whose nodes these are, the tours `found` for them, in `tours` of the whole."""
    w = found.cost.size
    s, n = nodes.size - w, tours.after.size - tours.cost.size
    removed = np.empty(s, np.int32)
    for depot in nodes[s:]:
        clear(costs, tours, depot - n, removed)
    for j in range(w):
        u, v = nodes[s + j], found.after[s + j]
        while v < s:
            link(costs, tours, nodes[v], u)
            u, v = nodes[v], found.after[v]
    sum_costs(tours)
