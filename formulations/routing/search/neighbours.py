"""Who is near whom: every task's nearest tasks and nearest depots (granular neighbourhoods, Toth & Vigo 2003).

Near means a small min(c_ij, c_ji): under wind the cheap direction is the one a good tour uses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

NEAR_TASKS, NEAR_DEPOTS = 20, 128
"""Lengths of the lists, where there are as many."""


class Neighbours(NamedTuple):
    """tasks (n, k) and depots (n, d): node numbers, nearest first."""

    tasks: NDArray[np.int32]
    depots: NDArray[np.int32]


@njit(cache=True, nogil=True)
def _keep_nearest(cost: NDArray[np.float64], v: int, first: int, last: int, out: NDArray[np.int32]) -> None:
    """Write the len(out) nodes of first..last−1 nearest to v (v left out) into `out`, by insertion."""
    room = out.size
    held = 0
    value = np.empty(room)
    for u in range(first, last):
        if u == v:
            continue
        d = min(cost[u, v], cost[v, u])
        if held == room and d >= value[room - 1]:
            continue
        i = held if held < room else room - 1
        while i > 0 and value[i - 1] > d:
            value[i] = value[i - 1]
            out[i] = out[i - 1]
            i -= 1
        value[i] = d
        out[i] = u
        held = min(held + 1, room)


@njit(cache=True, nogil=True)
def neighbours(cost: NDArray[np.float64], n_tasks: int, k: int, d: int) -> Neighbours:
    """Return the k nearest tasks and d nearest depots of every task (fewer where there are fewer)."""
    n_depots = cost.shape[0] - n_tasks
    tasks = np.empty((n_tasks, min(k, n_tasks - 1)), np.int32)
    depots = np.empty((n_tasks, min(d, n_depots)), np.int32)
    for v in range(n_tasks):
        _keep_nearest(cost, v, 0, n_tasks, tasks[v])
        _keep_nearest(cost, v, n_tasks, n_tasks + n_depots, depots[v])
    return Neighbours(tasks, depots)
