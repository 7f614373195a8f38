"""Granular neighbourhood (Toth & Vigo 2003): every task's nearest tasks and nearest depots, all that a move looks at.

Near means a small min(c_ij, c_ji): under wind the cheap direction is the one a good tour uses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, Nodes
from instances.arrays import Floats
from instances.kernels import njit


class NeighbourhoodParameters(NamedTuple):
    """Lengths of the lists, where there are as many.

    tasks: as many as the widest recreation and the largest removal see (strategy.py, annealing.py).
    depots: so many that a UAV far away may still be drawn (recreate.py) and the lists of 5000 tasks take 3 MB.
    """

    tasks: int = 20
    depots: int = 128


class GranularNeighbourhood(NamedTuple):
    """tasks (n, k) and depots (n, d): node numbers, nearest first."""

    tasks: Nodes
    depots: Nodes


@njit(cache=True, nogil=True)
def keep_nearest(there: Floats, back: Floats, v: int, first: int, out: Nodes) -> None:
    """Write to `out` the nodes nearest to v, v left out; there[i] and back[i] are the costs to and from first + i."""
    room = out.size
    held = 0
    value = np.empty(room)
    farthest = np.inf
    for i in range(there.size):
        d = min(there[i], back[i])
        if (held == room and d >= farthest) or first + i == v:
            continue
        j = held if held < room else room - 1
        while j > 0 and value[j - 1] > d:
            value[j] = value[j - 1]
            out[j] = out[j - 1]
            j -= 1
        value[j] = d
        out[j] = first + i
        held = min(held + 1, room)
        farthest = value[room - 1]


@njit(cache=True, nogil=True)
def granular_neighbourhood(costs: Costs, n_tasks: int, parameters: NeighbourhoodParameters) -> GranularNeighbourhood:
    """Return the nearest tasks and nearest depots of every task."""
    n_depots = costs.out.shape[0] - n_tasks
    tasks = np.empty((n_tasks, min(parameters.tasks, n_tasks - 1)), np.int32)
    depots = np.empty((n_tasks, min(parameters.depots, n_depots)), np.int32)
    for v in range(n_tasks):
        there, back = costs.out[v], costs.into[v]
        keep_nearest(there[:n_tasks], back[:n_tasks], v, 0, tasks[v])
        keep_nearest(there[n_tasks:], back[n_tasks:], v, n_tasks, depots[v])
    return GranularNeighbourhood(tasks, depots)
