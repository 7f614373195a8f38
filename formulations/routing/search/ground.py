"""Ground: what all searches of one instance share, read only."""

from __future__ import annotations

from typing import NamedTuple

from formulations.routing.search.costs import Costs, both_ways
from formulations.routing.search.crossover import places
from formulations.routing.search.neighbours import NEAR_DEPOTS, NEAR_TASKS, Neighbours, neighbours
from instances.arrays import Floats, Ints


class Ground(NamedTuple):
    """Costs, neighbours, and the place of each depot: the first depot there."""

    costs: Costs
    near: Neighbours
    place: Ints

    @property
    def size(self) -> tuple[int, int]:
        """Numbers of tasks n and of UAVs m."""
        return int(self.near.tasks.shape[0]), int(self.place.size)

    @property
    def crowding(self) -> float:
        """n² / m, what an annealing's length goes by: long tours need more steps than their number of tasks says."""
        n, m = self.size
        return n * n / m


def survey(cost: Floats, n_tasks: int) -> Ground:
    """Return the Ground of a cost matrix, shape (n+m, n+m) [s]."""
    costs = both_ways(cost)
    return Ground(costs, neighbours(costs, n_tasks, NEAR_TASKS, NEAR_DEPOTS), places(costs, n_tasks))
