"""Moves of the chained search: sequential 2-opt and 3-opt moves within and between tours (Lin & Kernighan 1973).

A move takes out a leg t1..t2, puts in t2..t3, takes out t3..t4 and either closes the ring by t4..t1 or puts in t4..t5,
takes out t5..t6 and closes it by t6..t1; what was taken out costs more than what was put in all along. Within a tour a
move is worth what it saves, between tours what it takes off the energy (ring_energy.py).
"""

from __future__ import annotations

from typing import NamedTuple

from formulations.routing.search.candidate_legs import CandidateLegs
from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.giant_tour import is_between
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.ring_energy import Pressure, ThreeLegs, gain_across
from formulations.routing.search.tour_blocks import SWAPPED, TURNED_B, TURNED_C, Kept, TourBlocks, leg_at
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


class ChainParameters(NamedTuple):
    """How it searches.

    nearest, layers, most: of candidate legs; the first new leg of a move may be any, the second the `second` shortest.
    span: tasks of a segment of a kick along the tours, at most: short ones leave little to repair.
    walk: legs from the first node of a kick to each of the others; 0: kicks are along the tours.
    bridged: tasks that a bridge closes to a ring, at most; 0: there are no bridges.
    first, last: temperatures in mean legs; they fall geometrically. Which tour goes where is settled while it is hot:
    pcb1173_3, 8 s, gaps of single runs: 0.10, 0.58, 1.07 % from 2.5 on; 1.3, 1.8 % from 0.8 on.
    scale: s of the energy, in temperatures.
    gain: share of the temperature below which a gain counts as rounding.
    """

    nearest: int = 5
    layers: int = 2
    most: int = 12
    second: int = 8
    span: int = 5
    walk: int = 0
    bridged: int = 0
    first: float = 2.5
    last: float = 0.03
    scale: float = 4.0
    gain: float = 1e-7


class Chain(NamedTuple):
    """What a chained search works with.

    energies (m,): of the tours, as moves leave them [s]; move (4,): p, q, r and kind of the best move; bridge (5,): of
    the best bridge the first positions of the legs that close a ring around that which opens it, then of the one it is
    put in at, and whether that turns it; kept: the tours before the kick; queue (N,), queued (N,), queue_at (2,): nodes
    to look at, whether among them, and the queue's first place and length (don't-look bits).
    """

    costs: AlikeCosts
    near: CandidateLegs
    blocks: TourBlocks
    energies: Floats
    move: Ints
    bridge: Ints
    kept: Kept
    queue: Nodes
    queued: Bools
    queue_at: Ints


class Ends(NamedTuple):
    """Legs that a move removes, each by its first position and whether t1, t3, t5 is at its right end."""

    e1: int
    s1: int
    e2: int
    s3: int


@njit(cache=True, nogil=True)
def _partner(end: int, t1: int, t3: int, t5: int) -> int:
    """Return the end that a new leg joins to `end`: t2 to t3, t4 to t5, t6 to t1; the other end of a leg is end ^ 1."""
    if end == t1:
        return t5 ^ 1
    if end == t1 ^ 1:
        return t3
    if end == t3:
        return t1 ^ 1
    if end == t3 ^ 1:
        return t5
    return t3 ^ 1 if end == t5 else t1


@njit(cache=True, nogil=True)
def _put_in(end: int, t1: int, t3: int, t5: int) -> int:
    """Return which leg is put in at an end: 0 for t2..t3, 1 for t4..t5, 2 for t6..t1."""
    if end == t1 ^ 1 or end == t3:
        return 0
    return 1 if end == t3 ^ 1 or end == t5 else 2


@njit(cache=True, nogil=True)
def _cuts(ends: Ends, e3: int, s5: int, costs: ThreeLegs) -> tuple[int, int, int, int, ThreeLegs]:
    """Return (p, q, r, kind, legs) of the move that removes three legs; ends are numbered 0 to 5 along the ring.

    costs: of the legs put in, t2..t3, t4..t5, t6..t1 [s]; legs: the same in the order in which they are flown then.
    """
    e1, e2 = ends.e1, ends.e2
    p, r = min(e1, e2, e3), max(e1, e2, e3)
    q = e1 + e2 + e3 - p - r
    t1 = 2 * ((e1 > e2) + (e1 > e3)) + ends.s1
    t3 = 2 * ((e2 > e1) + (e2 > e3)) + ends.s3
    t5 = 2 * ((e3 > e1) + (e3 > e2)) + s5
    first, last = _put_in(0, t1, t3, t5), _put_in(5, t1, t3, t5)
    legs = costs[first], costs[3 - first - last], costs[last]
    begin = _partner(0, t1, t3, t5)
    if begin == 2:
        return p, q, r, TURNED_B + TURNED_C, legs
    if begin == 4:
        return p, q, r, SWAPPED + TURNED_C, legs
    return p, q, r, SWAPPED if _partner(4, t1, t3, t5) == 1 else SWAPPED + TURNED_B, legs


