"""Pairs of labels: ways from the depot and ways home that together are tours below a threshold.

A pair is one of labels F = (V_F, i) at cost t_F ≤ h and B = (V_B, j) at cost t_B, where h is half the cap:

    t_F + c_ij > h,    t_F + c_ij + t_B ≤ cap,    V_F ∩ V_B = ∅.

Its reduced cost is that of F, σ c_ij and that of B, and ρ_S of each cut of which either holds one task: these are bits,
and those of both meet in one operation. One is sought only where the completion bound of F extended to j says that
there may be one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.completion import bins_left
from formulations.routing.columns.cuts import half_held, paid_for
from formulations.routing.columns.label_search import Subproblem
from formulations.routing.columns.labelling import Store, memory_of
from formulations.routing.columns.word_sets import has, hashed, same
from instances.arrays import Floats, Ints
from instances.kernels import njit

PARTS = 1009
"""Into how many parts ways from the depot are divided, one of each so many."""


class WaysHome(NamedTuple):
    """Labels of the ways home, so ordered that most of those that make no pair are not looked at.

    Those of one first task j are divided by their costs into about as many slabs as each has labels, slab first[j] on;
    a slab begins `at`, costs at least `least` [s], and has the least value first.
    label, cost [s], visited (l, words) : of each; value : reduced costs [s]; half : cuts of which it holds one task.
    """

    first: Ints
    at: Ints
    least: Floats
    label: Ints
    value: Floats
    cost: Floats
    visited: NDArray[np.uint64]
    half: NDArray[np.uint64]

    @classmethod
    def of(cls, problem: Subproblem, store: Store, begin: int, end: int) -> WaysHome:
        """Put the labels begin..end−1 in order."""
        last, cost = store.last[begin:end].astype(np.int64), store.cost[begin:end]
        value = problem.sigma * cost - store.gain[begin:end]
        order = np.lexsort((cost, last))
        of_task = np.searchsorted(last[order], np.arange(problem.price.size + 1))
        slabs = np.ceil(np.sqrt(np.diff(of_task))).astype(np.int64)
        first, size = np.append(0, np.cumsum(slabs)), -(-np.diff(of_task) // np.maximum(slabs, 1))
        slab = first[last[order]] + (np.arange(order.size) - of_task[last[order]]) // size[last[order]]
        at = np.searchsorted(slab, np.arange(first[-1] + 1))
        least = np.append(cost[order], np.inf)[at[:-1]]  # the last slabs of a task may be empty
        order = order[np.lexsort((value[order], slab))]
        label = begin + order
        visited = store.visited[label]
        return cls(first, at, least, label, value[order], cost[order], visited, halves(visited, problem.cuts.bits))


class Pairs(NamedTuple):
    """Tours found as pairs of labels: `ahead`, `behind` (p,), reduced costs and costs (p,) [s], sets (p, words)."""

    ahead: Ints
    behind: Ints
    value: Floats
    cost: Floats
    visited: NDArray[np.uint64]

    @classmethod
    def room_for(cls, most: int, words: int) -> Pairs:
        """Make room, which takes no memory before it is used."""
        ahead, behind = np.empty((2, most), np.int64)
        return cls(ahead, behind, np.empty(most), np.empty(most), np.empty((most, words), np.uint64))

    def only(self, first: int) -> Pairs:
        """Return the first ones."""
        ahead, behind, value, cost, visited = self
        return Pairs(ahead[:first], behind[:first], value[:first], cost[:first], visited[:first])


@njit(cache=True, nogil=True)
def halves(visited: NDArray[np.uint64], bits: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return, of each set, the numbers of the cuts of which it holds exactly one task, (l, words)."""
    half = np.zeros((visited.shape[0], bits.shape[1]), np.uint64)
    for label in range(visited.shape[0]):
        half_held(visited[label], bits, half[label])
    return half


