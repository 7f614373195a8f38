"""What is left of a tour, at least: bounds by dynamic programming over tasks, time in bins and tasks remembered.

With prices π and σ, B(i, b, M) is no more than σ·(cost) − Σπ of any way home from task i that takes at most b bins of
time and visits none of the tasks M, of those near i:

    B(i, b, M) = min( σ h_i,  min_{j ∉ M}  σ c_ij − π_j + B(j, b − ⌊c_ij⌋, M') ),

⌊·⌋ whole bins, rounded down, so that nothing that fits is left out; M' what j remembers of M and i (Baldacci, Mingozzi
& Roberti 2011). Plain arrays: this belongs to the check of proofs and shares nothing with what makes them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats, Ints

_SLACK = 1e-9
"""Of a bin: far more than rounding errors, in the direction that forbids less."""


@dataclass(frozen=True)
class WaysHome:
    """Bounds `least` (n, bins + 1, 2^g) [s] on what is left of a tour; `near` (n, g) the tasks remembered at each."""

    least: Floats
    near: Ints
    width: float

    def bins_left(self, time: Floats) -> Ints:
        """Return the bins in the `time` left [s], rounded so that nothing that fits is left out."""
        bins = np.floor(time / self.width + _SLACK).astype(np.int64)
        return np.minimum(bins, self.least.shape[1] - 1)


def ways_home(between: Floats, home: Floats, price: Floats, sigma: float, cap: float, bins: int, g: int) -> WaysHome:
    """Return the bounds for one UAV: legs `between` (n, n), `home` (n,) [s], infinite where forbidden."""
    n, width = home.size, cap / bins
    near = _nearest(between, g)
    step, states = _steps(near), 1 << near.shape[1]
    whole = np.maximum(np.floor(np.where(np.isfinite(between), between, 2 * cap) / width - _SLACK), 0).astype(np.int64)
    whole[~np.isfinite(between)] = bins + 1
    whole_home = np.where(np.isfinite(home), np.floor(home / width - _SLACK), bins + 1)
    least = np.full((n, bins + 1, states + 1), np.inf)  # the last state: forbidden
    weight = sigma * np.where(np.isfinite(between), between, 0.0) - price
    used, free = np.nonzero((whole > 0) & (whole <= bins)), np.argwhere(whole == 0)
    weights, steps, bins_used = weight[used], step[used], whole[used]
    starts = np.searchsorted(used[0], np.arange(n))
    ends = np.searchsorted(used[0], np.arange(n), side="right")
    for b in range(bins + 1):
        row = np.where(whole_home <= b, sigma * np.where(np.isfinite(home), home, 0.0), np.inf)[:, None]
        row = np.repeat(row, states, axis=1)
        fits = bins_used <= b
        ways = np.full((fits.size, states), np.inf)
        tails = used[1][fits], b - bins_used[fits]
        ways[fits] = weights[fits, None] + least[tails[0][:, None], tails[1][:, None], steps[fits]]
        for i in range(n):
            if ends[i] > starts[i]:
                row[i] = np.minimum(row[i], ways[starts[i] : ends[i]].min(axis=0))
        least[:, b, :states] = row
        _through_free_legs(least, b, free, weight, step)
    return WaysHome(least[:, :, :states], near, width)


def _through_free_legs(least: Floats, b: int, free: Ints, weight: Floats, step: Ints) -> None:
    """Lower B(·, b, ·) by legs of no whole bin until that changes nothing, or as often as a tour can use them."""
    if free.size == 0:
        return
    states, (tail, head) = least.shape[2] - 1, free.T
    for _ in range(least.shape[0]):
        ways = weight[tail, head][:, None] + least[head[:, None], b, step[tail, head]]
        before = least[:, b, :states].copy()
        np.minimum.at(least[:, b, :states], tail, ways)
        if np.array_equal(before, least[:, b, :states]):
            return


def _nearest(between: Floats, g: int) -> Ints:
    """Return the g nearest other tasks of each task."""
    distance = np.minimum(between, between.T)
    np.fill_diagonal(distance, np.inf)
    return np.argsort(distance, axis=1, kind="stable")[:, : min(g, between.shape[0] - 1)]


def _steps(near: Ints) -> Ints:
    """Return the memory at j after i was left with memory M, [i, j, M]; 2^g where j is remembered, forbidden."""
    n, g = near.shape
    kept = near[None, :, :] == np.arange(n)[:, None, None]  # i is remembered at j
    passed = near[None, :, :, None] == near[:, None, None, :]  # the r-th at i is the q-th at j
    forbids = near[:, None, :] == np.arange(n)[None, :, None]  # the r-th at i is j
    steps = np.empty((n, n, 1 << g), np.int64)
    for memory in range(1 << g):
        bits = (memory >> np.arange(g) & 1).astype(bool)
        after = ((kept | (passed & bits).any(axis=3)) << np.arange(g)).sum(axis=2)
        steps[:, :, memory] = np.where((forbids & bits).any(axis=2), 1 << g, after)
    return steps
