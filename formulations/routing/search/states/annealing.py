"""Annealed ruin-and-recreate over states: what `search.annealing` is, with tours that keep prefixes and suffixes.

A ruin takes out strings of consecutive tasks near a seed task, or its nearest tasks (Christiaens & Vanden Berghe 2020).
A recreation puts them back one by one in random order, each where it raises a guide least (`search.recreate`). The
chains of an insertion are only followed where its lower bound, F's least + least legs + G's least, beats what is found.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.routing.search.energy import Measure, Objective, energy
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import GUIDES, growth, shuffle
from formulations.routing.search.states.costs import Singles, StateCosts
from formulations.routing.search.states.tours import StateTours, book, copy_tours, insert, rekeep, with_task
from formulations.routing.search.tours import longest
from instances.arrays import Ints
from instances.kernels import njit


class StateAnnealing(NamedTuple):
    """What the steps are.

    removals: tasks taken out by one ruin, at most. strings: share of ruins by strings. blink: probability of
    overlooking a place. tie: as in `search.recreate`.
    """

    removals: int = 10
    strings: float = 0.5
    blink: float = 0.01
    tie: float = 1e-4


@njit(cache=True, nogil=True)
def _take(tours: StateTours, v: int) -> None:
    """Take task v out of its tour; positions behind it are renewed, chains are not."""
    k = tours.tour[v]
    order = tours.order[k]
    for p in range(tours.place[v], tours.size[k] - 1):
        order[p] = order[p + 1]
        tours.place[order[p]] = p
    tours.size[k] -= 1
    tours.tour[v] = -1


@njit(cache=True, nogil=True)
def ruin(costs: StateCosts, tours: StateTours, near: Ints, queue: Ints, parameters: StateAnnealing, rng: Rng) -> int:
    """Take tasks out, write them to `queue` and return how many; near (n, j) are each task's nearest, itself first."""
    n = near.shape[0]
    wanted = 1 + below(rng, min(parameters.removals, n))
    by_string = uniform(rng) < parameters.strings
    length = 1 + below(rng, wanted)
    count, seed = 0, below(rng, n)
    for j in range(near.shape[1]):
        v = near[seed, j]
        k = tours.tour[v]
        if k < 0 or count >= wanted:
            continue
        begin, taken = tours.place[v], 1
        if by_string:
            taken = min(length, wanted - count, tours.size[k])
            begin = min(max(0, begin - below(rng, taken)), tours.size[k] - taken)
        for _ in range(taken):
            task = tours.order[k, begin]
            _take(tours, task)
            queue[count] = task
            count += 1
    for k in range(tours.size.size):
        book(costs, tours, k, 0, tours.size[k] - 1)
    return count


@njit(cache=True, nogil=True)
def recreate(
    costs: StateCosts,
    tours: StateTours,
    queue: Ints,
    count: int,
    guide: Measure,
    room: Singles,
    parameters: StateAnnealing,
    rng: Rng,
) -> None:
    """Insert queue[:count] in that order."""
    n, unit = tours.tour.size, longest(tours.cost)
    scale = 1.0 / unit if unit > 0.0 else 1.0
    for i in range(count):
        v = queue[i]
        best, best_k, best_p = np.inf, -1, 0
        while best_k < 0:  # all places may have been overlooked
            for k in range(tours.size.size):
                least, u, length = costs.least[costs.classes[k]], n + k, tours.cost[k]
                for p in range(tours.size[k] + 1):
                    w = tours.order[k, p] if p < tours.size[k] else n + k
                    bound = tours.near[u] + least[u, v] + least[v, w] + tours.home[w]
                    u = w
                    if growth(length * scale, (bound - length) * scale, guide, parameters.tie) >= best:
                        continue
                    if uniform(rng) < parameters.blink:
                        continue
                    change = with_task(costs, tours, k, v, p, room) - length
                    value = growth(length * scale, change * scale, guide, parameters.tie)
                    if value < best:
                        best, best_k, best_p = value, k, p
        insert(costs, tours, best_k, v, best_p)


@njit(cache=True, nogil=True)
def anneal(
    costs: StateCosts,
    near: Ints,
    tours: StateTours,
    trial: StateTours,
    best: StateTours,
    rng: Rng,
    steps: int,
    temperature: float,
    objective: Objective,
    parameters: StateAnnealing,
) -> None:
    """Take `steps` steps from `tours`, in place; `trial` is room, `best` follows the smallest longest tour."""
    queue = np.empty(parameters.removals, np.int64)
    room = np.empty((2, tours.prefix.shape[1]), np.float32)
    now = energy(tours.cost, objective)
    copy_tours(tours, trial)
    for _ in range(steps):
        count = ruin(costs, trial, near, queue, parameters, rng)
        shuffle(queue, count, rng)
        recreate(costs, trial, queue, count, GUIDES[below(rng, len(GUIDES))], room, parameters, rng)
        if costs.closed:
            k = trial.tour[queue[0]]
            rekeep(costs, trial, k)
        then = energy(trial.cost, objective)
        if then < now - temperature * math.log(1.0 - uniform(rng)):
            now = then
            copy_tours(trial, tours)
            if longest(tours.cost) < longest(best.cost):
                copy_tours(tours, best)
        else:
            copy_tours(tours, trial)
