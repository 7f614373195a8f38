"""Iterated local search for the order of one tour's tasks, by descent and double bridges.

Ruin and recreate sees a dozen tasks at a time, and the energy hardly sees tours below the longest: long tours are left
in orders that a search for one tour alone improves. The descent goes through 2-opt, priced for asymmetric costs by
prefix sums, and the exchange of two adjacent segments of any length (or-3opt: of the 3-opt moves the one that reverses
nothing), as long as the sum of what is gained stays positive (Lin & Kernighan 1973). A double bridge (Martin, Otto,
Felten 1991) of short segments then kicks it, and what got worse is taken back.
Works on a copy of one tour's costs: nodes 0 (the depot) to L; positions run from 0 (depot) over 1..L to L+1 (depot).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search import concatenation
from formulations.routing.search.concatenation import Segments
from formulations.routing.search.costs import AlikeCosts, Costs, leg
from formulations.routing.search.problem_data import Nodes, keep_nearest
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.tours import Tours, clear, fill, sum_costs
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


class LocalSearchParameters(NamedTuple):
    """How far the search of one tour goes.

    near: nodes that a move may make the next or the one before; 5 to 10 are usual since Lin & Kernighan (1973).
    span: tasks of a segment of a double bridge, at most: short ones leave the descent little to look at.
    gain: share of the tour's cost below which a gain counts as rounding.
    fewest: tasks of a tour, at least; shorter ones the annealing leaves in the best order.
    most: tasks of a tour, at most: the matrices of one of 8000 take 1 GB.
    """

    near: int = 8
    span: int = 10
    gain: float = 1e-9
    fewest: int = 8
    most: int = 8000


class ClosedTour(NamedTuple):
    """One tour at work.

    costs: legs (L+1, L+1) [s]; segments: the order and its prefix sums; ahead, behind (L+1, q): the nodes cheapest to
    fly to from, and to come from to, each node; position (L+1,): the place of each node, 0 for the depot; spare (L+2,):
    room; queue (L+1,): nodes to look at, a ring (don't-look bits, Bentley 1992); queued (L+1,): whether in it;
    ring (2,): its first place and length.
    """

    costs: AlikeCosts
    segments: Segments
    ahead: Nodes
    behind: Nodes
    position: Ints
    spare: Nodes
    queue: Ints
    queued: Bools
    ring: Ints
    parameters: LocalSearchParameters


@njit(cache=True, nogil=True)
def closed_tour(cost: Floats, parameters: LocalSearchParameters) -> ClosedTour:
    """Return the tour 0, 1, …, L, 0 over `cost`, shape (L+1, L+1) [s], ready to be improved."""
    size = cost.shape[0]
    near = min(parameters.near, size - 1)
    into = np.empty((size, size))
    for u in range(size):
        for w in range(size):
            into[w, u] = cost[u, w]
    costs = AlikeCosts(cost, into)
    ahead, behind = np.zeros((size, near), np.int32), np.zeros((size, near), np.int32)
    for v in range(size):
        keep_nearest(costs.out[v], costs.out[v], v, 0, ahead[v])
        keep_nearest(costs.into[v], costs.into[v], v, 0, behind[v])
    segments, position = concatenation.empty_segments(costs, size - 1), np.empty(size, np.int64)
    spare = np.zeros(size + 1, np.int32)
    queue, queued, ring = np.zeros(size, np.int64), np.zeros(size, np.bool_), np.zeros(2, np.int64)
    tour = ClosedTour(costs, segments, ahead, behind, position, spare, queue, queued, ring, parameters)
    segments.shape[1] = size - 1
    for i in range(size):
        position[i] = segments.nodes[i] = i
    segments.nodes[size] = 0
    segments.forward[0] = segments.backward[0] = 0.0
    book(tour, 1)
    return tour


@njit(cache=True, nogil=True)
def book(tour: ClosedTour, low: int) -> None:
    """Recompute places and prefix sums from position `low` ≥ 1 on."""
    nodes, out, forward, backward = tour.segments.nodes, tour.costs.out, tour.segments.forward, tour.segments.backward
    for i in range(low, nodes.size):
        u, w = nodes[i - 1], nodes[i]
        forward[i] = forward[i - 1] + out[u, w]
        backward[i] = backward[i - 1] + out[w, u]
        if w > 0:
            tour.position[w] = i


@njit(cache=True, nogil=True)
def reversal_gain(tour: ClosedTour, i: int, j: int) -> float:
    """Return what the tour saves [s] with positions i..j reversed, 1 ≤ i ≤ j ≤ L."""
    return -concatenation.two_opt_change(tour.costs, tour.segments, i, j)


@njit(cache=True, nogil=True)
def reverse(tour: ClosedTour, i: int, j: int) -> None:
    """Reverse positions i..j and queue the nodes at their ends."""
    for p in (i - 1, i, j, j + 1):
        _enqueue(tour, p)
    low, nodes = i, tour.segments.nodes
    while i < j:
        nodes[i], nodes[j] = nodes[j], nodes[i]
        i, j = i + 1, j - 1
    book(tour, low)


@njit(cache=True, nogil=True)
def exchange_gain(tour: ClosedTour, p: int, q: int, r: int) -> float:
    """Return what the tour saves [s] with positions p+1..q and q+1..r exchanged, 0 ≤ p < q < r ≤ L."""
    out, into = concatenation.or_opt_changes(tour.costs, tour.segments, p + 1, q, tour.segments, r, False)
    return -(out + into)


@njit(cache=True, nogil=True)
def exchange(tour: ClosedTour, p: int, q: int, r: int) -> None:
    """Exchange positions p+1..q and q+1..r and queue the nodes at their ends."""
    for i in (p, p + 1, q, q + 1, r, r + 1):
        _enqueue(tour, i)
    spare, nodes = tour.spare, tour.segments.nodes
    _copy(nodes, p + 1, q - p, spare, 0)
    for i in range(q + 1, r + 1):
        nodes[i - q + p] = nodes[i]
    _copy(spare, 0, q - p, nodes, p + 1 + r - q)
    book(tour, p + 1)


@njit(cache=True, nogil=True)
def _copy(source: Nodes, first: int, count: int, target: Nodes, to: int) -> None:
    """Write source[first : first + count] to target[to : to + count], none of it to itself."""
    for i in range(count):
        target[to + i] = source[first + i]


@njit(cache=True, nogil=True)
def _enqueue(tour: ClosedTour, i: int) -> None:
    """Queue the node at position i."""
    v, ring = tour.segments.nodes[i], tour.ring
    if not tour.queued[v]:
        tour.queued[v] = True
        tour.queue[(ring[0] + ring[1]) % tour.queue.size] = v
        ring[1] += 1


@njit(cache=True, nogil=True)
def _improve_by_two_opt(tour: ClosedTour, v: int, least: float) -> bool:
    """Try to bring v next to a near node by a reversal; return whether one gained more than `least` [s]."""
    last = tour.position.size - 1
    i = tour.position[v]
    for x in tour.ahead[v]:
        j = tour.position[x] if x > 0 else last + 1
        for low, high in ((i + 1, j), (i, j - 1)):
            if 1 <= low < high <= last and reversal_gain(tour, low, high) > least:
                reverse(tour, low, high)
                return True
    i = i if v > 0 else last + 1
    for x in tour.behind[v]:
        j = tour.position[x]
        for low, high in ((j + 1, i), (j, i - 1)):
            if 1 <= low < high <= last and reversal_gain(tour, low, high) > least:
                reverse(tour, low, high)
                return True
    return False


@njit(cache=True, nogil=True)
def _improve_by_exchange(tour: ClosedTour, v: int, least: float) -> bool:
    """Try to let a near node follow v by an exchange of two segments; return whether one gained more than `least` [s].

    v is the end before the first segment (x begins the second), the end of the first (x follows the second), or the
    end of the second (x begins the first); what the third leg costs is looked for among near nodes too.
    """
    nodes, cost, position = tour.segments.nodes, tour.costs.out, tour.position
    last = position.size - 1
    i = position[v]
    after = nodes[i + 1]
    for x in tour.ahead[v]:
        gain = cost[v, after] - cost[v, x]
        if gain <= 0.0:
            return False
        j = position[x] if x > 0 else last + 1
        gain += cost[nodes[j - 1], x]
        if j > i + 1:
            if x > 0:
                for y in tour.ahead[nodes[j - 1]]:
                    if gain - cost[nodes[j - 1], y] <= 0.0:
                        break
                    t = position[y] if y > 0 else last + 1
                    if t > j and exchange_gain(tour, i, j - 1, t - 1) > least:
                        exchange(tour, i, j - 1, t - 1)
                        return True
            for z in tour.behind[after]:
                if position[z] < i and exchange_gain(tour, position[z], i, j - 1) > least:
                    exchange(tour, position[z], i, j - 1)
                    return True
        elif 1 <= j < i:
            for y in tour.ahead[nodes[j - 1]]:
                if gain - cost[nodes[j - 1], y] <= 0.0:
                    break
                t = position[y]
                if j < t <= i and exchange_gain(tour, j - 1, t - 1, i) > least:
                    exchange(tour, j - 1, t - 1, i)
                    return True
    return False


@njit(cache=True, nogil=True)
def descend(tour: ClosedTour) -> None:
    """Make improving moves around the queued nodes until there is none."""
    ring = tour.ring
    while ring[1] > 0:
        v = tour.queue[ring[0]]
        ring[0] = (ring[0] + 1) % tour.queue.size
        ring[1] -= 1
        tour.queued[v] = False
        least = tour.parameters.gain * tour.segments.forward[-1]
        while _improve_by_exchange(tour, v, least) or _improve_by_two_opt(tour, v, least):
            pass


@njit(cache=True, nogil=True)
def _double_bridge(tour: ClosedTour, rng: Rng) -> None:
    """Put three consecutive short segments in reverse order, none of them reversed."""
    last = tour.position.size - 1
    span = min(tour.parameters.span, last // 3)
    a, b, c = 1 + below(rng, span), 1 + below(rng, span), 1 + below(rng, span)
    p = below(rng, last - a - b - c + 1)
    nodes, spare = tour.segments.nodes, tour.spare
    for i in (p, p + 1, p + a, p + a + 1, p + a + b, p + a + b + 1, p + a + b + c, p + a + b + c + 1):
        _enqueue(tour, i)
    _copy(nodes, p + a + b + 1, c, spare, 0)
    _copy(nodes, p + a + 1, b, spare, c)
    _copy(nodes, p + 1, a, spare, c + b)
    _copy(spare, 0, a + b + c, nodes, p + 1)
    book(tour, p + 1)


@njit(cache=True, nogil=True)
def improve(tour: ClosedTour, rng: Rng, kicks: int) -> None:
    """Improve the order by a descent from all nodes and `kicks` kicks, each followed by a descent around it."""
    for i in range(tour.position.size):
        _enqueue(tour, i)
    descend(tour)
    if tour.position.size < 4:
        return
    kept, best = tour.segments.nodes.copy(), tour.segments.forward[-1]
    for _ in range(kicks):
        _double_bridge(tour, rng)
        descend(tour)
        if tour.segments.forward[-1] <= best:
            _copy(tour.segments.nodes, 0, kept.size, kept, 0)
            best = tour.segments.forward[-1]
        else:
            _copy(kept, 0, kept.size, tour.segments.nodes, 0)
            book(tour, 1)


@njit(cache=True, nogil=True)
def intensify(costs: Costs, tours: Tours, rng: Rng, kicks: float, parameters: LocalSearchParameters) -> None:
    """Improve the order of every tour, in place, with `kicks` double bridges for each of its tasks."""
    for k in range(tours.cost.size):
        if parameters.fewest <= tours.size[k] <= parameters.most:
            _intensify_one(costs, tours, k, rng, kicks, parameters)
    sum_costs(tours)


@njit(cache=True, nogil=True)
def _intensify_one(
    costs: Costs, tours: Tours, k: int, rng: Rng, kicks: float, parameters: LocalSearchParameters
) -> None:
    """Improve the order of tour k; its cost is the caller's business."""
    nodes = np.empty(tours.size[k] + 1, np.int32)
    nodes[0] = tours.after.size - tours.cost.size + k
    for i in range(1, nodes.size):
        nodes[i] = tours.after[nodes[i - 1]]
    cost = np.empty((nodes.size, nodes.size))
    for i in range(nodes.size):
        for j in range(nodes.size):
            cost[i, j] = leg(costs, k, nodes[i], nodes[j])
    tour = closed_tour(cost, parameters)
    before = tour.segments.forward[-1]
    improve(tour, rng, int(kicks * tours.size[k]))
    if tour.segments.forward[-1] < before:
        clear(costs, tours, k, np.empty(nodes.size, np.int32))
        fill(costs, tours, k, nodes[tour.segments.nodes[1:-1]])