@njit(cache=True, nogil=True, inline="always")  # as gain_across
def _consider(
    chain: Chain, p: int, q: int, r: int, kind: int, legs: ThreeLegs, gain: float, top: float, pressure: Pressure
) -> float:
    """Write the move to `chain.move` if it is worth more than `top`; return what the best is worth [s].

    legs: what those put in cost, in the order in which they are flown; gain: what it saves in all [s].
    """
    blocks = chain.blocks
    if p >> blocks.bits != r >> blocks.bits:
        gain = gain_across(blocks, chain.energies, p, q, r, kind, legs, top, pressure)
    if gain <= top:
        return top
    move = chain.move
    move[0], move[1], move[2], move[3] = p, q, r, kind
    return gain


@njit(cache=True, nogil=True)
def _third_legs(
    chain: Chain, ends: Ends, closed: bool, so_far: float, put_in: float, top: float, second: int, pressure: Pressure
) -> float:
    """Look at 3-opt moves that remove the two legs of `ends`; return what the best is worth [s].

    closed: whether t2..t3 would be a ring of its own, which the third leg removed must open; so_far: gain without it;
    put_in: what t2..t3 costs [s].
    """
    near, near_cost = chain.near
    blocks = chain.blocks
    order, position, sums = blocks.order, blocks.position, blocks.sums
    t1, t2 = order[ends.e1 + ends.s1], order[ends.e1 + 1 - ends.s1]
    t3, t4 = order[ends.e2 + ends.s3], order[ends.e2 + 1 - ends.s3]
    low, high = position[t2], position[t3] if closed else position[t4]
    if ends.s1:
        low, high = high, low
    tour = ends.e1 >> blocks.bits
    within = ends.e2 >> blocks.bits == tour
    for j in range(second):
        t5 = near[t4, j]
        if t5 < 0 or so_far - near_cost[t4, j] <= 0.0:
            break
        i = position[t5]
        inside = is_between(i, low, high)
        if t5 == t3 or (closed and not inside):
            continue
        for s5 in range(2):
            if closed:
                if t5 == (t3 if s5 == ends.s1 else t2):
                    continue
            elif (s5 == ends.s1) != inside:
                continue
            e3 = leg_at(blocks, i, s5)
            if e3 == ends.e1 or e3 == ends.e2:
                continue
            costs = put_in, near_cost[t4, j], leg(chain.costs, 0, t1, order[e3 + 1 - s5])
            gain = so_far - costs[1] + sums[e3 + 1] - sums[e3] - costs[2]
            if gain <= top and within and e3 >> blocks.bits == tour:
                continue
            p, q, r, kind, legs = _cuts(ends, e3, s5, costs)
            top = _consider(chain, p, q, r, kind, legs, gain, top, pressure)
    return top


@njit(cache=True, nogil=True)
def best_move(chain: Chain, t1: int, least: float, parameters: ChainParameters, pressure: Pressure) -> float:
    """Write the best move that removes a leg of t1 and is worth more than `least` [s] to `chain.move`.

    Return what it is worth, `least` where there is none.
    """
    near, near_cost = chain.near
    blocks = chain.blocks
    order, position, sums = blocks.order, blocks.position, blocks.sums
    top = least
    for s1 in range(2):
        e1 = leg_at(blocks, position[t1], s1)
        t2 = order[e1 + 1 - s1]
        for j in range(near.shape[1]):
            t3 = near[t2, j]
            put_in = near_cost[t2, j]
            first = sums[e1 + 1] - sums[e1] - put_in
            if t3 < 0 or first <= 0.0:
                break
            if t3 == t1:
                continue
            for s3 in range(2):
                e2 = leg_at(blocks, position[t3], s3)
                t4 = order[e2 + 1 - s3]
                if t4 == t2:
                    continue
                gain = first + sums[e2 + 1] - sums[e2]
                if s3 != s1:
                    back, p, r = leg(chain.costs, 0, t1, t4), min(e1, e2), max(e1, e2)
                    legs = (put_in, back, 0.0) if s1 else (back, put_in, 0.0)
                    top = _consider(chain, p, r, r, TURNED_B, legs, gain - back, top, pressure)
                ends, second = Ends(e1, s1, e2, s3), parameters.second
                top = _third_legs(chain, ends, s3 == s1, gain, put_in, top, second, pressure)
    return top
