"""Tours in blocks: all tours as one ring, each in a block of its own, so that a move shifts only the tours it cuts.

Where UAVs are alike, fly from one site and legs cost the same both ways, any ring through all tasks and depots is a set
of tours, so a move for one tour is a move between tours as well (Christofides & Eilon 1969). A move cuts the ring
A B C D behind A, B and C, then joins the parts as

    A Bʳ C D (2-opt),  A C B D (or-3opt),  A C Bʳ D,  A Cʳ B D,  A Bʳ Cʳ D,

all there is with three legs. Whole tours within B or C are the same tours wherever in the ring they come and whichever
way they are flown, so they stay where they are; only the tours that are cut, three at most, are written anew. Prefix
sums give what each of them costs without walking along it (ring_energy.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours
from instances.arrays import Floats, Ints
from instances.kernels import njit

SWAPPED, TURNED_B, TURNED_C = 4, 2, 1
"""What a move does to the parts B and C, added up; a 2-opt move has an empty C, q = r."""


class TourBlocks(NamedTuple):
    """The ring: tour k begins at position k · 2^bits, N = n+m nodes in all.

    order (m · 2^bits,): depot n+k, the tasks in turn, the depot of the ring's next tour; sums (m · 2^bits,): what it
    takes from the tour's depot to each [s]; ends (m,): position of the last of these; position (N,): of each node, the
    first where it is a depot; spare_order, spare_sums (N,): room.
    """

    order: Nodes
    sums: Floats
    ends: Ints
    position: Ints
    spare_order: Nodes
    spare_sums: Floats
    bits: int


class Kept(NamedTuple):
    """Blocks to come back to, as TourBlocks; since (m,): position from which on a tour differs from them, −1: none."""

    order: Nodes
    sums: Floats
    ends: Ints
    since: Ints


def tour_blocks(costs: AlikeCosts, tours: Tours) -> TourBlocks:
    """Return the tours in blocks, each of which has room for all tasks."""
    total, m = tours.after.size, tours.cost.size
    bits = total.bit_length()
    room = np.empty(m << bits, np.int32), np.empty(m << bits), np.empty(m, np.int64), np.empty(total, np.int64)
    blocks = TourBlocks(*room, np.empty(total, np.int32), np.empty(total), bits)
    _lay_out(costs, tours, blocks)
    return blocks


def kept_of(blocks: TourBlocks) -> Kept:
    """Return blocks that do not differ."""
    copies = blocks.order.copy(), blocks.sums.copy(), blocks.ends.copy()
    return Kept(*copies, np.full(blocks.ends.size, -1, np.int64))


@njit(cache=True, nogil=True)
def _lay_out(costs: AlikeCosts, tours: Tours, blocks: TourBlocks) -> None:
    """Write the tours to the blocks."""
    m = blocks.ends.size
    n = blocks.position.size - m
    for k in range(m):
        i, v = k << blocks.bits, n + k
        while True:
            blocks.order[i], blocks.position[v] = v, i
            i, v = i + 1, tours.after[v]
            if v == n + k:
                break
        blocks.order[i], blocks.ends[k] = n + (k + 1) % m, i
    add_up(costs, blocks)


@njit(cache=True, nogil=True)
def add_up(costs: AlikeCosts, blocks: TourBlocks) -> None:
    """Recompute the prefix sums, so that rounding of many small changes cannot gather."""
    order, sums = blocks.order, blocks.sums
    for k in range(blocks.ends.size):
        first = k << blocks.bits
        sums[first] = 0.0
        for i in range(first, blocks.ends[k]):
            sums[i + 1] = sums[i] + leg(costs, 0, order[i], order[i + 1])


@njit(cache=True, nogil=True)
def total_of(blocks: TourBlocks) -> float:
    """Return what all tours cost together [s]."""
    total = 0.0
    for k in range(blocks.ends.size):
        total += blocks.sums[blocks.ends[k]]
    return total


@njit(cache=True, nogil=True)
def longest_of(blocks: TourBlocks) -> float:
    """Return the cost of the longest tour [s]."""
    most = 0.0
    for k in range(blocks.ends.size):
        most = max(most, blocks.sums[blocks.ends[k]])
    return most


@njit(cache=True, nogil=True)
def write_ring(blocks: TourBlocks, ring: Nodes) -> None:
    """Write the tours one after the other, each behind its depot, to `ring` (N+1,), the first node again at the end."""
    x = 0
    for k in range(blocks.ends.size):
        for i in range(k << blocks.bits, blocks.ends[k]):
            ring[x] = blocks.order[i]
            x += 1
    ring[x] = ring[0]


@njit(cache=True, nogil=True)
def leg_at(blocks: TourBlocks, i: int, right: int) -> int:
    """Return the first position of the leg whose left (0) or right (1) end is the node at position i."""
    if not right:
        return i
    k = i >> blocks.bits
    if i > k << blocks.bits:
        return i - 1
    return blocks.ends[k - 1 if k > 0 else blocks.ends.size - 1] - 1


@njit(cache=True, nogil=True)
def position_of(blocks: TourBlocks, place: int) -> int:
    """Return the position of the node that is number `place` of the ring, from 0."""
    k = 0
    while place >= blocks.ends[k] - (k << blocks.bits):
        place -= blocks.ends[k] - (k << blocks.bits)
        k += 1
    return (k << blocks.bits) + place


@njit(cache=True, nogil=True)
def part_of(blocks: TourBlocks, part: int, p: int, q: int, r: int, kind: int) -> tuple[int, int, bool, int, int]:
    """Return the part that comes as number `part` after A, where a move cuts at p ≤ q ≤ r.

    As (first position, last position, whether turned, number of the tour that it begins on, and of that it ends on);
    the last position is below the first where it is empty.
    """
    if (part == 1) == (kind & SWAPPED == 0):
        return q + 1, r, kind & TURNED_C != 0, q >> blocks.bits, r >> blocks.bits
    return p + 1, q, kind & TURNED_B != 0, p >> blocks.bits, q >> blocks.bits


@njit(cache=True, nogil=True)
def _fly_on(
    costs: AlikeCosts, blocks: TourBlocks, i: int, j: int, turned: bool, x: int, u: int, so_far: float
) -> tuple[int, int, float]:
    """Write tasks i..j of one tour to the spare room from x on, behind node u, `so_far` [s] from the depot.

    Return (x, u, so_far) behind them.
    """
    if i > j:
        return x, u, so_far
    order, sums, spare, spare_sums = blocks.order, blocks.sums, blocks.spare_order, blocks.spare_sums
    so_far += leg(costs, 0, u, order[j] if turned else order[i])
    if turned:
        for y in range(j - i + 1):
            spare[x + y] = order[j - y]
            spare_sums[x + y] = so_far + (sums[j] - sums[j - y])
    else:
        for y in range(j - i + 1):
            spare[x + y] = order[i + y]
            spare_sums[x + y] = so_far + (sums[i + y] - sums[i])
    return x + j - i + 1, order[i] if turned else order[j], so_far + (sums[j] - sums[i])


@njit(cache=True, nogil=True)
def _take_back(blocks: TourBlocks, i: int, x: int, end: int) -> None:
    """Write x..end−1 of the spare room to position i and on."""
    for y in range(end - x):
        v = blocks.spare_order[x + y]
        blocks.order[i + y], blocks.sums[i + y], blocks.position[v] = v, blocks.spare_sums[x + y], i + y


@njit(cache=True, nogil=True)
def _become(blocks: TourBlocks, k: int, i: int, x: int, end: int, cost: float) -> None:
    """Make tour k, which costs so much [s], x..end−1 of the spare room from position i on."""
    _take_back(blocks, i, x, end)
    m, last = blocks.ends.size, i + end - x
    blocks.order[last], blocks.sums[last], blocks.ends[k] = blocks.position.size - m + (k + 1) % m, cost, last


@njit(cache=True, nogil=True)
def rejoin(costs: AlikeCosts, blocks: TourBlocks, p: int, q: int, r: int, kind: int) -> None:
    """Make the move that cuts the legs that begin at positions p ≤ q ≤ r."""
    if p >> blocks.bits != r >> blocks.bits:
        _rejoin_across(costs, blocks, p, q, r, kind)
        return
    x, u, so_far = 0, blocks.order[p], blocks.sums[p]
    for part in range(2):
        i, j, turned, _, _ = part_of(blocks, part, p, q, r, kind)
        x, u, so_far = _fly_on(costs, blocks, i, j, turned, x, u, so_far)
    change = so_far + leg(costs, 0, u, blocks.order[r + 1]) - blocks.sums[r + 1]
    _take_back(blocks, p + 1, 0, x)
    for i in range(r + 1, blocks.ends[p >> blocks.bits] + 1):
        blocks.sums[i] += change


@njit(cache=True, nogil=True)
def _rejoin_across(costs: AlikeCosts, blocks: TourBlocks, p: int, q: int, r: int, kind: int) -> None:
    """Make a move that cuts several tours a ≤ b ≤ c; a keeps its head, c its tail."""
    bits, ends, depot = blocks.bits, blocks.ends, blocks.order[0]
    a, b, c = p >> bits, q >> bits, r >> bits
    one = two = -1
    cost_one = cost_two = 0.0
    x, u, so_far = 0, blocks.order[p], blocks.sums[p]
    for part in range(2):
        i, j, turned, first, last = part_of(blocks, part, p, q, r, kind)
        if first == last:  # or it is empty
            x, u, so_far = _fly_on(costs, blocks, i, j, turned, x, u, so_far)
            continue
        head, tail = (i, ends[first] - 1), ((last << bits) + 1, j)
        if turned:
            head, tail = tail, head
        x, u, so_far = _fly_on(costs, blocks, head[0], head[1], turned, x, u, so_far)
        one, cost_one, two, cost_two = x, so_far + leg(costs, 0, u, depot), one, cost_one
        x, u, so_far = _fly_on(costs, blocks, tail[0], tail[1], turned, x, depot, 0.0)
    x, u, so_far = _fly_on(costs, blocks, r + 1, ends[c] - 1, False, x, u, so_far)
    if two >= 0:  # of two tours that end in between `two` is the first
        _become(blocks, a, p + 1, 0, two, cost_two)
        _become(blocks, b, (b << bits) + 1, two, one, cost_one)
    else:
        _become(blocks, a, p + 1, 0, one, cost_one)
    _become(blocks, c, (c << bits) + 1, one, x, so_far + leg(costs, 0, u, depot))


@njit(cache=True, nogil=True)
def note_change(blocks: TourBlocks, kept: Kept, p: int, q: int, r: int) -> None:
    """Note which tours a move that cuts at p ≤ q ≤ r makes differ from those kept, and from where on."""
    bits, since = blocks.bits, kept.since
    a, b, c = p >> bits, q >> bits, r >> bits
    since[a] = min(since[a], p + 1) if since[a] >= 0 else p + 1
    if a < c:
        since[b] = since[b] if b == a else (b << bits) + 1
        since[c] = (c << bits) + 1


@njit(cache=True, nogil=True)
def keep(blocks: TourBlocks, kept: Kept) -> None:
    """Follow the tours that differ; `since` stays as it is."""
    for k in range(kept.since.size):
        if kept.since[k] < 0:
            continue
        kept.ends[k] = blocks.ends[k]
        for i in range(kept.since[k], kept.ends[k] + 1):
            kept.order[i], kept.sums[i] = blocks.order[i], blocks.sums[i]


@njit(cache=True, nogil=True)
def restore(blocks: TourBlocks, kept: Kept) -> None:
    """Make the tours that differ as they were kept; `since` stays as it is."""
    for k in range(kept.since.size):
        if kept.since[k] < 0:
            continue
        end = blocks.ends[k] = kept.ends[k]
        for i in range(kept.since[k], end):
            v = kept.order[i]
            blocks.order[i], blocks.sums[i], blocks.position[v] = v, kept.sums[i], i
        blocks.order[end], blocks.sums[end] = kept.order[end], kept.sums[end]
