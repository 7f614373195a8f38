"""Problem data: what all searches of one instance share, read only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, both_ways
from formulations.routing.search.granular import GranularNeighbourhood, NeighbourhoodParameters, granular_neighbourhood
from instances.arrays import Floats, Ints
from instances.kernels import njit


class ProblemData(NamedTuple):
    """Costs, granular neighbourhood, and the site of each depot, shape (m,): the first depot at the same place."""

    costs: Costs
    near: GranularNeighbourhood
    site: Ints

    @property
    def size(self) -> tuple[int, int]:
        """Numbers of tasks n and of UAVs m."""
        return int(self.near.tasks.shape[0]), int(self.site.size)

    @property
    def crowding(self) -> float:
        """n² / m, what an annealing's length goes by: long tours need more steps than their number of tasks says."""
        n, m = self.size
        return n * n / m


def problem_data(cost: Floats, n_tasks: int, parameters: NeighbourhoodParameters) -> ProblemData:
    """Return the ProblemData of a cost matrix, shape (n+m, n+m) [s]."""
    costs = both_ways(cost)
    return ProblemData(costs, granular_neighbourhood(costs, n_tasks, parameters), depot_sites(costs, n_tasks))


@njit(cache=True, nogil=True)
def depot_sites(costs: Costs, n_tasks: int) -> Ints:
    """Return for each depot the first depot at the same place, shape (m,): the one with the same costs to all tasks."""
    n_depots = costs.out.shape[0] - n_tasks
    site = np.arange(n_depots)
    for k in range(n_depots):
        for h in range(k):
            row, other = n_tasks + k, n_tasks + h
            if np.all(costs.out[row, :n_tasks] == costs.out[other, :n_tasks]) and np.all(
                costs.into[row, :n_tasks] == costs.into[other, :n_tasks]
            ):
                site[k] = h
                break
    return site
