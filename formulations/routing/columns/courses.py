"""Courses: what the legs of one UAV from its tasks take by the clock, and in whole bins of time.

Between two knots a leg is a line; costs that do not change have one knot. A label that leaves task i at time t looks
its knot up once, and all its legs lie side by side behind it.

For completion bounds (`completion.py`) the time left before the cap U falls into bins of width w. Over the clocks of
bin b, t ∈ [U − (b+1)w, U − b·w], a leg costs at least min c(t), and as who departs later never arrives earlier, it ends
with at most the whole bins left that it ends with from the beginning of the bin. Reversed, for the ways to a task that
arrive in bin a, t + c(t) ∈ [a·w, (a+1)w], the departures are an interval again.

Bins are widened by a share of a bin, costs are lowered by another: both are far more than rounding errors, in the
direction that forbids less.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.clocks import Clocks, knot_at
from instances.arrays import Floats
from instances.kernels import njit

_WIDER = 1e-9  # of a bin
_DOWN = 1 - 2.0**-40
_ROUNDED = 1 - 2.0**-50
"""What arrivals by the clock are multiplied by: none is above the true one then, as in `subset_dp_clocks`."""

WholeBins = NDArray[np.int32]


class Courses(NamedTuple):
    """Costs by departure of one UAV, of legs from each task to each, and home.

    lines (Q, n, n+1, 2) : value [s] and slope behind each knot, home last; knots, first, per_second : as in `Clocks`;
    rounded : what an arrival is multiplied by, 1 where there is one knot.
    """

    lines: Floats
    knots: Floats
    first: NDArray[np.int32]
    per_second: float
    rounded: float


def still(cost: Floats) -> Courses:
    """Return the courses of costs (n, n+1) [s] that do not change, home last."""
    lines = np.zeros((1, *cost.shape, 2))
    lines[0, :, :, 0] = cost
    return Courses(lines, np.array([0.0, np.inf]), np.zeros(1, np.int32), 0.0, 1.0)


def by_clock(clocks: Clocks, k: int, n_tasks: int) -> Courses:
    """Return the courses of UAV k."""
    nodes = np.array([*range(n_tasks), n_tasks + k])
    lines = clocks.lines[clocks.classes[k]][:n_tasks, nodes].transpose(2, 0, 1, 3)
    return Courses(np.ascontiguousarray(lines), clocks.knots, clocks.first, clocks.per_second, _ROUNDED)


@njit(cache=True, nogil=True, inline="always")
def on_course(courses: Courses, i: int, j: int, q: int, since: float) -> float:
    """Return what the leg from task i to task j (n: home) takes [s] that begins so long since knot q."""
    if since <= 0.0:
        return courses.lines[q, i, j, 0]
    return courses.lines[q, i, j, 0] + courses.lines[q, i, j, 1] * since


@njit(cache=True, nogil=True)
def course_at(courses: Courses, i: int, j: int, time: float) -> float:
    """Return what the leg from task i to task j (n: home) takes [s] that begins at `time` [s]; NaN counts as never."""
    q = knot_at(courses, time)
    return on_course(courses, i, j, q, time - courses.knots[q])


@njit(cache=True, nogil=True)
def _least(courses: Courses, i: int, j: int, begin: float, end: float) -> float:
    """Return the least cost [s] of a leg that begins from `begin` to `end`, infinite where it cannot be flown."""
    least = np.inf
    for time in (begin, end):
        cost = course_at(courses, i, j, time)
        if cost < least:
            least = cost
    q = knot_at(courses, begin) + 1
    while courses.knots[q] < end:
        least = min(least, courses.lines[q, i, j, 0])
        q += 1
    return least * _DOWN


@njit(cache=True, nogil=True)
def bins_ahead(courses: Courses, between: Floats, home: Floats, cap: float, most: int) -> tuple[WholeBins, Floats]:
    """Return the bins that legs begun in each bin of time left use at least, and their least costs [s].

    Both (most + 1, n, n + 1), home last; most + 1 bins where a leg is forbidden: infinite in `between` or `home`.
    """
    n, width = home.size, cap / most
    legs, cost = np.full((most + 1, n, n + 1), np.int32(most + 1)), np.full((most + 1, n, n + 1), np.inf)
    for b in range(most + 1):
        begin = max(0.0, cap - (b + 1 + _WIDER) * width)
        end = max(0.0, cap - (b - 2 * _WIDER) * width)
        for i in range(n):
            for j in range(n + 1):
                if not (home[i] if j == n else between[i, j]) < np.inf:
                    continue
                first = course_at(courses, i, j, begin)
                if first < np.inf:
                    left = np.floor((cap - begin - first * _DOWN) / width + 2 * _WIDER)
                    legs[b, i, j] = max(0.0, min(b - left, most + 1.0))
                    cost[b, i, j] = _least(courses, i, j, begin, end)
    return legs, cost


@njit(cache=True, nogil=True)
def bins_behind(courses: Courses, between: Floats, out: Floats, cap: float, most: int) -> tuple[WholeBins, Floats]:
    """Return the same of legs reversed, by the bin of time flown in which they end; the leg from the depot is last."""
    n, width = out.size, cap / most
    legs, cost = np.full((most + 1, n, n + 1), np.int32(most + 1)), np.full((most + 1, n, n + 1), np.inf)
    for i in range(n):
        if out[i] < np.inf:
            for a in range(most + 1):
                legs[a, i, n] = max(0.0, min(np.floor(out[i] / width - _WIDER), most + 1.0))
                cost[a, i, n] = out[i]
        for h in range(n):
            if not between[h, i] < np.inf:
                continue
            p = q = 0
            for a in range(most + 1):
                p, begin = _departure(courses, h, i, p, (a - _WIDER) * width)
                q, end = _departure(courses, h, i, q, (a + 1 + _WIDER) * width)
                if end >= 0.0:
                    begin, end = max(0.0, begin - _WIDER * width), end + _WIDER * width
                    legs[a, i, h] = max(0.0, a - np.floor(end / width))
                    cost[a, i, h] = _least(courses, h, i, begin, end)
    return legs, cost


@njit(cache=True, nogil=True)
def _departure(courses: Courses, i: int, j: int, q: int, arrival: float) -> tuple[int, float]:
    """Return the latest departure [s] of a leg that ends by `arrival` [s], −1 if none, and its knot, from q on."""
    knots, lines = courses.knots, courses.lines
    if knots[q] + lines[q, i, j, 0] > arrival:
        return q, -1.0
    while q + 1 < lines.shape[0] and knots[q + 1] + lines[q + 1, i, j, 0] <= arrival:
        q += 1
    return q, knots[q] + (arrival - knots[q] - lines[q, i, j, 0]) / (1.0 + lines[q, i, j, 1])
