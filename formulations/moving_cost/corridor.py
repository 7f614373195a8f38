"""Paths made quicker by the clock: the quickest way through a corridor about a path, again and again.

Every node of a polyline may move sideways by −w, 0 or +w. Of the 3^k polylines that makes, the one of earliest arrival
is found by its labels, one for each node and place of it, since whoever is there earlier arrives earlier:

    a(k + 1, o') = min over o of a(k, o) + τ(p_k + o w n_k → p_{k+1} + o' w n_{k+1}, begun at a(k, o))

Segments that would leave free space are left out. The path found takes the old one's place until it stays the same;
then w is halved. It is never later than the path it was made of. A path's corners at obstacles are nodes of it, which
stay where they are as long as that is quickest.

Source: iterative dynamic programming; R. Luus, Int. J. Control 51 (1990) 995–1013.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from formulations.moving_cost.free_space import FreeSpace, point_free, segment_free
from formulations.moving_cost.polish import subdivide
from formulations.moving_cost.wind_frames import WindFrames, segment_time
from instances.arrays import Floats, Ints
from instances.kernels import njit
from instances.paths import Paths

WIDEST, NARROWEST = 0.5, 0.04
"""First and last sideways moves, over the length of the pieces a path is divided into."""
ROUNDS = 6
"""Of the same width at most."""
THREADS = 2
"""Departures at once."""


def quicker(plans: Sequence[Paths], moments: Floats, piece: float, wind: WindFrames, space: FreeSpace) -> list[Paths]:
    """Return `plans`, made for departures at `moments` (k,) [s], made quicker in pieces of `piece` [m] at most."""

    def made(plan: Paths, moment: float) -> Paths:
        points, offsets = quickest_nearby(plan.points, plan.offsets, moment, piece, wind, space)
        return replace(plan, points=points, offsets=offsets)

    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(made, plans, moments.tolist()))


@njit(cache=True)
def _round(p: Floats, begun: float, width: float, wind: WindFrames, space: FreeSpace) -> bool:
    """Put the quickest polyline through the corridor about `p` (k, 2) [m] in its place; whether it is another one."""
    n = len(p)
    at = np.empty((n, 3, 2))
    label, before = np.full((n, 3), np.inf), np.zeros((n, 3), dtype=np.int64)
    label[0, 1] = begun
    at[0, 1] = p[0]
    for k in range(1, n):
        nx, ny = 0.0, 0.0
        if k < n - 1:
            dx, dy = p[k + 1, 0] - p[k - 1, 0], p[k + 1, 1] - p[k - 1, 1]
            far = math.hypot(dx, dy)
            if far > 0.0:
                nx, ny = -dy / far, dx / far
        for o in range(3):
            shift = (o - 1) * width
            x, y = p[k, 0] + shift * nx, p[k, 1] + shift * ny
            at[k, o, 0], at[k, o, 1] = x, y
            if o != 1 and (nx == ny or not point_free(x, y, space)):
                continue
            for i in range(3):
                if not label[k - 1, i] < np.inf:
                    continue
                ax, ay = at[k - 1, i, 0], at[k - 1, i, 1]
                arrival = label[k - 1, i] + segment_time(ax, ay, x, y, label[k - 1, i], wind)
                if arrival < label[k, o] and ((i == 1 and o == 1) or segment_free(ax, ay, x, y, space)):
                    label[k, o], before[k, o] = arrival, i
    o, changed = 1, False
    for k in range(n - 1, 0, -1):
        p[k] = at[k, o]
        changed = changed or o != 1
        o = before[k, o]
    return changed


@njit(cache=True, nogil=True)
def quickest_nearby(
    points: Floats, offsets: Ints, departure: float, piece: float, wind: WindFrames, space: FreeSpace
) -> tuple[Floats, Ints]:
    """Return polylines, held end to end, made quicker for a departure [s], in pieces of `piece` [m] at most."""
    count = len(offsets) - 1
    made, ends = np.empty((0, 2)), np.zeros(count + 1, dtype=np.int64)
    for k in range(count):
        line = points[offsets[k] : offsets[k + 1]]
        if len(line) > 1:
            line, _ = subdivide(line, np.full(len(line), -1, dtype=np.int64), piece)
            width = WIDEST * piece
            while width > NARROWEST * piece:
                for _ in range(ROUNDS):
                    if not _round(line, departure, width, wind, space):
                        break
                width *= 0.5
        ends[k + 1] = ends[k] + len(line)
        if ends[k + 1] > len(made):
            more = np.empty((2 * ends[k + 1], 2))
            more[: ends[k]] = made[: ends[k]]
            made = more
        made[ends[k] : ends[k + 1]] = line
    return made[: ends[count]].copy(), ends
