"""Eras: where many UAVs are packed, a family begins anew from scratch, and late in the search the best of all meet.

Ways of packing are deep traps, and one that is led into early is seldom left: caps lie below its longest tour, its
children are like it, and a restart (lineage.py) keeps its best. So an era ends where no shorter tours were found for
long, beside the limit and beside what it took to find the last: its best are set aside, all else is forgotten. To begin
anew pays where the times of runs vary widely (Luby, Sinclair, Zuckerman, IPL 47, 1993). What all eras brought forth is
crossed in the end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from formulations.routing.search.tours import Tours


class EraParameters(NamedTuple):
    """When an era ends; times are shares of the limit.

    a280_10, 30 s, six seeds: 0.03 %, in one era 0.07 %; which traps runs end in otherwise: measured.md.

    stale: how long nothing shorter was found, at least; founders: the same, in founders' lengths; factor: the same, as
    a multiple of what the last took to find.
    less: share by which the longest tour must be shorter to count as found.
    meeting: when the best of all eras become members; none begins with less than it may be stale left.
    """

    stale: float = 0.1
    founders: float = 30.0
    factor: float = 2.0
    less: float = 4e-5
    meeting: float = 0.85


@dataclass
class Eras:
    """The era of a family under way, and the best tours of those before; times are fractions of the limit.

    began: when it did; shortened: when its longest tour was last found to be shorter, which then was `shortest` [s].
    """

    champions: list[Tours] = field(default_factory=list)
    began: float = 0.0
    shortened: float = 0.0
    shortest: float = float("inf")

    def note(self, longest: float, now: float, how: EraParameters) -> None:
        """Learn the longest of the best tours of this era."""
        if longest < (1.0 - how.less) * self.shortest:
            self.shortest, self.shortened = longest, now

    def is_over(self, now: float, founder: float, how: EraParameters) -> bool:
        """Return whether nothing shorter was found for long, and another era has time; `founder` is its stage's length.

        Both as fractions of the limit.
        """
        stale = max(how.stale, how.founders * founder)
        patience = max(stale, how.factor * (self.shortened - self.began))
        return now - self.shortened >= patience and now + stale <= how.meeting

    def begin(self, champion: Tours, now: float) -> None:
        """Begin the next one; `champion`, the best tours of the last, is kept."""
        self.champions.append(champion)
        self.began, self.shortened, self.shortest = now, now, float("inf")
