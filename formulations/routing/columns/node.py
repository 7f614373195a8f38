"""A node of the tree: the tours it still allows, its bound, and what all nodes share.

A node holds the legs of a UAV while its tours are too many to list, and lists them in its pool from then on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from formulations.routing.columns.cuts import Cut
from formulations.routing.columns.label_search import Clock
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import WIDE, Master
from formulations.routing.columns.pool import Pool
from formulations.routing.columns.pricing import Column, DualBound, Duals, Effort, Efforts, Pricer
from formulations.routing.columns.proof_log import ProofLog
from formulations.routing.columns.recall import Recall
from formulations.routing.columns.team import Team
from instances.arrays import Bools, Floats, Ints

_NARROW = 0.2  # fair shares of the cap: half width of the box that duals begin in where something is known of them
_FIRST_ROOM = 4_000_000  # labels of the first attempt to list the tours where cuts do no more


@dataclass
class Tries:
    """Leaves out tries of what seldom works: after each that failed one more, after one that did not, none."""

    failed: int = 0
    left_out: int = 0

    def due(self) -> bool:
        """Say whether to try this time."""
        self.left_out += 1
        return self.left_out > self.failed

    def note(self, worked: bool) -> None:
        """Learn how a try ended."""
        self.failed, self.left_out = 0 if worked else self.failed + 1, 0


@dataclass(frozen=True)
class Hint:
    """What a relaxation of value `level` [s] says of routes: some of its tours may be tours of the best.

    long : tours of the UAVs that make it as long as it is; used : all tours in use and their weights λ > 0.
    """

    level: float
    long: Sequence[Column] = ()
    used: Sequence[tuple[Column, float]] = ()


def nothing_better(hint: Hint) -> bool:
    """Search for no routes beside the tree; return that there are none better."""
    return False


@dataclass
class Workspace:
    """What all nodes share: clock, team with room for labels, limits, efforts and the counters of the statistics.

    plain, cutting : how hard to work at a node without cuts, and at one with cuts.
    far : the cheapest way to each task and back [s].
    walks : how hard to price walks, where relaxations begin with them (`walks.py`), else None.
    better : asked after every relaxation: searches on for better routes, and says whether there are any.
    dives : when to look for routes among the columns of a node.
    recall : what pricing has learnt to remember.
    hasty : whether a node is left as soon as pricing is dear and gains little, not branched on.
    """

    time_left: Clock
    team: Team
    tours_room: int
    plain: Efforts
    cutting: Efforts
    far: Floats
    recall: Recall
    better: Callable[[Hint], bool] = nothing_better
    counts: Counter[str] = field(default_factory=Counter)
    walks: Effort | None = None
    log: ProofLog = field(default_factory=ProofLog)
    dives: Tries = field(default_factory=Tries)
    hasty: bool = False

    def pricer(self, legs: Legs, cap: float, effort: Effort) -> Pricer:
        """Return a pricer of one effort."""
        team = self.team
        return Pricer(legs, cap, effort, team, lambda: 0.0 if team.over else self.time_left(), self.recall, team.each)

    def meanwhile(self, level: float, in_vain: int) -> bool:
        """Search on while a relaxation at `level` [s] goes on, after `in_vain` labels lost; say whether that helps."""
        self.counts["labels in vain"] += in_vain
        return self.better(Hint(level))


@dataclass
class Node:
    """Tours allowed (by `legs`, or in `pool` where a UAV is listed), a valid `bound` [s], columns and cuts to start.

    number : the node's place in the proof that is kept; proof : the prices at which `bound` holds.
    centre : the best bound of the last relaxation solved here or above.
    listing_failed : gap [s] at which the tours did not fit a list.
    room, last_failed : labels to list the tours with where cuts do no more, and the gap [s] at which that failed.
    fixed_at : gap [s] at which legs were fixed away last, here or above.
    kinds : UAVs of one number are alike: any permutation of them turns routes allowed here into such routes.
    reserve : some tours of UAVs that are not listed, to look for columns in first; reserved_at : where it was made.
    exempt : UAVs whose costs the relaxation does not count (`exempting.py`); level [s] : what it came to with them.
    """

    legs: Legs
    bound: float
    columns: list[Column]
    pool: Pool
    kinds: Ints
    reserve: Pool
    cuts: tuple[Cut, ...] = ()
    centre: DualBound | None = None
    room: int = _FIRST_ROOM
    listing_failed: float = np.inf
    last_failed: float = np.inf
    fixed_at: float = np.inf
    number: int = 0
    proof: DualBound | None = None
    reserved_at: DualBound | None = None
    exempt: frozenset[int] = frozenset()
    level: float = -np.inf

    @classmethod
    def root(cls, legs: Legs, bound: float, columns: list[Column], kinds: Ints) -> Node:
        """Return a node of which nothing is known but its legs, a bound and some columns."""
        pool = Pool.empty(legs.n_uavs, legs.n_tasks)
        return cls(legs, bound, columns, pool, kinds, pool)

    def may_visit(self) -> Bools:
        """Say which UAV may still take which task, shape (m, n)."""
        return np.where(self.pool.listed[:, None], self.pool.may_visit(self.legs.n_tasks), self.legs.may_visit())

    def raise_bound(self, best: DualBound) -> None:
        """Take a bound where it is higher."""
        if best.value > self.bound:
            self.bound, self.proof = best.value, best

    def alike(self, k: int) -> list[int]:
        """Return the UAVs like UAV k, itself among them."""
        return np.flatnonzero(self.kinds == self.kinds[k]).tolist()

    def giving(self, task: int, k: int, number: int) -> Node:
        """Return the node with `task` given to UAV k, which is then like no other."""
        apart = replace(self, columns=self._for_all_alike(self.columns))
        child = apart.child(task, [other for other in range(self.legs.n_uavs) if other != k], number)
        child.kinds = np.where(np.arange(self.kinds.size) == k, self.kinds.max() + 1, self.kinds)
        return child

    def _one_apart(self) -> Ints:
        """Return `kinds` with the first UAV of every kind told apart."""
        _, first = np.unique(self.kinds, return_index=True)
        kinds = self.kinds.copy()
        kinds[first] = self.kinds.max() + 1 + np.arange(first.size)
        return kinds

    def _for_all_alike(self, columns: list[Column]) -> list[Column]:
        """Return columns, which are kept for one of the UAVs that are alike, for each of them."""
        alike = [self.alike(k) for k in range(self.kinds.size)]
        return [column if k == column.uav else replace(column, uav=k) for column in columns for k in alike[column.uav]]

    def child(self, task: int, uavs: list[int], number: int) -> Node:
        """Return the node with `task` forbidden to `uavs`."""
        columns = [c for c in self.columns if c.uav not in uavs or task not in c.tasks]
        pool, reserve = (tours.without(task, uavs) for tours in (self.pool, self.reserve))
        legs = self.legs.without(task, uavs)
        return replace(self, legs=legs, columns=columns, pool=pool, reserve=reserve, number=number)

    def exempt_cost_of(self, k: int, level: float) -> None:
        """Count the cost of UAV k no more, with which the relaxation comes to `level` [s]: it begins anew."""
        self.exempt, self.level, self.centre = self.exempt | {k}, max(self.level, level), None
        self.fixed_at = self.listing_failed = self.last_failed = np.inf

    def lighten(self, cap: float) -> None:
        """Drop the cuts that nothing pays for, and the columns that are in no routes of cost ≤ `cap`."""
        if self.centre is None:
            return
        duals, allowed = self.centre.duals.paid(), self.centre.allowed(cap)
        self.cuts, self.centre = duals.cuts, replace(self.centre, duals=duals)
        uav = np.array([c.uav for c in self.columns], dtype=np.int64)
        needed = duals.values(self.columns) <= allowed[uav]
        self.columns = [self.columns[p] for p in np.flatnonzero(needed)]

    def restricted_master(self, cap: float, *, near: Duals | None = None, apart: bool = False) -> Master:
        """Return the restricted master of the columns of cost ≤ `cap`; of those alike one is told `apart` if asked.

        Duals begin in a narrow box around those they are said to be `near`, which keeps them from swinging until there
        are columns enough; else in one of twenty fair shares, or twice what they were above.
        """
        n = self.legs.n_tasks
        half, middle = np.full(n, WIDE * cap / n), np.zeros(n)
        if near is not None:
            half, middle = np.full(n, _NARROW * cap / n), near.price
        elif self.centre is not None:
            half = np.maximum(half, 2 * np.abs(self.centre.duals.price))
        columns = [c for c in self.columns if c.cost <= cap]
        master = Master(n, self._one_apart() if apart else self.kinds, half, self.cuts, middle, self.exempt)
        master.add(self._for_all_alike(columns) if apart else columns)
        return master
