"""Completion bounds: the least reduced cost of flying home from a task, by backward dynamic programming.

With duals σ_k ≥ 0 (cost of a tour) and π_i (tasks) a tour p of UAV k has reduced cost σ_k c_p − Σ_{i∈p} π_i. Let
B(i, b, M) be a lower bound on σ_k·(cost) − Σπ over every way home from task i that costs at most b bins of time and
visits none of the tasks M. It obeys

    B(i, b, M) = min( σ_k h_i  if ⌊h_i⌋ ≤ b,
                      min_{j ∉ M ∪ {i}}  σ_k c_ij − π_j + B(j, b − ⌊c_ij⌋, (M ∪ {i}) ∩ N_j) ),

where ⌊·⌋ counts whole bins (rounded *down*, hence never forbidding what fits) and N_j, the ng-neighbourhood of j, are
the few tasks whose visit is remembered at j (Baldacci, Mingozzi, Roberti, "New route relaxation and pricing strategies
for the vehicle routing problem", Oper. Res. 59, 2011). Only time is rounded, never the reduced cost.

Legs of zero bins make B depend on itself at the same b: they are relaxed in rounds. No tour has more than n − 1
legs in a row, so n rounds always suffice for a valid bound, and usually two converge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from instances.arrays import Floats, Ints

_SLACK = 1e-9  # of a bin: far more than rounding errors, in the direction that forbids less


@dataclass(frozen=True)
class Memory:
    """The ng-neighbourhoods: which tasks are remembered where.

    near : near[i, q] is the q-th task remembered at i (not i itself, which always is), shape (n, g).
    step : step[i, j, M] numbers the memory at j after i was left with memory M; 2^g where j ∈ M, forbidden.
    """

    near: Ints
    step: NDArray[np.int16]

    @classmethod
    def nearest(cls, between: Floats, size: int) -> Memory:
        """Remember at each task the `size` nearest others; `between` (n, n) [s] the cost of any one UAV."""
        n = between.shape[0]
        distance = np.minimum(between, between.T)
        distance = np.where(np.eye(n, dtype=bool), np.inf, distance)
        near = np.argsort(distance, axis=1, kind="stable")[:, : min(size, n - 1)].astype(np.int64)
        return cls(near, _memory_steps(near))


@numba.njit(cache=True)
def _memory_steps(near):  # type: ignore[no-untyped-def]
    n, g = near.shape
    states = 1 << g
    step = np.empty((n, n, states), np.int16)
    for i in range(n):
        for j in range(n):
            for memory in range(states):
                after = 0
                for q in range(g):
                    if memory >> q & 1 and near[i, q] == j:
                        after = states
                        break
                    known = near[j, q] == i
                    for r in range(g):
                        if memory >> r & 1 and near[i, r] == near[j, q]:
                            known = True
                    if known and after < states:
                        after |= 1 << q
                step[i, j, memory] = after
    return step


@dataclass(frozen=True)
class Bins:
    """Time in bins: `width` [s]; `legs` (n, n) and `home` (n,) whole bins of each leg, rounded down."""

    width: float
    count: int
    legs: Ints
    home: Ints

    @classmethod
    def of(cls, between: Floats, home: Floats, cap: float, count: int) -> Bins:
        """Cut `cap` [s] into `count` bins; forbidden legs take count + 1."""
        width = cap / count

        def whole(cost: Floats) -> Ints:
            bins = np.minimum(np.floor(cost / width - _SLACK), count + 1)
            return np.maximum(bins, 0).astype(np.int64)

        return cls(width, count, whole(between), whole(home))


@numba.njit(cache=True)
def bins_left(time, width, count):  # type: ignore[no-untyped-def]
    """Return the whole bins in what is left of the cap, rounded so that nothing that fits is forbidden."""
    return min(count, np.int64(np.floor(time / width + 1e-9)))


@numba.njit(cache=True)
def successors(legs, count):  # type: ignore[no-untyped-def]
    """Return for each task its successors in order of bins, shape (n, n), and how many there are."""
    n = legs.shape[0]
    order = np.empty((n, n), np.int64)
    degree = np.zeros(n, np.int64)
    for i in range(n):
        ranked = np.argsort(legs[i], kind="mergesort")
        for j in ranked:
            if legs[i, j] <= count:
                order[i, degree[i]] = j
                degree[i] += 1
    return order, degree


@numba.njit(cache=True)
def completion(between, home, legs, home_bins, order, degree, step, turn, charge, price, sigma, count):  # type: ignore[no-untyped-def]
    """Return B, shape (n, count + 1, 2^q (2^g + 1)): for each state of the cuts watched (`watching.py`) one block.

    The last entry of a block is infinite, for forbidden steps.
    """
    n, states, blocks = home.size, step.shape[2], turn.shape[2]
    best = np.full((n, count + 1, blocks * (states + 1)), np.inf)
    zero_legs = False
    for i in range(n):
        zero_legs = zero_legs or (degree[i] > 0 and legs[i, order[i, 0]] == 0)
    for b in range(count + 1):
        for i in range(n):
            row = best[i, b]
            if home_bins[i] <= b:
                for block in range(blocks):
                    row[block * (states + 1) : block * (states + 1) + states] = sigma * home[i]
            for a in range(degree[i]):
                j = order[i, a]
                used = legs[i, j]
                if used > b:
                    break
                if used > 0:
                    weight = sigma * between[i, j] - price[j]
                    _relax(row, best[j, b - used], step[i, j], turn[i, j], charge[i, j], weight, states)
        if zero_legs:
            for _ in range(n):
                changed = False
                for i in range(n):
                    for a in range(degree[i]):
                        j = order[i, a]
                        if legs[i, j] > 0:
                            break
                        weight = sigma * between[i, j] - price[j]
                        row = best[i, b]
                        changed = (
                            _relax(row, best[j, b], step[i, j], turn[i, j], charge[i, j], weight, states) or changed
                        )
                if not changed:
                    break
    return best


@numba.njit(cache=True, inline="always")
def _relax(row, source, step, turn, charge, weight, states):  # type: ignore[no-untyped-def]
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