@njit(cache=True, nogil=True)
def join(
    problem: Subproblem,
    store: Store,
    half: NDArray[np.uint64],
    home: WaysHome,
    threshold: float,
    part: int,
    middle: int,
    pairs: Pairs,
    found: int,
    limit: int,
) -> tuple[bool, int, int]:
    """Pair one part of the labels before `middle` with ways home, into `pairs`, of which `found` are there already.

    half : the numbers of the cuts of which each label holds one task.
    Of the pairs of one set the cheapest is kept; the store's table says where. Return whether there was room, for no
    more than `limit` pairs, how many tours there are now, and how many pairs made them.
    """
    order, degree, bins, cap = problem.bins.order, problem.bins.degree, problem.bins, problem.cap
    near, members, words, tried = problem.memory.near, problem.watch.members, store.visited.shape[1], 0
    bits, prices = problem.cuts.bits, problem.cuts.prices
    together = np.zeros(words, np.uint64)
    for label in range(part, middle, PARTS):
        if store.bound[label] >= threshold:
            continue
        here, seen, time = store.last[label], store.visited[label], store.cost[label]
        most = bins_left(cap - time, bins)
        for a in range(degree[here]):
            j = order[here, a]
            if bins.fewest[here, j] > most:
                break
            spent = time + bins.cost[0, here, j]
            if spent <= problem.reach or not spent <= cap or has(seen, j):
                continue
            value, left = problem.sigma * spent - store.gain[label], bins_left(cap - spent, bins)
            if value - problem.price[j] + problem.least[j, left] >= threshold:  # with nothing remembered: most end here
                continue
            beyond = problem.best[j, left, memory_of(near, members, seen, j)] + paid_for(half[label], bits[j], prices)
            if value - problem.price[j] + beyond >= threshold:
                continue
            for slab in range(home.first[j], home.first[j + 1]):
                if spent + home.least[slab] > cap:
                    break
                for b in range(home.at[slab], home.at[slab + 1]):
                    total, whole = value + home.value[b], spent + home.cost[b]
                    if total >= threshold:
                        break
                    if whole > cap or not _apart(seen, home.visited[b]):
                        continue
                    total += paid_for(half[label], home.half[b], prices)
                    if total >= threshold:
                        continue
                    tried += 1
                    for w in range(words):
                        together[w] = seen[w] | home.visited[b, w]
                    at = _place(store.slots, pairs.visited, together, found)
                    if at == found:
                        if found == pairs.cost.size or tried > limit:
                            return False, found, tried
                        found = _taken(store.slots, pairs, together, found)
                    if whole < pairs.cost[at]:
                        pairs.ahead[at], pairs.behind[at] = label, home.label[b]
                        pairs.value[at], pairs.cost[at] = total, whole
    return True, found, tried


@njit(cache=True, nogil=True, inline="always")
def _apart(a: NDArray[np.uint64], b: NDArray[np.uint64]) -> bool:
    """Say whether two sets have nothing in common."""
    apart = True
    for w in range(a.size):
        apart = apart and a[w] & b[w] == np.uint64(0)
    return apart


@njit(cache=True, nogil=True, inline="always")
def _place(slots: NDArray[np.int32], sets: NDArray[np.uint64], words: NDArray[np.uint64], none: int) -> int:
    """Return which of the sets in a table this is, `none` where it is not there."""
    mask = slots.size - 1
    slot = hashed(words, 0, mask)
    while slots[slot] >= 0 and not same(sets[slots[slot]], words):
        slot = (slot + 1) & mask
    return slots[slot] if slots[slot] >= 0 else none


@njit(cache=True, nogil=True)
def _taken(slots: NDArray[np.int32], pairs: Pairs, words: NDArray[np.uint64], at: int) -> int:
    """Put a new set into the table, its pair still to come, and return how many there are now."""
    mask = slots.size - 1
    slot = hashed(words, 0, mask)
    while slots[slot] >= 0:
        slot = (slot + 1) & mask
    slots[slot] = at
    for w in range(words.size):
        pairs.visited[at, w] = words[w]
    pairs.cost[at] = np.inf
    return at + 1
