"""Subset-row cuts on three tasks: at most one tour may hold two or more of them.

For S = {i, j, l}:  Σ_k Σ_p ⌊|S ∩ p| / 2⌋ λ_p ≤ 1  (Jepsen, Petersen, Spoorendonk, Pisinger, "Subset-row inequalities
applied to the vehicle-routing problem with time windows", Oper. Res. 56, 2008). With duals ρ_S ≥ 0 the Lagrangian bound
loses Σρ and a tour that holds two of S pays ρ_S more. As labels know their whole set, they pay exactly; the completion
bounds leave ρ out and stay valid, since ρ ≥ 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit

Cut = tuple[int, int, int]

_VIOLATION = 0.03
_PER_TASK = 4


def incidence(tours: Sequence[Sequence[int]], n_tasks: int) -> Bools:
    """Return which tour holds which task, a_ip, shape (p, n)."""
    holds = np.zeros((len(tours), n_tasks), np.bool_)
    for row, tasks in enumerate(tours):
        holds[row, list(tasks)] = True
    return holds


def separate(tours: Sequence[Sequence[int]], weight: Floats, n_tasks: int, known: set[Cut], most: int) -> list[Cut]:
    """Return up to `most` new cuts that Σ weight·[two of S in the tour] ≤ 1 violates, the worst first."""
    used = np.flatnonzero(weight > 1e-6)
    triples, excess = _violated(incidence([tours[int(p)] for p in used], n_tasks), weight[used], _VIOLATION)
    chosen: list[Cut] = []
    times = np.zeros(n_tasks, np.int64)
    for t in np.lexsort((*triples.T[::-1], -excess.round(9))):
        cut = (int(triples[t, 0]), int(triples[t, 1]), int(triples[t, 2]))
        if cut not in known and times[list(cut)].max() < _PER_TASK:
            chosen.append(cut)
            times[list(cut)] += 1
        if len(chosen) == most:
            break
    return chosen


@njit(cache=True)
def _violated(holds: Bools, weight: Floats, least: float) -> tuple[Ints, Floats]:
    """Return all triples whose left-hand side exceeds 1 by `least`, and by how much they do."""
    rows, n = holds.shape
    pair = np.zeros((n, n))
    for p in range(rows):
        for i in range(n):
            if holds[p, i]:
                for j in range(i + 1, n):
                    if holds[p, j]:
                        pair[i, j] += weight[p]
    triples, excess = [], []
    for i in range(n):
        for j in range(i + 1, n):
            for k in range(j + 1, n):
                total = pair[i, j] + pair[i, k] + pair[j, k]
                if total <= 1 + least:
                    continue
                for p in range(rows):
                    if holds[p, i] and holds[p, j] and holds[p, k]:
                        total -= 2 * weight[p]
                if total > 1 + least:
                    triples.append((i, j, k))
                    excess.append(total - 1)
    found = np.zeros((len(triples), 3), np.int64)
    for t in range(len(triples)):
        found[t, 0], found[t, 1], found[t, 2] = triples[t]
    return found, np.array(excess)


class TaskCuts(NamedTuple):
    """The cuts of each task that have a price: their other two tasks, `partners` (n, q, 2), −1 where none; `rho` (n, q)
    [s], 0 where none.
    """

    partners: Ints
    rho: Floats


def by_task(cuts: Sequence[Cut], rho: Floats, n_tasks: int) -> TaskCuts:
    """Return the cuts of each task."""
    member: list[list[tuple[int, int, float]]] = [[] for _ in range(n_tasks)]
    for (i, j, k), price in zip(cuts, rho, strict=True):
        if price > 0:
            member[i].append((j, k, price))
            member[j].append((i, k, price))
            member[k].append((i, j, price))
    widest = max((len(q) for q in member), default=0)
    partners, price = np.full((n_tasks, widest, 2), -1, np.int64), np.zeros((n_tasks, widest))
    for i, q in enumerate(member):
        for a, (j, k, r) in enumerate(q):
            partners[i, a], price[i, a] = (j, k), r
    return TaskCuts(partners, price)
