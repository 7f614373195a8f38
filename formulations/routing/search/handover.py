"""Handover: where a population gives way to edge assembly or a chained search, when, and how hot that begins.

For UAVs that are alike and fly long tours from one site, at costs that are symmetric. Few of them are edge assembly's
from the beginning. Of more of them a chained search that begins hot finds better which UAV flies where, the hotter the
more there are: what a leg counts for in the energy of m tours falls as 1/m. Not so where the farthest task decides:
there the population goes on for longer, and the search that follows leaves its tours as they are but for details.
Where the limit allows for no population the search begins soon.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.routing.search.costs import AlikeCosts, Costs
from formulations.routing.search.packing import farthest_trip
from formulations.routing.search.problem_data import ProblemData


@dataclass(frozen=True)
class HandoverParameters:
    """When, and how hot; times are shares of the limit, temperatures in mean legs.

    30 s, gaps in % of single runs or two, by script, of a chained search after 0.6 of the limit begun at 0.2 (edge
    assembly where 320 tasks are on a tour), and as it is now: FIGURES.

    uavs, fewest, for_each: edge assembly is for so many UAVs at most and tours of so many tasks at least in the mean,
    whatever m is and for each of the m UAVs; begin: when it takes over from the only founder.
    many, few, founder: tasks, mean number of them on a tour, and share of the limit that a founder takes, at least, for
    a chained search (of fewer it makes less: lin318_3, 10 s, two seeds, 0.75 %, without 0.24 %; att532_5 0.01 and
    0.01 %).
    early, heat, last: when it begins hot, its first temperature for each UAV, and its last; room: so long is the longest tour then, at
    least, in the longest trip to one task and back.
    after, reheated: when it begins elsewhere, and its first temperature there.
    """

    uavs: int = 7
    fewest: int = 150
    for_each: int = 32
    begin: float = 0.05
    many: int = 1000
    few: int = 50
    founder: float = 0.015
    early: float = 0.33
    heat: float = 0.8
    last: float = 0.1
    room: float = 1.1
    after: float = 0.6
    reheated: float = 0.2

    def assembles(self, costs: Costs, n_tasks: int) -> bool:
        """Return whether few UAVs fly so long tours that they are edge assembly's."""
        m = _on_one_ring(costs, n_tasks)
        return 1 < m <= self.uavs and n_tasks >= max(self.fewest, self.for_each * m) * m

    def chains(self, costs: Costs, n_tasks: int) -> bool:
        """Return whether tasks are so many and tours so long that a chained search may take over."""
        m = _on_one_ring(costs, n_tasks)
        return m > 1 and n_tasks >= max(self.many, self.few * m)

    def is_hot(self, longest: float, data: ProblemData) -> bool:
        """Return whether tours are longer than the farthest task says; `longest` [s] is the incumbent's."""
        return longest > self.room * farthest_trip(data.costs, data.size[0])


def _on_one_ring(costs: Costs, n_tasks: int) -> int:
    """Return the number of UAVs where they are alike and at one site and costs symmetric, else 0.

    Any ring through all is then a set of tours.
    """
    if not isinstance(costs, AlikeCosts) or costs.out is not costs.into:
        return 0
    from_depots = costs.out[n_tasks:, :n_tasks]
    return len(from_depots) if np.all(from_depots == from_depots[0]) else 0
