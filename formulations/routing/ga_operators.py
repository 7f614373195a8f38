"""Operators of the genetic algorithm of Ombuki-Berman and Hanshar (2009), as kernels on one chromosome.

Chromosomes are changed in place. `rng` is a numpy Generator, so a seed fixes every choice. An insertion looks at every
place of a chromosome: it reads costs along rows, in both directions, and the legs flown now from a list in their order.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, leg, leg_into
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


class Chromosome(NamedTuple):
    """The depot-grouped permutation: `perm` (n,), the tasks of depot 0 in flying order, then those of depot 1, …;
    `sizes` (m,), how many tasks each group has; `totals` (m,) [s], the tour costs C_k (paper, eq. costsum).
    """

    perm: Ints
    sizes: Ints
    totals: Floats


class Population(NamedTuple):
    """Chromosomes, a row each: perms (p, n), sizes (p, m), totals (p, m) [s]; and their fitness (p,) [s]."""

    perms: Ints
    sizes: Ints
    totals: Floats
    fitness: Floats


@njit(cache=True)
def chromosome(people: Population, row: int) -> Chromosome:
    """Return a chromosome that shares its memory with the population."""
    return Chromosome(people.perms[row], people.sizes[row], people.totals[row])


@njit(cache=True)
def copy(source: Population, row: int, target: Population, to: int) -> None:
    """Overwrite row `to` of the target with a row of the source."""
    target.perms[to], target.sizes[to], target.totals[to] = source.perms[row], source.sizes[row], source.totals[row]
    target.fitness[to] = source.fitness[row]


@njit(cache=True)
def tour_cost(costs: Costs, perm: Ints, first: int, last: int, k: int) -> float:
    """Return C_k of the tasks ``perm[first:last]`` flown by UAV `k`."""
    if first == last:
        return 0.0
    depot = perm.size + k
    total = leg(costs, k, depot, perm[first]) + leg(costs, k, perm[last - 1], depot)
    for p in range(first, last - 1):
        total += leg(costs, k, perm[p], perm[p + 1])
    return total


@njit(cache=True)
def evaluate(costs: Costs, tours: Chromosome) -> float:
    """Recompute every C_k and return the fitness, C_max = max_k C_k (paper, eq. c_max)."""
    perm, sizes, totals = tours
    first, longest = 0, 0.0
    for k in range(len(sizes)):
        totals[k] = tour_cost(costs, perm, first, first + sizes[k], k)
        longest = max(longest, totals[k])
        first += sizes[k]
    return longest


@njit(cache=True)
def legs_of(costs: Costs, tours: Chromosome) -> Floats:
    """Return the costs [s] of the legs flown, shape (n+m,): of each tour those to its tasks, then the one home.

    Where tasks are left out, so are as many entries at the end.
    """
    perm, sizes, _ = tours
    legs = np.zeros(perm.size + sizes.size)
    first = 0
    for k in range(len(sizes)):
        depot = here = perm.size + k
        for at in range(first, first + sizes[k]):
            legs[at + k] = leg(costs, k, here, perm[at])
            here = perm[at]
        first += sizes[k]
        legs[first + k] = leg(costs, k, here, depot)
    return legs


@njit(cache=True)
def insert_best(costs: Costs, tours: Chromosome, legs: Floats, task: int, allowed: Bools) -> None:
    """Insert `task` at its best place over the allowed depots: least C_max, then least added cost.

    `perm` holds ``sizes.sum()`` tasks before; `legs` are those of the chromosome, before and after.
    """
    perm, sizes, totals = tours
    n, longest = perm.size, totals.max()
    best_max, best_added, best_k, best_at, best_to, best_from = np.inf, np.inf, -1, -1, 0.0, 0.0
    first = 0
    for k in range(len(sizes)):
        last = first + sizes[k]
        if allowed[k]:
            a = n + k
            for at in range(first, last + 1):
                b = perm[at] if at < last else n + k
                to, back = leg_into(costs, k, task, a), leg(costs, k, task, b)
                added = to + back - legs[at + k]
                reached = max(longest, totals[k] + added)
                if best_k < 0 or reached < best_max or (reached == best_max and added < best_added):
                    best_max, best_added, best_k, best_at, best_to, best_from = reached, added, k, at, to, back
                a = b
        first = last
    for p in range(first, best_at, -1):
        perm[p] = perm[p - 1]
    for p in range(first + len(sizes), best_at + best_k + 1, -1):
        legs[p] = legs[p - 1]
    perm[best_at], legs[best_at + best_k], legs[best_at + best_k + 1] = task, best_to, best_from
    sizes[best_k] += 1
    totals[best_k] += best_added


@njit(cache=True)
def remove_marked(costs: Costs, tours: Chromosome, marked: Bools) -> None:
    """Take the marked tasks out of a chromosome."""
    perm, sizes, _ = tours
    read = write = 0
    for k in range(len(sizes)):
        kept = 0
        for _ in range(sizes[k]):
            if not marked[perm[read]]:
                perm[write] = perm[read]
                write += 1
                kept += 1
            read += 1
        sizes[k] = kept
    evaluate(costs, tours)


@njit(cache=True)
def best_cost_route_crossover(costs: Costs, rng: Any, pair: Population) -> None:
    """Best-cost route crossover: turn two parents, rows 0 and 1, into two children.

    Pick a depot at random. The tasks of parent 1's route there are taken out of parent 2 and put back one by one, each
    at its best place over all depots; and the other way round. The paper picks the best *feasible* place with
    probability 0.8 and else the best place of all; without capacities every place is feasible and the two are one.
    """
    n, m = pair.perms.shape[1], pair.sizes.shape[1]
    k = rng.integers(0, m)
    everywhere = np.ones(m, dtype=np.bool_)
    first, last = pair.sizes[:, :k].sum(axis=1), pair.sizes[:, : k + 1].sum(axis=1)
    routes = pair.perms[0, first[0] : last[0]].copy(), pair.perms[1, first[1] : last[1]].copy()
    for child in range(2):
        given, tours = routes[1 - child], chromosome(pair, child)
        marked = np.zeros(n, dtype=np.bool_)
        marked[given] = True
        remove_marked(costs, tours, marked)
        legs = legs_of(costs, tours)
        for task in given:
            insert_best(costs, tours, legs, task, everywhere)


@njit(cache=True)
def intra_depot_mutation(costs: Costs, rng: Any, tours: Chromosome) -> None:
    """Intra-depot mutation: in one depot's group, one of three changes, each as likely.

    Reversal of a stretch between two cuts; single task re-routing, one task put to its best place in the group; or a
    swap of two tasks.
    """
    perm, sizes, _ = tours
    m = len(sizes)
    k = rng.integers(0, m)
    if sizes[k] < 2:
        return
    first, size = sizes[:k].sum(), sizes[k]
    kind = rng.integers(0, 3)
    a, b = first + rng.integers(0, size), first + rng.integers(0, size)
    if kind == 0:
        low, high = min(a, b), max(a, b) + 1
        perm[low:high] = perm[low:high][::-1].copy()
    elif kind == 1:
        move_task(costs, tours, perm[a], np.arange(m) == k)
    else:
        perm[a], perm[b] = perm[b], perm[a]


@njit(cache=True)
def inter_depot_mutation(costs: Costs, rng: Any, tours: Chromosome, candidates: Bools) -> None:
    """Inter-depot mutation: move a random border-line task to its best place at another of its candidate depots."""
    border = np.flatnonzero(candidates.sum(axis=1) > 1)
    if len(border) == 0:
        return
    task = border[rng.integers(0, len(border))]
    place = np.flatnonzero(tours.perm == task)[0]
    elsewhere = candidates[task].copy()
    elsewhere[np.searchsorted(np.cumsum(tours.sizes), place, side="right")] = False
    move_task(costs, tours, task, elsewhere)


@njit(cache=True)
def move_task(costs: Costs, tours: Chromosome, task: int, allowed: Bools) -> None:
    """Take `task` out and put it to its best place over the allowed depots."""
    marked = np.zeros(tours.perm.size, dtype=np.bool_)
    marked[task] = True
    remove_marked(costs, tours, marked)
    insert_best(costs, tours, legs_of(costs, tours), task, allowed)
