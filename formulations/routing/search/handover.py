"""Handover: where a population gives way to edge assembly or a chained search, when, and how hot that begins.

For UAVs that are alike and fly long tours from one site, at costs that are symmetric. Few of them are edge assembly's
from the beginning. Of more of them a chained search that begins hot finds better which UAV flies where, the hotter the
more there are: what a leg counts for in the energy of m tours falls as 1/m, and beside the way across as 1/√n. Not so
where the farthest task decides: there tours grow anew from the farthest tasks on (growth.py). Nor where tours are
short, there the population goes on for longer. In both cases the search that follows leaves the tours as they are but
for details, and takes turns with searches of the longest of them and some near it (part_search.py).
Where the limit allows for no population the search begins soon.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.routing.search.costs import AlikeCosts, Costs, farthest_trip
from formulations.routing.search.problem_data import ProblemData


@dataclass(frozen=True)
class HandoverParameters:
    """When, and how hot; times are shares of the limit, temperatures in mean legs.

    30 s, two seeds, mean gaps in %, by script, with the last temperature of a hot search as it is and 0.03: d1655_10
    −0.60 and −0.70, pcb1173_10 −0.24 and −0.12, pr2392_10 0.17 and −0.03, u2152_10 −0.86 and −0.03. Hotter by √n than
    0.8 mean legs for each UAV: rl5915_10 0.27, as before 1.00 (16 and 11 runs, of −0.5 to 1.3 and −0.2 to 1.9);
    of up to 3,037 tasks, where little changes, no difference but luck.
    Where the farthest task decides, d1655_20, pcb3038_20, pr2392_20, u2152_20: without turns 0.33, 0.02, 0.54, 0.78,
    and reheated to 1 0.43, −0.29, 0.75, 1.02; with turns, three runs to seven, 0.19, −1.13, 0.24, 0.63; with one search
    of parts in the last tenth 0.23, −0.68 (none), 0.75, 0.57; with turns from 0.6 on 0.36, –, 0.50, 0.57, from 0.3 on
    0.26, –, 0.18, 0.59. Tours of 60 tasks end 0.3 % longer if it begins hot (1,200 tasks in a square, 20 UAVs from its
    middle, two seeds), of 100 to 210 0.4 to 0.8 % shorter (five such instances).

    uavs, fewest, for_each: edge assembly is for so many UAVs at most and tours of so many tasks at least in the mean,
    whatever m is and for each of the m UAVs; begin: when it takes over from the only founder.
    many, few, founder: tasks, mean number of them on a tour, and share of the limit that a founder takes, at least, for
    a chained search (of fewer it makes less: lin318_3, 10 s, two seeds, 0.75 %, without 0.24 %; att532_5 0.01 and
    0.01 %). Founders of less than 0.015 ended it before: d1655_20, 60 s, two seeds, 0.27 %, now 0.07; u2152_20, 120 s,
    0.26 and 0.06 %; pcb1173_10, 90 s, two seeds, −0.54 and −0.57 %.
    early, heat, last: when it begins hot, its first temperature for each UAV and √n, and its last; room: so long is the
    longest tour then, at least, in the longest trip to one task and back: of a shorter one the farthest
    task decides; each: mean number of tasks on a tour then, at least.
    grown: where the farthest task decides, how long tours grow anew after the first founder, as a share of what is left
    of the limit; 0: they do not.
    after, reheated: when it begins elsewhere, and its first temperature there and on grown tours; turns: until when
    that search, then searches of parts, then it again and so on go on; where there are no parts, it does to the end.
    pair, most: steps that finding candidate legs takes for each pair of tasks, about, and the share of the time left
    that it may take: 5,914 tasks take half a second, in two threads one, and it is not interrupted.
    """

    uavs: int = 7
    fewest: int = 150
    for_each: int = 32
    begin: float = 0.05
    many: int = 1000
    few: int = 50
    founder: float = 0.002
    early: float = 0.33
    heat: float = 0.02
    last: float = 0.1
    room: float = 1.1
    each: int = 100
    grown: float = 0.17
    after: float = 0.4
    reheated: float = 0.2
    turns: tuple[float, ...] = (0.53, 0.6, 0.73, 0.8, 0.93, 1.0)
    pair: float = 2e-3
    most: float = 0.8

    def fits(self, data: ProblemData, step: float, now: float) -> bool:
        """Return whether there is time for candidate legs, where a step takes such a share of the limit."""
        return self.pair * data.size[0] ** 2 * step <= self.most * (1.0 - now)

    def until(self, now: float, *, parts: bool) -> float:
        """Return when the search that begins now, one of parts or a chained one, gives way to the other."""
        return next((turn for turn in self.turns[parts::2] if turn > now), 1.0)

    def ever(self, costs: Costs, n_tasks: int) -> bool:
        """Return whether there may be a handover at all."""
        return self.assembles(costs, n_tasks) or self.chains(costs, n_tasks)

    def assembles(self, costs: Costs, n_tasks: int) -> bool:
        """Return whether few UAVs fly so long tours that they are edge assembly's."""
        m = _on_one_ring(costs, n_tasks)
        return 1 < m <= self.uavs and n_tasks >= max(self.fewest, self.for_each * m) * m

    def chains(self, costs: Costs, n_tasks: int) -> bool:
        """Return whether tasks are so many and tours so long that a chained search may take over."""
        m = _on_one_ring(costs, n_tasks)
        return m > 1 and n_tasks >= max(self.many, self.few * m)

    def suits_hot(self, data: ProblemData) -> bool:
        """Return whether tours have tasks enough for a search that begins hot."""
        n, m = data.size
        return n >= self.each * m

    def is_hot(self, longest: float, data: ProblemData) -> bool:
        """Return whether that is so and no task decides; `longest` [s] is the incumbent's longest tour."""
        return self.suits_hot(data) and not self._farthest_decides(longest, data)

    def grows(self, longest: float, data: ProblemData) -> bool:
        """Return whether tours grow anew, as the farthest task decides; `longest` [s] is the incumbent's."""
        return self.grown > 0.0 and self._farthest_decides(longest, data)

    def _farthest_decides(self, longest: float, data: ProblemData) -> bool:
        """Return whether `longest` [s] is not well above the trip to the farthest task and back."""
        return longest <= self.room * farthest_trip(data.costs, data.size[0])

    def begins(self, longest: float, data: ProblemData) -> float:
        """Return when the population gives way, if there is to be a chained search."""
        if self.grows(longest, data):
            return 0.0
        return self.early if self.is_hot(longest, data) else self.after


def _on_one_ring(costs: Costs, n_tasks: int) -> int:
    """Return the number of UAVs where they are alike and at one site and costs symmetric, else 0.

    Any ring through all is then a set of tours.
    """
    if not isinstance(costs, AlikeCosts) or costs.out is not costs.into:
        return 0
    from_depots = costs.out[n_tasks:, :n_tasks]
    return len(from_depots) if np.all(from_depots == from_depots[0]) else 0
