"""AB-cycles: closed walks that take a leg of ring A and a leg of ring B in turn (Nagata & Kobayashi 2013).

The legs that only one of two rings has fall apart into such cycles, for at every node as many legs of A are left as of
B. To exchange the legs of A on one of them for those of B changes A in one region only. Y. Nagata, S. Kobayashi: A
powerful genetic algorithm using edge assembly crossover for the traveling salesman problem, INFORMS Journal on
Computing 25(2), 2013. Depots are at one place, hence one node: a walk that comes to one goes on from any.
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
    of B, and so on; begins (N+1,): where each begins, and where the last ends.
    left_a, left_b (N, 2), count_a, count_b (N,): neighbours by legs not walked yet; those of B have depot n for any
    depot, and its depots any depots' legs; walk (2N,): nodes of the walk under way, of depots those of A at which legs
    are exchanged; gone_a, gone_b (N,): where on the walk a node was left by a leg of A, of B, or −1, n for any depot.
    """

    nodes: Ints
    begins: Ints
    left_a: Ints
    left_b: Ints
    count_a: Ints
    count_b: Ints
    walk: Ints
    gone_a: Ints
    gone_b: Ints


def ab_room(nodes: int) -> AbCycles:
    """Return room for the cycles of two rings of so many nodes."""
    count, pairs, never = np.zeros(nodes, np.int64), np.zeros((nodes, 2), np.int64), np.full(nodes, -1)
    twice, begins = np.zeros(2 * nodes + 2, np.int64), np.zeros(nodes + 1, np.int64)
    left = pairs, pairs.copy(), count, count.copy()
    return AbCycles(twice, begins, *left, twice.copy(), never, never.copy())


@njit(cache=True, nogil=True)
def _before(order: Ints, i: int) -> int:
    """Return the node before position i of a ring."""
    return order[i - 1 if i > 0 else order.size - 2]


@njit(cache=True, nogil=True)
def _strike(left: Ints, count: Ints, v: int, w: int) -> None:
    """Take a leg from v to w off those not walked yet at v."""
    if left[v, 0] == w:
        left[v, 0] = left[v, 1]
    count[v] -= 1


@njit(cache=True, nogil=True)
def _merged(v: int, n: int) -> int:
    """Return the node, n for every depot: they are at one place."""
    return min(v, n)


@njit(cache=True, nogil=True)
def _add(left: Ints, count: Ints, v: int, w: int) -> None:
    """Add a leg from v to w to those not walked yet at v."""
    left[v, count[v]] = w
    count[v] += 1


@njit(cache=True, nogil=True)
def _add_missing(mine: tuple[int, int], other: tuple[int, int], v: int, n: int, left: Ints, count: Ints) -> None:
    """Add the legs to those of a task's two neighbours that are not neighbours in the other ring."""
    x, y = other
    for w in mine:
        if _merged(w, n) == x:
            x = -1
        elif _merged(w, n) == y:
            y = -1
        else:
            _add(left, count, v, w)


