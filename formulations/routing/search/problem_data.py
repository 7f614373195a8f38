"""Problem data: what all searches of one instance share, read only.

The granular neighbourhood (Toth & Vigo 2003) is every task's nearest tasks and nearest depots, all that a move looks
at. Near means a small min(c_ij, c_ji): under wind the cheap direction is the one a good tour uses. In a fleet it is
the least of all classes between tasks, and between task and depot the time of the UAV that starts there. Between tasks
what counts where costs are asymmetric is what potentials leave of them (leg_potentials.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search.costs import AlikeCosts, Costs, kinds, least, part_of
from formulations.routing.search.leg_potentials import PotentialParameters, left_of, leg_potentials
from formulations.routing.search.place_costs import PlaceCosts, near_places, place_sites
from instances.arrays import Floats, Ints
from instances.kernels import njit

Nodes = NDArray[np.int32]
"""Node numbers: tasks 0..n−1, then depots."""
_LARGEST_WHOLE = 2.0**53
"""Sums of larger whole numbers are rounded."""


class ProblemData(NamedTuple):
    """What all searches of one instance share.

    site (m,): of each depot the first at that place of such a UAV; potentials (2, n+m) [s]: of leg_potentials.py.
    """

    costs: Costs
    near: GranularNeighbourhood
    site: Ints
    potentials: Floats

    @property
    def size(self) -> tuple[int, int]:
        """Numbers of tasks n and of UAVs m."""
        return int(self.near.tasks.shape[0]), int(self.site.size)

    @property
    def crowding(self) -> float:
        """n² / m, what an annealing's length goes by: long tours need more steps than their number of tasks says."""
        n, m = self.size
        return n * n / m


def problem_data(
    costs: Costs, n_tasks: int, parameters: NeighbourhoodParameters, potentials: Floats | None = None
) -> ProblemData:
    """Return the ProblemData of an instance's costs, under potentials of their own where none are given."""
    if isinstance(costs, PlaceCosts):
        near = GranularNeighbourhood(*near_places(costs, n_tasks, parameters.tasks, parameters.depots))
        return ProblemData(costs, near, place_sites(costs, n_tasks), np.zeros((2, costs.x.size)))
    anyones = least(costs)
    site = depot_sites(anyones, n_tasks, kinds(costs, len(anyones.out) - n_tasks))
    if potentials is None:
        potentials = leg_potentials(anyones, n_tasks, parameters.potentials)
    left = left_of(anyones, potentials, n_tasks) if potentials.any() else anyones
    return ProblemData(costs, granular_neighbourhood(left, n_tasks, parameters), site, potentials)


def data_between(
    data: ProblemData, nodes: Nodes, uavs: NDArray[np.integer], parameters: NeighbourhoodParameters
) -> ProblemData:
    """Return the data of some nodes, the tasks first, then the depots of `uavs`, under the potentials of the whole."""
    potentials = np.ascontiguousarray(data.potentials[:, nodes])
    return problem_data(part_of(data.costs, nodes, uavs), nodes.size - uavs.size, parameters, potentials)


def grain_of(costs: Costs) -> float:
    """Return what all legs are whole multiples of [s], 0 where they are not whole numbers or have no matrix."""
    if isinstance(costs, PlaceCosts):
        return 0.0
    cost = costs.out
    for rows in (cost[:1], cost):
        if not np.array_equal(rows, np.rint(rows)) or rows.max(initial=0.0) > _LARGEST_WHOLE:
            return 0.0
    return float(np.gcd.reduce(cost.astype(np.int64), axis=None))


def depot_sites(costs: AlikeCosts, n_tasks: int, kind: Ints) -> Ints:
    """Return for each depot the first depot at the same place whose UAV is of the same kind, shape (m,).

    The place is the same where the costs to all tasks are.
    """
    first: dict[tuple[int, bytes, bytes], int] = {}
    site = np.arange(costs.out.shape[0] - n_tasks)
    for k in range(site.size):
        there, back = (cost[n_tasks + k, :n_tasks] + 0.0 for cost in costs)  # + 0.0: −0 is 0 too
        site[k] = first.setdefault((int(kind[k]), there.tobytes(), back.tobytes()), k)
    return site


class NeighbourhoodParameters(NamedTuple):
    """Lengths of the lists, where there are as many, and how potentials are found.

    tasks: as many as the widest recreation and the largest removal see (strategy.py, annealing.py).
    depots: so many that a UAV far away may still be drawn (recreate.py) and the lists of 5000 tasks take 3 MB.
    """

    tasks: int = 20
    depots: int = 128
    potentials: PotentialParameters = PotentialParameters()


class GranularNeighbourhood(NamedTuple):
    """tasks (n, k) and depots (n, d): node numbers, nearest first."""

    tasks: Nodes
    depots: Nodes


@njit(cache=True, nogil=True)
def keep_nearest(there: Floats, back: Floats, v: int, first: int, out: Nodes) -> None:
    """Write to `out` the nodes nearest to v, v left out; there[i] and back[i] are the costs to and from first + i.

    Of nodes equally near those that follow v in number come first, so that where many are not all tasks get the same.
    """
    room, size = out.size, there.size
    held = 0
    value = np.empty(room)
    farthest = np.inf
    i = (v - first) % size
    for _ in range(size):
        i = i + 1 if i + 1 < size else 0
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
def granular_neighbourhood(
    costs: AlikeCosts, n_tasks: int, parameters: NeighbourhoodParameters
) -> GranularNeighbourhood:
    """Return the nearest tasks and nearest depots of every task."""
    n_depots = costs.out.shape[0] - n_tasks
    tasks = np.empty((n_tasks, min(parameters.tasks, n_tasks - 1)), np.int32)
    depots = np.empty((n_tasks, min(parameters.depots, n_depots)), np.int32)
    for v in range(n_tasks):
        there, back = costs.out[v], costs.into[v]
        keep_nearest(there[:n_tasks], back[:n_tasks], v, 0, tasks[v])
        keep_nearest(there[n_tasks:], back[n_tasks:], v, n_tasks, depots[v])
    return GranularNeighbourhood(tasks, depots)
