"""Parting: two tasks of the longest tour must be flown by different UAVs while an annealing lasts.

Where the longest tour flies to a few far tasks, these together are what is cheapest, and every annealing comes to
that, though tours that each fly to one of them can be packed shorter. Which tasks are flown together is what branch and
bound decides pair by pair (Ryan & Foster, in: Computer Scheduling of Public Transport, 1981); here a pair of the
longest tour is drawn and only the branch is searched in which they are apart. The routes found are routes of the
whole, and may join the members however long they are. Of tours of many tasks no pair decides much.

What a UAV may not fly takes it longer than any tour: its costs are a class of their own (costs.py). One UAV may not fly
to the one task; those like it at its site, which could fly the same tour in its place, may not fly to the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import AlikeCosts, Costs, FleetCosts, fleet_costs, leg
from formulations.routing.search.decomposition import Subproblem, task_on
from formulations.routing.search.place_costs import PlaceCosts
from formulations.routing.search.problem_data import ProblemData
from formulations.routing.search.randomness import Rng
from formulations.routing.search.tours import Tours, duplicate, link, reprice, unlink
from formulations.routing.search.trimming import elsewhere
from instances.arrays import Ints


class PartingParameters(NamedTuple):
    """How often tasks are parted, and which.

    30 s, mean gaps on md4 (six seeds), md31 and md34 (three): 0.05 %, without 0.19 %; on ry48p_5, ftv130_5, a280_10 and
    four others with one depot, with a share of 0.4, −0.13 and 0.06 %; on seven sets of 83 to 100 tasks a UAV, where
    none are parted, −0.04 and −0.12 % (measured.md).

    share: of the stages after the founders, where nothing was new for long; early: of that share, where all is new.
    best: share of those stages that part tasks of the best routes, the others of a member's.
    draws: tasks of which the one farthest from the depot is taken, for either of the two.
    tasks: of a tour, in the mean at most.
    entries: of the matrices of costs that are made for such a stage, at most; without a fleet there are two or three.
    """

    share: float = 0.7
    early: float = 0.3
    best: float = 0.5
    draws: int = 2
    tasks: int = 80
    entries: int = 3_000_000

    def suits(self, data: ProblemData) -> bool:
        """Return whether there are UAVs to part tasks among, tours are short, and costs can be made a fleet's."""
        n, m = data.size
        if m < 2 or n > self.tasks * m or isinstance(data.costs, PlaceCosts):
            return False
        classes = len(data.costs.out) if isinstance(data.costs, FleetCosts) else 1
        return (classes + 2) * (n + m) ** 2 <= self.entries


def parted_costs(costs: AlikeCosts | FleetCosts, banned: Ints) -> FleetCosts:
    """Return the costs by which UAV k cannot fly to task banned[k], where that is not −1; banned has shape (m,)."""
    if isinstance(costs, FleetCosts):
        out, classes, scale = costs.out, costs.classes, costs.scale.copy()
    else:
        out, classes, scale = costs.out[None], np.zeros(banned.size, np.int64), np.ones(banned.size)
    kinds, own = np.unique(np.column_stack([classes, banned]), axis=0, return_inverse=True)
    parted = out[kinds[:, 0]]
    never = 2.0 * out.shape[-1] * float(out.max()) or 1.0
    for cost, v in zip(parted, kinds[:, 1], strict=True):
        if v >= 0:
            cost[v], cost[:, v] = never, never
            cost[v, v] = 0.0
    return fleet_costs(parted, own.ravel(), scale)


def _far_task(costs: Costs, tours: Tours, k: int, other: int, draws: int, rng: Rng) -> int:
    """Return the farthest of some random tasks of tour k that are not `other`."""
    n, far, most = tours.after.size - tours.cost.size, -1, -np.inf
    while draws > 0:
        v = task_on(tours, k, rng)
        if v != other:
            draws -= 1
            trip = leg(costs, k, n + k, v) + leg(costs, k, v, n + k)
            if trip > most:
                far, most = v, trip
    return far


def part_two(data: ProblemData, whole: Tours, parameters: PartingParameters, rng: Rng) -> Subproblem | None:
    """Return the search of `whole` with two tasks of its longest tour parted, None where that has one task or none.

    Its `tours` are as they were, which takes longer than any tour by its costs, so that whatever is found takes their
    place; its `best` are those with one of the two tasks moved to the tour nearby that takes it at the least cost.
    """
    costs, k = data.costs, int(whole.cost.argmax())
    assert not isinstance(costs, PlaceCosts)
    if whole.size[k] < 2:
        return None
    stays = _far_task(costs, whole, k, -1, parameters.draws, rng)
    leaves = _far_task(costs, whole, k, stays, parameters.draws, rng)
    banned = np.where(data.site == data.site[k], stays, -1)
    banned[k] = leaves
    own = data._replace(costs=parted_costs(costs, banned))
    aside = np.arange(banned.size) == k
    tours, best = duplicate(whole), duplicate(whole)
    unlink(costs, best, leaves)
    u, _ = elsewhere(costs, data.near, best, leaves, aside, rng)
    link(costs, best, leaves, u)
    for each in (tours, best):
        reprice(own.costs, each)
    return Subproblem(own, whole, tours, best, np.arange(whole.after.size, dtype=np.int32))
