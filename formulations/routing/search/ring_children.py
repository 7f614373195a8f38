"""Ring children: what a ring becomes when legs are exchanged, as its parts and how they are joined, without a copy.

Legs taken out cut the ring into parts; legs put in join their ends. That makes one ring or several. The smallest of
several is joined to another by the exchange of two legs that costs least (Nagata & Kobayashi 2013), until there is one.
All that takes time as there are legs exchanged, not as there are nodes; prefix sums say what the tours then cost.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.routing.search.candidate_legs import CandidateLegs
from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.giant_tour import GiantTour, add_up, is_between
from formulations.routing.search.ring_energy import Pressure, tour_energy
from instances.arrays import Ints
from instances.kernels import njit


class RingChild(NamedTuple):
    """Legs exchanged, and what follows from them.

    cuts (K,): positions of the ring behind which it is cut; added (K, 2): legs put in; counts (2,): how many of each.
    left, right (K,): first and last position of each part, across the ring's end in one of them; link (2K,): the end,
    2 · part + (0 left, 1 right), that each end is joined to; ring, size (K,): which ring a part is in, and its nodes;
    walk (K,): parts of ring 0 in their order, each by the end where it is entered.
    """

    cuts: Ints
    added: Ints
    counts: Ints
    left: Ints
    right: Ints
    link: Ints
    ring: Ints
    size: Ints
    walk: Ints


def child_room(most: int) -> RingChild:
    """Return room for children that exchange so many legs at most."""
    cuts, added, counts = np.zeros(most, np.int64), np.zeros((most, 2), np.int64), np.zeros(2, np.int64)
    others = [np.zeros(size, np.int64) for size in (most, most, 2 * most, most, most, most)]
    return RingChild(cuts, added, counts, *others)


@njit(cache=True, nogil=True)
def leg_behind(tour: GiantTour, v: int, w: int) -> int:
    """Return the position behind which the ring flies between v and w, −1 where they are no neighbours."""
    i = tour.position[v]
    if tour.order[i + 1] == w:
        return i
    before = i - 1 if i > 0 else tour.order.size - 2
    return before if tour.order[before] == w else -1


@njit(cache=True, nogil=True)
def _part_at(child: RingChild, i: int) -> int:
    """Return the part that position i is in; cuts are ascending, and part 0 goes across the ring's end."""
    low, high = 0, child.counts[0]
    while low < high:
        middle = (low + high) // 2
        if child.cuts[middle] < i:
            low = middle + 1
        else:
            high = middle
    return low if low < child.counts[0] else 0


@njit(cache=True, nogil=True)
def _free_end(tour: GiantTour, child: RingChild, v: int) -> int:
    """Return an end at node v that is joined to none yet."""
    i = tour.position[v]
    s = _part_at(child, i)
    return 2 * s if child.left[s] == i and child.link[2 * s] == -1 else 2 * s + 1


