"""Eras: where many UAVs are packed, a family begins anew from scratch, and late in the search the best of all meet.

Ways of packing are deep traps, and one that is led into early is seldom left: caps lie below its longest tour, its
children are like it, and a restart (lineage.py) keeps its best. So where no shorter tours were found for long, in the
time of the limit and in that which it took to find them, an era ends: its best are set aside and all else is forgotten.
Restarting a search whose times vary widely is well founded (Luby, Sinclair, Zuckerman, IPL 47, 1993); when to do so is
here a matter of what the era has shown. What all eras brought forth is crossed in the end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from formulations.routing.search.tours import Tours


class EraParameters(NamedTuple):
    """When an era ends; times are shares of the limit.

    a280_10, 30 s: 0.12 % (17 seeds), with one era 0.17 to 0.2 %, of which runs end in traps of 0.44 and 0.67 %
    (measured.md).

    stale: for so long nothing shorter was found, at least; factor: and for so long in what the era had taken till then.
    less: share by which the longest tour must be shorter to count as found.
    meeting: when the best of all eras become members; no era begins that would not last `stale` until then.
    """

    stale: float = 0.1
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

    def is_over(self, now: float, how: EraParameters) -> bool:
        """Return whether nothing shorter was found for long, and another era has time."""
        patience = max(how.stale, how.factor * (self.shortened - self.began))
        return now - self.shortened >= patience and now + how.stale <= how.meeting

    def begin(self, champion: Tours, now: float) -> None:
        """Begin the next one; `champion`, the best tours of the last, is kept."""
        self.champions.append(champion)
        self.began, self.shortened, self.shortest = now, now, float("inf")