@njit(cache=True, nogil=True)
def _lay_out(a: GiantTour, b: GiantTour, cycles: AbCycles) -> None:
    """Write the legs that only one of the rings has."""
    n, ends = cycles.count_a.size - a.starts.size + 1, 0
    left_a, left_b, count_a, count_b = cycles.left_a, cycles.left_b, cycles.count_a, cycles.count_b
    for room in (count_a, count_b):
        room[:] = 0
    for room in (cycles.gone_a, cycles.gone_b):
        room[:] = -1
    for v in range(n):
        i, j = a.position[v], b.position[v]
        p, s, x, y = _before(a.order, i), a.order[i + 1], _before(b.order, j), b.order[j + 1]
        x, y = _merged(x, n), _merged(y, n)
        _add_missing((p, s), (x, y), v, n, left_a, count_a)
        _add_missing((x, y), (_merged(p, n), _merged(s, n)), v, n, left_b, count_b)
        for w in left_a[v, : count_a[v]]:
            if w >= n:
                _add(left_a, count_a, w, v)
        for w in left_b[v, : count_b[v]]:
            if w == n:
                _add(left_b, count_b, n + ends // 2, v)
                ends += 1
    _lay_out_empty(a, b, cycles, ends)


@njit(cache=True, nogil=True)
def _lay_out_empty(a: GiantTour, b: GiantTour, cycles: AbCycles, ends: int) -> None:
    """Write the legs from depot to depot, empty tours, that one ring has more of; B's depots have so many legs yet."""
    n, empty = cycles.count_a.size - a.starts.size + 1, 0
    for i in b.starts[:-1]:
        empty += b.order[i + 1] >= n
    for i in a.starts[:-1]:
        v, w = a.order[i], a.order[i + 1]
        if w >= n and empty > 0:
            empty -= 1
        elif w >= n:
            _add(cycles.left_a, cycles.count_a, v, w)
            _add(cycles.left_a, cycles.count_a, w, v)
    for end in range(ends, ends + 2 * empty):
        _add(cycles.left_b, cycles.count_b, n + end // 2, n)


@njit(cache=True, nogil=True)
def _any_depot(count: Ints, n: int, rng: Rng) -> int:
    """Return a depot with legs not walked yet, as often as it has such."""
    at = below(rng, count[n:].sum())
    v = n
    while at >= count[v]:
        at -= count[v]
        v += 1
    return v


@njit(cache=True, nogil=True)
def _fan_with(left: Ints, count: Ints, n: int, w: int) -> int:
    """Return a depot whose legs not walked yet have one to w."""
    v = n
    while not ((count[v] > 0 and left[v, 0] == w) or (count[v] > 1 and left[v, 1] == w)):
        v += 1
    return v


@njit(cache=True, nogil=True)
def _keep(cycles: AbCycles, n: int, begin: int, end: int, last_is_a: bool, at: int) -> int:
    """Write the part begin..end of the walk, which is closed, from `at` on, a leg of A first; return where it ends."""
    walk, nodes = cycles.walk, cycles.nodes
    first = end - 1 if last_is_a else begin
    for x in range(end - begin):
        nodes[at + x] = walk[begin + (first - begin + x) % (end - begin)]
    by_a = not last_is_a
    for x in range(begin, end):
        if by_a:
            cycles.gone_a[_merged(walk[x], n)] = -1
        else:
            cycles.gone_b[_merged(walk[x], n)] = -1
        by_a = not by_a
    return at + end - begin


@njit(cache=True, nogil=True)
def _leave_by_a(cycles: AbCycles, v: int, n: int, rng: Rng) -> tuple[int, int]:
    """Walk a leg of A from v or, if that is a depot, from any; return its ends."""
    left, count = cycles.left_a, cycles.count_a
    if v >= n:
        v = _any_depot(count, n, rng)
    w = left[v, below(rng, count[v])]
    _strike(left, count, v, w)
    _strike(left, count, w, v)
    return v, w


@njit(cache=True, nogil=True)
def _leave_by_b(cycles: AbCycles, v: int, n: int, rng: Rng) -> int:
    """Walk a leg of B from v; return where it leads to, n for any depot."""
    left, count = cycles.left_b, cycles.count_b
    at = _any_depot(count, n, rng) if v >= n else v
    w = left[at, below(rng, count[at])]
    _strike(left, count, at, w)
    back = _merged(v, n)
    _strike(left, count, _fan_with(left, count, n, back) if w == n else w, back)
    return w


@njit(cache=True, nogil=True)
def find_cycles(a: GiantTour, b: GiantTour, cycles: AbCycles, rng: Rng) -> int:
    """Write AB-cycles of two rings, drawn by walking at random; return how many there are."""
    _lay_out(a, b, cycles)
    walk, total = cycles.walk, cycles.count_a.size
    n = total - a.starts.size + 1
    found, at, first = 0, 0, below(rng, total)
    for shift in range(total):
        start = (first + shift) % total
        while cycles.count_a[start] > 0:
            v, length, by_a = start, 0, True
            while True:
                if by_a:
                    v, w = _leave_by_a(cycles, v, n, rng)
                    cycles.gone_a[_merged(v, n)] = length
                else:
                    w = _leave_by_b(cycles, v, n, rng)
                    cycles.gone_b[_merged(v, n)] = length
                walk[length] = v
                length += 1
                back = cycles.gone_b[_merged(w, n)] if by_a else cycles.gone_a[_merged(w, n)]
                if back >= 0:
                    if by_a:
                        walk[back], w = w, walk[back]
                    at = _keep(cycles, n, back, length, by_a, at)
                    found += 1
                    cycles.begins[found] = at
                    length = back
                v, by_a = w, not by_a
                if length == 0:
                    break
    return found