@njit(cache=True, nogil=True)
def _node_at(tour: GiantTour, child: RingChild, end: int) -> int:
    """Return the node at an end."""
    return tour.order[child.right[end // 2] if end % 2 else child.left[end // 2]]


@njit(cache=True, nogil=True)
def join_parts(tour: GiantTour, child: RingChild) -> int:
    """Write parts, links and rings that follow from the legs exchanged; return how many rings there are."""
    total, count = tour.order.size - 1, child.counts[0]
    cuts, link = child.cuts, child.link
    cuts[:count].sort()
    for s in range(count):
        child.left[s] = (cuts[s - 1 if s > 0 else count - 1] + 1) % total
        child.right[s] = cuts[s]
        link[2 * s] = link[2 * s + 1] = child.ring[s] = -1
    for j in range(child.counts[1]):
        one = _free_end(tour, child, child.added[j, 0])
        link[one] = -2
        other = _free_end(tour, child, child.added[j, 1])
        link[one], link[other] = other, one
    rings = at = 0
    for first in range(count):
        end, size = 2 * first, 0
        while child.ring[end // 2] < 0:
            s = end // 2
            child.ring[s] = rings
            size += (child.right[s] - child.left[s]) % total + 1
            if rings == 0:
                child.walk[at] = end
                at += 1
            end = link[end ^ 1]
        if size > 0:
            child.size[rings] = size
            rings += 1
    return rings


@njit(cache=True, nogil=True)
def _beside(tour: GiantTour, child: RingChild, v: int, after: int) -> int:
    """Return the neighbour of v in its ring, on the side where in the tour is the one before (0) or after it (1)."""
    i = tour.position[v]
    s = _part_at(child, i)
    if (child.right[s] if after else child.left[s]) == i:
        return _node_at(tour, child, child.link[2 * s + after])
    if after:
        return tour.order[i + 1]
    return tour.order[i - 1 if i > 0 else tour.order.size - 2]


@njit(cache=True, nogil=True)
def _take_out(tour: GiantTour, child: RingChild, v: int, w: int) -> None:
    """Take out a leg of the child, one that was put in or one of the tour."""
    added, counts = child.added, child.counts
    for j in range(counts[1]):
        a, b = added[j]
        if (a == v and b == w) or (a == w and b == v):
            counts[1] -= 1
            added[j, 0], added[j, 1] = added[counts[1]]
            return
    child.cuts[counts[0]] = leg_behind(tour, v, w)
    counts[0] += 1


@njit(cache=True, nogil=True)
def put_in(child: RingChild, v: int, w: int) -> None:
    """Put in a leg."""
    child.added[child.counts[1], 0], child.added[child.counts[1], 1] = v, w
    child.counts[1] += 1


@njit(cache=True, nogil=True)
def join_rings(costs: AlikeCosts, near: CandidateLegs, tour: GiantTour, child: RingChild, rings: int) -> bool:
    """Join the smallest ring to another by the best exchange of two legs; return whether there is one."""
    small, total, top = int(child.size[:rings].argmin()), tour.order.size - 1, -math.inf
    a = b = c = d = -1
    for s in range(child.counts[0]):
        if child.ring[s] != small:
            continue
        first, last = child.left[s], child.right[s]
        i = first - 1
        while i != last:
            i = i + 1 if i + 1 < total else 0
            u = tour.order[i]
            for j in range(near.nodes.shape[1]):
                v = near.nodes[u, j]
                if v < 0:
                    break
                at = tour.position[v]
                if is_between(at, first, last) or child.ring[_part_at(child, at)] == small:
                    continue
                for side in range(4):
                    u2, v2 = _beside(tour, child, u, side // 2), _beside(tour, child, v, side % 2)
                    gain = leg(costs, 0, u, u2) - near.cost[u, j] + leg(costs, 0, v, v2) - leg(costs, 0, u2, v2)
                    if gain > top:
                        top, a, b, c, d = gain, u, u2, v, v2
    if a < 0:
        return False
    _take_out(tour, child, a, b)
    _take_out(tour, child, c, d)
    put_in(child, a, c)
    put_in(child, b, d)
    return True


@njit(cache=True, nogil=True)
def _cost_between(tour: GiantTour, i: int, j: int) -> float:
    """Return what it costs from position i on to j, across the ring's end where j < i [s]."""
    cost = tour.sums[j] - tour.sums[i]
    return cost if i <= j else cost + tour.sums[-1]


@njit(cache=True, nogil=True)
def child_energy(costs: AlikeCosts, tour: GiantTour, child: RingChild, pressure: Pressure) -> float:
    """Return the energy of the tours of a child of one ring [s]."""
    starts, m = tour.starts, tour.starts.size - 1
    so_far, opening, energy = 0.0, -1.0, 0.0
    for end in child.walk[: child.counts[0]]:
        i, j = child.left[end // 2], child.right[end // 2]
        first, inside = m, 0
        for k in range(m):
            p = starts[k]
            inside += is_between(p, i, j)
            if p >= i and first == m:
                first = k
        first %= m
        if inside == 0:
            so_far += _cost_between(tour, i, j)
        else:
            head = _cost_between(tour, i, starts[first])
            tail = _cost_between(tour, starts[(first + inside - 1) % m], j)
            for k in range(first, first + inside - 1):
                energy += tour_energy(tour.sums[starts[k % m + 1]] - tour.sums[starts[k % m]], pressure)
            if end % 2:
                head, tail = tail, head
            if opening < 0.0:
                opening = so_far + head
            else:
                energy += tour_energy(so_far + head, pressure)
            so_far = tail
        so_far += leg(costs, 0, _node_at(tour, child, end ^ 1), _node_at(tour, child, child.link[end ^ 1]))
    return energy + tour_energy(so_far + opening, pressure)


@njit(cache=True, nogil=True)
def become(costs: AlikeCosts, tour: GiantTour, child: RingChild) -> None:
    """Make the tour its child, of one ring."""
    order, total, m = tour.order, tour.order.size - 1, tour.starts.size - 1
    at = depot = 0
    for end in child.walk[: child.counts[0]]:
        i, j = child.left[end // 2], child.right[end // 2]
        for x in range((j - i) % total + 1):
            v = order[(j - x if end % 2 else i + x) % total]
            if v == total - m:
                depot = at
            tour.spare[at] = v
            at += 1
    k = 0
    for i in range(total):
        v = tour.spare[(depot + i) % total]
        order[i] = v
        tour.position[v] = i
        if v >= total - m:
            tour.starts[k] = i
            k += 1
    add_up(costs, tour)
