"""Completion bounds: the least reduced cost of flying home from a task, by backward dynamic programming.

With duals σ_k ≥ 0 (cost of a tour) and π_i (tasks) a tour p of UAV k has reduced cost σ_k c_p − Σ_{i∈p} π_i. Let
B(i, b, M) be a lower bound on σ_k·(cost) − Σπ over every way home from task i that costs at most b bins of time and
visits none of the tasks M. It obeys

    B(i, b, M) = min( σ_k h_i  if ⌊h_i⌋ ≤ b,
                      min_{j ∉ M ∪ {i}}  σ_k c_ij − π_j + B(j, b − ⌊c_ij⌋, (M ∪ {i}) ∩ N_j) ),

where ⌊·⌋ counts whole bins (rounded *down*, hence never forbidding what fits) and N_j, the ng-neighbourhood of j, are
the few tasks whose visit is remembered at j (Baldacci, Mingozzi, Roberti, "New route relaxation and pricing strategies
for the vehicle routing problem", Oper. Res. 59, 2011). Only time is rounded, never the reduced cost.

Where costs change with time, the bins left are a clock: legs and their costs are those of bin b alone (`courses.py`).
Rounding makes the true clock later than bins say, and later may be cheaper, hence there B(i, b, M) is closed besides:
it is never above B(i, b − 1, M), as it is by itself where costs do not change.

Legs of zero bins make B depend on itself at the same b: they are relaxed in rounds. No tour has more than n − 1
legs in a row, so n rounds always suffice for a valid bound, and usually two converge.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.courses import Courses, WholeBins, bins_ahead, bins_behind, still
from formulations.routing.columns.cuts import Watch
from formulations.routing.columns.legs import UavLegs
from instances.arrays import Floats, Ints
from instances.kernels import njit

_NEAREST = 0.1
"""Returns of walks that the nearest task counts for, the second half as many, and so on."""
_SLACK = 1e-9  # of a bin: far more than rounding errors, in the direction that forbids less


class Memory(NamedTuple):
    """The ng-neighbourhoods: which tasks are remembered where.

    near : near[i, q] is the q-th task remembered at i (not i itself, which always is), shape (n, g).
    step : step[i, j, M] numbers the memory at j after i was left with memory M; 2^g where j ∈ M, forbidden.
    """

    near: Ints
    step: NDArray[np.int16]

    @classmethod
    def nearest(cls, between: Floats, size: int, returns: Floats | None = None) -> Memory:
        """Remember at each task the `size` nearest others; `between` (n, n) [s] the cost of any one UAV.

        returns (n, n) : how often walks came back to a task (second) by way of another (first), which counts for near.
        """
        n = between.shape[0]
        distance = np.minimum(between, between.T)
        distance = np.where(np.eye(n, dtype=bool), np.inf, distance)
        order = np.argsort(distance, axis=1, kind="stable")
        if returns is not None:
            worth = returns + _NEAREST / (1 + np.argsort(order, axis=1))
            np.fill_diagonal(worth, -np.inf)
            order = np.argsort(-worth, axis=1, kind="stable")
        near = order[:, : min(size, n - 1)].astype(np.int64)
        return cls(near, _memory_steps(near))


@njit(cache=True, nogil=True)
def _memory_steps(near: Ints) -> NDArray[np.int16]:
    n, g = near.shape
    states = 1 << g
    step = np.empty((n, n, states), np.int16)
    bit, of_one = np.zeros(n, np.int16), np.empty(g, np.int16)
    for j in range(n):
        for q in range(g):
            bit[near[j, q]] = 1 << q
        for i in range(n):
            for r in range(g):
                of_one[r] = states if near[i, r] == j else bit[near[i, r]]
            step[i, j, 0] = bit[i]
            for r in range(g):
                for rest in range(1 << r):
                    before = step[i, j, rest]
                    forbidden = before == states or of_one[r] == states
                    step[i, j, 1 << r | rest] = states if forbidden else before | of_one[r]
        bit[near[j]] = 0
    return step


class Bins(NamedTuple):
    """The time of one UAV's legs in `most` bins of `width` [s], which make up the cap.

    legs, cost : whole bins of each leg, rounded down, most + 1 where it is forbidden, and its cost [s], home last,
        shape (R, n, n+1); R = 1, or most + 1 where costs change with time: then of legs begun with so many bins left.
    fewest (n, n) : the fewest bins of each leg; order (n, n), degree (n,) : the successors of each task in the order of
        these, and how many there are; courses : what labels take.
    low, high (n,) : the fewest bins that the way home takes from each task, and the most that the way out leaves there:
        of other numbers no tour asks.
    """

    width: float
    most: int
    legs: WholeBins
    cost: Floats
    fewest: WholeBins
    order: Ints
    degree: Ints
    courses: Courses
    low: Ints
    high: Ints

    @classmethod
    def of(
        cls, legs: UavLegs, cap: float, most: int, courses: Courses | None = None, *, backwards: bool = False
    ) -> Bins:
        """Cut `cap` [s] into `most` bins; legs flown the other way round, the way home being the way out, if asked.

        courses : those of legs that change with time; reversed, their bins are those of time flown, not left.
        """
        if courses is not None and courses.lines.shape[0] > 1:
            rows = bins_behind if backwards else bins_ahead
            whole, cost = rows(courses, legs.between, legs.out if backwards else legs.home, cap, most)
            return cls._ordered(cap, most, whole, cost, courses, np.zeros(legs.out.size, np.int64))
        between, home, out = legs.between, legs.home, legs.out
        if backwards:
            between, home, out = between.T, out, home
        cost = np.ascontiguousarray(np.column_stack([between, home]))[None]  # else a second version is compiled
        whole, first = _whole(cost, cap / most, most), _whole(out, cap / most, most)
        return cls._ordered(cap, most, whole.astype(np.int32), cost, still(cost[0]), first)

    @classmethod
    def _ordered(cls, cap: float, most: int, legs: WholeBins, cost: Floats, courses: Courses, first: Ints) -> Bins:
        fewest = np.ascontiguousarray(legs[:, :, :-1].min(axis=0))
        order, degree = np.argsort(fewest, axis=1, kind="stable"), (fewest <= most).sum(axis=1)
        last, back = legs[:, :, -1].min(axis=0).astype(np.int64), np.ascontiguousarray(fewest.T)
        low, high = _ways(last, back), most - _ways(first, fewest)
        return cls(cap / most, most, legs, cost, fewest, order, degree, courses, low, high)


def _whole(cost: Floats, width: float, most: int) -> Ints:
    """Return whole bins of costs [s], rounded down, most + 1 where they are more than there are."""
    return np.maximum(np.minimum(np.floor(cost / width - _SLACK), most + 1), 0).astype(np.int64)


@njit(cache=True, nogil=True)
def _ways(first: Ints, fewest: WholeBins) -> Ints:
    """Return the bins of the way to each task that takes fewest, (n,): `first` of the leg from the depot."""
    n = first.size
    ways, left = first.copy(), np.ones(n, np.bool_)
    for _ in range(n):
        here = -1
        for i in range(n):
            if left[i] and (here < 0 or ways[i] < ways[here]):
                here = i
        left[here] = False
        for j in range(n):
            ways[j] = min(ways[j], ways[here] + fewest[here, j])
    return ways


@njit(cache=True, nogil=True)
def bins_left(time: float, bins: Bins) -> np.int64:
    """Return the whole bins in the `time` left of the cap, rounded so that nothing that fits is forbidden."""
    return min(np.int64(bins.most), np.int64(np.floor(time / bins.width + 1e-9)))


@njit(cache=True, nogil=True)
def completion(bins: Bins, memory: Memory, watch: Watch, price: Floats, sigma: float) -> Floats:
    """Return B, shape (n, most + 1, 2^q (2^g + 1)): for each state of the cuts watched (`cuts.py`) one block.

    The last entry of a block is infinite, for forbidden steps, and so is B beyond the bins that a tour can have left.
    """
    step, turn, charge, low, high = memory.step, watch.turn, watch.charge, bins.low, bins.high
    fewest, order, degree = bins.fewest, bins.order, bins.degree
    n, states, blocks, by_clock = price.size, step.shape[2], turn.shape[2], bins.legs.shape[0] > 1
    best = np.full((n, bins.most + 1, blocks * (states + 1)), np.inf)
    zero_legs = False
    for i in range(n):
        zero_legs = zero_legs or (degree[i] > 0 and fewest[i, order[i, 0]] == 0)
    for b in range(bins.most + 1):
        legs, cost = bins.legs[b if by_clock else 0], bins.cost[b if by_clock else 0]
        for i in range(n):
            if not low[i] <= b <= high[i]:
                continue
            row = best[i, b]
            if by_clock and b > 0:
                for at in range(row.size):  # numba compiles assigned slices ten times as long, to word their errors
                    row[at] = best[i, b - 1, at]
            if legs[i, n] <= b:
                for block in range(blocks):
                    for memory_there in range(states):
                        at = block * (states + 1) + memory_there
                        row[at] = min(row[at], sigma * cost[i, n])
            for a in range(degree[i]):
                j = order[i, a]
                if fewest[i, j] > b:
                    break
                used = legs[i, j]
                if used > 0 and low[j] <= b - used:
                    weight = sigma * cost[i, j] - price[j]
                    _relax(row, best[j, b - used], step[i, j], turn[i, j], charge[i, j], weight, states)
        if zero_legs:
            for _ in range(n):
                changed = False
                for i in range(n):
                    for a in range(degree[i] if low[i] <= b <= high[i] else 0):
                        j = order[i, a]
                        if fewest[i, j] > 0:
                            break
                        if legs[i, j] > 0:
                            continue
                        weight = sigma * cost[i, j] - price[j]
                        row = best[i, b]
                        changed = (
                            _relax(row, best[j, b], step[i, j], turn[i, j], charge[i, j], weight, states) or changed
                        )
                if not changed:
                    break
    return best


@njit(cache=True, nogil=True, inline="always")
def _relax(
    row: Floats,
    source: Floats,
    step: NDArray[np.int16],
    turn: NDArray[np.int16],
    charge: Floats,
    weight: float,
    states: int,
) -> bool:
    """Lower row(C, M) to weight + charge(C) + source(turn(C), step(M)).

    In each block empty memory is the least restricted, full the most.
    """
    changed = False
    for block in range(turn.size):
        to, at, paid = turn[block] * (states + 1), block * (states + 1), weight + charge[block]
        if paid + source[to] >= row[at + states - 1]:
            continue
        for memory in range(states):
            value = paid + source[to + step[memory]]
            if value < row[at + memory]:
                row[at + memory] = value
                changed = True
    return changed
