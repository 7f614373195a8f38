"""Operators of the genetic algorithm of Ombuki-Berman and Hanshar (2009), as kernels on one chromosome.

A chromosome is the depot-grouped permutation: `perm` (n,), the tasks of depot 0 in flying order, then those of depot
1, …; `sizes` (m,), how many tasks each group has; `totals` (m,) [s], the tour costs C_k (paper, eq. costsum). All
are changed in place. `rng` is a numpy Generator, so a seed fixes every choice.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


@njit(cache=True)
def tour_cost(cost: Floats, perm: Ints, first: int, last: int, depot: int) -> float:  # pragma: no cover
    """Return C_k of the tasks ``perm[first:last]`` flown from `depot`."""
    if first == last:
        return 0.0
    total = cost[depot, perm[first]] + cost[perm[last - 1], depot]
    for p in range(first, last - 1):
        total += cost[perm[p], perm[p + 1]]
    return total


@njit(cache=True)
def evaluate(cost: Floats, perm: Ints, sizes: Ints, totals: Floats, n: int) -> float:  # pragma: no cover
    """Recompute every C_k and return the fitness, C_max = max_k C_k (paper, eq. c_max)."""
    first, longest = 0, 0.0
    for k in range(len(sizes)):
        totals[k] = tour_cost(cost, perm, first, first + sizes[k], n + k)
        longest = max(longest, totals[k])
        first += sizes[k]
    return longest


@njit(cache=True)
def insert_best(
    cost: Floats, perm: Ints, sizes: Ints, totals: Floats, task: int, allowed: Bools, n: int
) -> None:  # pragma: no cover
    """Insert `task` at its best place over the allowed depots: least C_max, then least added cost.

    `perm` holds ``sizes.sum()`` tasks before.
    """
    longest = totals.max()
    best_max, best_added, best_k, best_at = np.inf, np.inf, -1, -1
    first = 0
    for k in range(len(sizes)):
        last = first + sizes[k]
        if allowed[k]:
            for at in range(first, last + 1):
                a = perm[at - 1] if at > first else n + k
                b = perm[at] if at < last else n + k
                added = cost[a, task] + cost[task, b] - cost[a, b]
                reached = max(longest, totals[k] + added)
                if best_k < 0 or reached < best_max or (reached == best_max and added < best_added):
                    best_max, best_added, best_k, best_at = reached, added, k, at
        first = last
    for p in range(first, best_at, -1):
        perm[p] = perm[p - 1]
    perm[best_at] = task
    sizes[best_k] += 1
    totals[best_k] += best_added


@njit(cache=True)
def remove_marked(cost: Floats, perm: Ints, sizes: Ints, totals: Floats, marked: Bools, n: int) -> None:
    """Take the marked tasks out of a chromosome."""  # pragma: no cover
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
    evaluate(cost, perm, sizes, totals, n)


@njit(cache=True)
def best_cost_route_crossover(
    cost: Floats, rng: Any, perms: Ints, sizes: Ints, totals: Floats, n: int
) -> None:  # pragma: no cover
    """Best-cost route crossover: turn two parents, rows 0 and 1, into two children.

    Pick a depot at random. The tasks of parent 1's route there are taken out of parent 2 and put back one by one, each
    at its best place over all depots; and the other way round. The paper picks the best *feasible* place with
    probability 0.8 and else the best place of all; without capacities every place is feasible and the two are one.
    """
    m = sizes.shape[1]
    k = rng.integers(0, m)
    everywhere = np.ones(m, dtype=np.bool_)
    moved = np.empty((2, n), dtype=np.int64)
    count = np.empty(2, dtype=np.int64)
    for parent in range(2):
        first = sizes[parent, :k].sum()
        count[parent] = sizes[parent, k]
        for p in range(count[parent]):
            moved[parent, p] = perms[parent, first + p]
    for child in range(2):
        other = 1 - child
        marked = np.zeros(n, dtype=np.bool_)
        for p in range(count[other]):
            marked[moved[other, p]] = True
        remove_marked(cost, perms[child], sizes[child], totals[child], marked, n)
        for p in range(count[other]):
            insert_best(cost, perms[child], sizes[child], totals[child], moved[other, p], everywhere, n)


@njit(cache=True)
def intra_depot_mutation(
    cost: Floats, rng: Any, perm: Ints, sizes: Ints, totals: Floats, n: int
) -> None:  # pragma: no cover
    """Intra-depot mutation: in one depot's group, one of three changes, each as likely.

    Reversal of a stretch between two cuts; single task re-routing, one task put to its best place in the group; or a
    swap of two tasks.
    """
    m = len(sizes)
    k = rng.integers(0, m)
    if sizes[k] < 2:
        return
    first, size = sizes[:k].sum(), sizes[k]
    kind = rng.integers(0, 3)
    a, b = first + rng.integers(0, size), first + rng.integers(0, size)
    if kind == 0:
        if a > b:
            a, b = b, a
        while a < b:
            perm[a], perm[b] = perm[b], perm[a]
            a, b = a + 1, b - 1
    elif kind == 1:
        move_task(cost, perm, sizes, totals, perm[a], np.arange(m) == k, n)
    else:
        perm[a], perm[b] = perm[b], perm[a]


@njit(cache=True)
def inter_depot_mutation(
    cost: Floats, rng: Any, perm: Ints, sizes: Ints, totals: Floats, candidates: Bools, n: int
) -> None:  # pragma: no cover
    """Inter-depot mutation: move a random border-line task to its best place at another of its candidate depots."""
    border = np.flatnonzero(candidates.sum(axis=1) > 1)
    if len(border) == 0:
        return
    task = border[rng.integers(0, len(border))]
    first = 0
    for k in range(len(sizes)):
        last = first + sizes[k]
        for p in range(first, last):
            if perm[p] == task:
                elsewhere = candidates[task].copy()
                elsewhere[k] = False
                if elsewhere.any():
                    move_task(cost, perm, sizes, totals, task, elsewhere, n)
                return
        first = last


@njit(cache=True)
def move_task(
    cost: Floats, perm: Ints, sizes: Ints, totals: Floats, task: int, allowed: Bools, n: int
) -> None:  # pragma: no cover
    """Take `task` out and put it to its best place over the allowed depots."""
    marked = np.zeros(n, dtype=np.bool_)
    marked[task] = True
    remove_marked(cost, perm, sizes, totals, marked, n)
    insert_best(cost, perm, sizes, totals, task, allowed, n)
