"""AB-cycles: closed walks that take a leg of ring A and a leg of ring B in turn (Nagata & Kobayashi 2013).

The legs that only one of two rings has fall apart into such cycles, for at every node as many legs of A are left as of
B. To exchange the legs of A on one of them for those of B changes A in one region only. Y. Nagata, S. Kobayashi: A
powerful genetic algorithm using edge assembly crossover for the traveling salesman problem, INFORMS Journal on
Computing 25(2), 2013. Depots are at one place: those of B are called what those of A with the same neighbours are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.giant_tour import GiantTour
from formulations.routing.search.randomness import Rng, below
from instances.arrays import Ints
from instances.kernels import njit


class AbCycles(NamedTuple):
    """Cycles of two rings of N nodes, and room to find them.

    nodes (2N,): of all cycles, one after the other; the leg from a cycle's first node to its second is of A, the next
    of B, and so on; begins (N+1,): where each begins, and where the last ends; pick (N,): numbers of cycles not tried.
    beside (N, 2): neighbours in B; left_a, left_b (N, 2), count_a, count_b (N,): neighbours by legs not walked yet;
    walk (2N,): nodes of the walk under way; gone_a, gone_b (N,): where on the walk a node was left by a leg of A, of
    B, or −1; name (N,): what B's nodes are called in A.
    """

    nodes: Ints
    begins: Ints
    pick: Ints
    beside: Ints
    left_a: Ints
    left_b: Ints
    count_a: Ints
    count_b: Ints
    walk: Ints
    gone_a: Ints
    gone_b: Ints
    name: Ints


def ab_room(nodes: int) -> AbCycles:
    """Return room for the cycles of two rings of so many nodes."""
    once, pairs, never = np.zeros(nodes, np.int64), np.zeros((nodes, 2), np.int64), np.full(nodes, -1)
    twice, begins = np.zeros(2 * nodes + 2, np.int64), np.zeros(nodes + 1, np.int64)
    four = pairs.copy(), pairs.copy(), pairs.copy(), once.copy(), once.copy()
    return AbCycles(twice, begins, once, *four, twice.copy(), never, never.copy(), once.copy())


@njit(cache=True, nogil=True)
def _before(order: Ints, i: int) -> int:
    """Return the node before position i of a ring."""
    return order[i - 1 if i > 0 else order.size - 2]


@njit(cache=True, nogil=True)
def _name_depots(a: GiantTour, b: GiantTour, name: Ints) -> None:
    """Name each depot of B like one of A with as many neighbours in common as there is; tasks keep their names."""
    m = a.starts.size - 1
    n = name.size - m
    for v in range(name.size):
        name[v] = v
    used, named = np.zeros(m, np.bool_), np.zeros(m, np.bool_)
    for common in range(2, -1, -1):
        for i in b.starts[:m]:
            x, y = _before(b.order, i), b.order[i + 1]
            for j in a.starts[:m]:
                e, d = b.order[i] - n, a.order[j] - n
                if named[e] or used[d]:
                    continue
                u, w = _before(a.order, j), a.order[j + 1]
                if (x < n and x in (u, w)) + (y < n and y in (u, w)) >= common:
                    name[n + e] = n + d
                    named[e] = used[d] = True


@njit(cache=True, nogil=True)
def _strike(left: Ints, count: Ints, v: int, w: int) -> None:
    """Take the leg between v and w off those not walked yet."""
    if left[v, 0] == w:
        left[v, 0] = left[v, 1]
    count[v] -= 1
    if left[w, 0] == v:
        left[w, 0] = left[w, 1]
    count[w] -= 1


@njit(cache=True, nogil=True)
def _lay_out(a: GiantTour, b: GiantTour, cycles: AbCycles) -> None:
    """Write the legs that only one of the rings has."""
    _name_depots(a, b, cycles.name)
    name, beside = cycles.name, cycles.beside
    for i in range(name.size):
        v = name[b.order[i]]
        beside[v, 0], beside[v, 1] = name[_before(b.order, i)], name[b.order[i + 1]]
    for i in range(name.size):
        v, p, s = a.order[i], _before(a.order, i), a.order[i + 1]
        x, y = beside[v]
        cycles.gone_a[v] = cycles.gone_b[v] = -1
        cycles.count_a[v] = cycles.count_b[v] = 0
        for w in (p, s):
            if w not in (x, y):
                cycles.left_a[v, cycles.count_a[v]] = w
                cycles.count_a[v] += 1
        for w in (x, y):
            if w not in (p, s):
                cycles.left_b[v, cycles.count_b[v]] = w
                cycles.count_b[v] += 1


@njit(cache=True, nogil=True)
def _keep(cycles: AbCycles, begin: int, end: int, last_is_a: bool, at: int) -> int:
    """Write the part begin..end of the walk, which is closed, from `at` on, a leg of A first; return where it ends."""
    walk, nodes = cycles.walk, cycles.nodes
    first = end - 1 if last_is_a else begin
    for x in range(end - begin):
        nodes[at + x] = walk[begin + (first - begin + x) % (end - begin)]
    by_a = not last_is_a
    for x in range(begin, end):
        if by_a:
            cycles.gone_a[walk[x]] = -1
        else:
            cycles.gone_b[walk[x]] = -1
        by_a = not by_a
    return at + end - begin


@njit(cache=True, nogil=True)
def find_cycles(a: GiantTour, b: GiantTour, cycles: AbCycles, rng: Rng) -> int:
    """Write AB-cycles of two rings, drawn by walking at random; return how many there are."""
    _lay_out(a, b, cycles)
    walk, total = cycles.walk, cycles.name.size
    found, at, first = 0, 0, below(rng, total)
    for shift in range(total):
        start = (first + shift) % total
        while cycles.count_a[start] > 0:
            v, length, by_a = start, 0, True
            while True:
                walk[length] = v
                left, count = (cycles.left_a, cycles.count_a) if by_a else (cycles.left_b, cycles.count_b)
                w = left[v, below(rng, count[v]) if count[v] > 1 else 0]
                _strike(left, count, v, w)
                if by_a:
                    cycles.gone_a[v] = length
                else:
                    cycles.gone_b[v] = length
                length += 1
                back = cycles.gone_b[w] if by_a else cycles.gone_a[w]
                if back >= 0:
                    at = _keep(cycles, back, length, by_a, at)
                    found += 1
                    cycles.begins[found] = at
                    length = back
                v, by_a = w, not by_a
                if length == 0:
                    break
    for i in range(found):
        cycles.pick[i] = i
    return found
