"""Subset-row cuts on three tasks: at most one tour may hold two or more of them.

For S = {i, j, l}:  Σ_k Σ_p ⌊|S ∩ p| / 2⌋ λ_p ≤ 1  (Jepsen, Petersen, Spoorendonk, Pisinger, "Subset-row inequalities
applied to the vehicle-routing problem with time windows", Oper. Res. 56, 2008). With duals ρ_S ≥ 0 the Lagrangian bound
loses Σρ and a tour that holds two of S pays ρ_S more. As labels know their whole set, they pay exactly.

Completion bounds B that know nothing of cuts are valid, as ρ ≥ 0, but fall far behind once prices have risen against
them. So each task watches a few cuts, and B gets more state: beside the tasks remembered, a bit for each of the q cuts
watched at a task, set where the path holds one of the three tasks, and has not paid yet. Arriving at a member pays ρ_S
and clears a set bit, and sets a clear one; at a task that does not watch S the bit is forgotten. That is the limited
memory of Pecin, Pessoa, Poggi, Uchoa ("Improved branch-cut-and-price for capacitated vehicle routing", Math. Program.
Comput. 9, 2017), and forgetting only ever lowers what is paid: B stays a lower bound.
For a label the bit of S is set exactly where one task of S is visited, so all that B can still charge is due.
A clear bit is never charged more than a set one, hence state 0 remains the least restricted of all.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.word_sets import lowest
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


def pays(holds: Bools, cuts: Sequence[Cut]) -> Bools:
    """Return which tour, of those of `incidence` (p, n), holds two tasks or more of which cut, shape (p, cuts)."""
    members = np.array(cuts, np.int64).reshape(-1, 3).T
    first, second, third = (holds[:, tasks] for tasks in members)
    return np.asarray(first & second | first & third | second & third)


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


@njit(cache=True, nogil=True)
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
    """A task's priced cuts: `rho` (n, q) [s], 0 where none; their other tasks `partners` (n, q, 2), −1 where none.

    bits (n, words) : the same as a set of numbers, of which `prices` (c,) [s] are the ρ.
    """

    partners: Ints
    rho: Floats
    bits: NDArray[np.uint64]
    prices: Floats


def by_task(cuts: Sequence[Cut], rho: Floats, n_tasks: int) -> TaskCuts:
    """Return the cuts of each task."""
    member: list[list[tuple[int, int, float]]] = [[] for _ in range(n_tasks)]
    prices = rho[rho > 0]
    bits, number = np.zeros((n_tasks, (prices.size + 63) // 64), np.uint64), 0
    for (i, j, k), price in zip(cuts, rho, strict=True):
        if price > 0:
            member[i].append((j, k, price))
            member[j].append((i, k, price))
            member[k].append((i, j, price))
            bits[[i, j, k], number >> 6] |= np.uint64(1) << np.uint64(number & 63)
            number += 1
    widest = max((len(q) for q in member), default=0)
    partners, price = np.full((n_tasks, widest, 2), -1, np.int64), np.zeros((n_tasks, widest))
    for i, q in enumerate(member):
        for a, (j, k, r) in enumerate(q):
            partners[i, a], price[i, a] = (j, k), r
    return TaskCuts(partners, price, bits, prices)


@njit(cache=True, nogil=True, inline="always")
def held(words: NDArray[np.uint64], bits: NDArray[np.uint64], c: int) -> tuple[np.uint64, np.uint64]:
    """Return the c-th word of the numbers of the cuts of which a set of tasks holds one or more, and two or more."""
    once, twice = np.uint64(0), np.uint64(0)
    for w in range(words.size):
        rest = words[w]
        while rest != np.uint64(0):
            of_task = bits[64 * w + lowest(rest), c]
            rest &= rest - np.uint64(1)
            twice |= once & of_task
            once |= of_task
    return once, twice


@njit(cache=True, nogil=True)
def half_held(words: NDArray[np.uint64], bits: NDArray[np.uint64], half: NDArray[np.uint64]) -> None:
    """Write to `half` the numbers of the cuts of which a set holds exactly one task: a second one pays for these."""
    for c in range(half.size):
        once, twice = held(words, bits, c)
        half[c] = once & ~twice


@njit(cache=True, nogil=True, inline="always")
def paid_for(a: NDArray[np.uint64], b: NDArray[np.uint64], prices: Floats) -> float:
    """Return the sum of the prices [s] of the cuts in both of two sets of numbers."""
    total = 0.0
    for w in range(a.size):
        rest = a[w] & b[w]
        while rest != np.uint64(0):
            total += prices[64 * w + lowest(rest)]
            rest &= rest - np.uint64(1)
    return total


_PASSING = 0.25
"""Weight of a cut, for each of its tasks that is near, at a task that is none of them."""


class Watch(NamedTuple):
    """Which cuts are watched where.

    members : the tasks of the r-th cut watched at task i, shape (n, q, 3), −1 where there is none.
    turn : turn[i, j, c], the bits at j after i was left with bits c, shape (n, n, 2^q).
    charge : what arriving at j then costs [s], shape (n, n, 2^q).
    """

    members: Ints
    turn: NDArray[np.int16]
    charge: Floats

    @classmethod
    def of(cls, near: Ints, cuts: Sequence[Cut], rho: Floats, most: int) -> Watch:
        """Watch at each task up to `most` cuts: dear ones that hold it, or some of the tasks `near` it, (n, g)."""
        n = near.shape[0]
        priced = np.flatnonzero(rho > 0)
        q = min(most, priced.size)
        if q == 0:
            return cls(np.zeros((n, 0, 3), np.int64), np.zeros((n, n, 1), np.int16), np.zeros((n, n, 1)))
        sets = np.array(cuts, np.int64)[priced]
        holds = np.zeros((n, n), np.bool_)
        np.put_along_axis(holds, near, True, axis=1)
        worth = _PASSING * holds[:, sets].sum(axis=2)
        worth[sets, np.arange(priced.size)[:, None]] = 1.0
        worth = worth * rho[priced]
        chosen = np.argsort(-worth, axis=1, kind="stable")[:, :q]
        watched = np.where(np.take_along_axis(worth, chosen, axis=1) > 0, chosen, -1)
        members = np.where(watched[:, :, None] >= 0, sets[watched], -1)
        return cls(members, *_turns(watched, sets, rho[priced]))


@njit(cache=True, nogil=True)
def _turns(watched: Ints, sets: Ints, rho: Floats) -> tuple[NDArray[np.int16], Floats]:
    """Return `turn` and `charge` of a Watch from the cuts `watched` at each task, (n, q), their tasks and prices."""
    n, q = watched.shape
    turn, charge = np.zeros((n, n, 1 << q), np.int16), np.zeros((n, n, 1 << q))
    for i in range(n):
        for j in range(n):
            for bits in range(1 << q):
                for r in range(q):
                    s = watched[i, r]
                    if bits >> r & 1 and s >= 0 and _holds(sets, s, j):
                        charge[i, j, bits] += rho[s]
                for r in range(q):
                    s = watched[j, r]
                    if s < 0:
                        continue
                    before = False
                    for t in range(q):
                        before = before or (watched[i, t] == s and bits >> t & 1 != 0)
                    if before != _holds(sets, s, j):
                        turn[i, j, bits] |= 1 << r
    return turn, charge


@njit(cache=True, nogil=True)
def _holds(sets: Ints, s: int, task: int) -> bool:
    return sets[s, 0] == task or sets[s, 1] == task or sets[s, 2] == task
