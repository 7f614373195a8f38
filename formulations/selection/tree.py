"""The tree over who is selected: best bound first; at a node column generation, a list of tours, cuts, then branching.

Branching, on the first of these that the relaxation leaves undecided:

1. whether a task is selected: y_i = 0 or y_i = 1;
2. whether a group visits a task: no tour of the group does, or none of the others;
3. where tours are listed, whether two tasks are visited by one tour: tours with both of them or with just one are
   dropped (Ryan & Foster 1981); else whether a leg is flown: it is forbidden, or all that could stand in its place;
4. where all is whole and the bound still too high (criteria b and a, whose overestimates are exact nowhere; tours that
   the pricer lost), whether some task is selected that is not decided yet. Where all are, the worth is known.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from formulations.routing.columns.cuts import Cut, separate
from formulations.routing.columns.labelling import Store
from formulations.routing.columns.legs import UavLegs
from formulations.routing.columns.pricing import efforts
from formulations.selection.duals import Column, DualBound
from formulations.selection.fleet import Group
from formulations.selection.generation import Ended, Node, Relaxation, relax
from formulations.selection.master import Master
from formulations.selection.overestimates import Overestimate, tangent
from formulations.selection.pricing import Pool, Pricer, Prices
from formulations.selection.selection import Record
from instances.arrays import Floats

_BINS = 500
_WHOLE = 1e-6
"""A λ or y nearer than this to a whole number is taken for one."""
_FIRST_ROOM = 200_000
"""Labels of the first attempt to list the tours at a node."""
_CUTS_A_ROUND = 30
_ROUNDS = 12
"""Rounds of cuts at a node."""
_LIGHT = 0.3
"""Weight below which a tour is not tried when routes are made of a relaxation."""
_AGAIN = 0.7
"""Of the gap at which listing failed: how small it must be to try again."""
_STALLED = 0.02
"""Of the gap: a round of cuts that closes less was the last."""


@dataclass(frozen=True)
class Branch:
    """A node of the tree: bounds of y, the legs left to each group, or the tours listed, and what to start from."""

    bound: float
    lo: Floats
    hi: Floats
    groups: tuple[Group, ...]
    pool: Pool | None
    columns: tuple[Column, ...]
    cuts: tuple[Cut, ...] = ()
    failed_gap: float = np.inf


class Tree:
    """The tree of one problem; `grow` works on it until proof or limit."""

    def __init__(
        self, record: Record, groups: Sequence[Group], store: Store, tours: int, first: Sequence[Overestimate]
    ) -> None:
        self.record, self.store, self.tours = record, store, tours
        self._uavs, self._closed = [group.uavs for group in groups], 0.0
        n = record.problem.instance.n_tasks
        self.counts = [len(group.uavs) for group in groups]
        self.plain, self.cutting = efforts(n, _BINS)
        self.overestimates = list(first)
        hi = np.logical_or.reduce([group.within() for group in groups]).astype(float)
        root = Branch(record.upper, np.zeros(n), hi, tuple(groups), None, tuple(self._incumbent()))
        self._number = itertools.count()
        self._open = [(-root.bound, next(self._number), root)]
        self.nodes = self.rounds = 0

    def grow(self) -> str:
        """Work on the best node until none is left or time is up; bounds go to the record as they fall."""
        most = self.record.limits.iterations
        while self._open:
            self.record.lower(max(-self._open[0][0], self._closed, self.record.value))
            if self.record.proved:
                return "proof"
            if self.time_left() <= 0:
                return "time"
            if most is not None and self.nodes >= most:
                return "iterations"
            _, _, branch = heapq.heappop(self._open)
            self.nodes += 1
            others = max((-key for key, _, _ in self._open), default=-np.inf)
            for child in self._work(branch, others):
                heapq.heappush(self._open, (-child.bound, next(self._number), child))
        self.record.lower(max(self._closed, float(np.nextafter(self.record.wanted, -np.inf))))
        return "proof" if self.record.proved else "finished"

    def time_left(self) -> float:
        """Return the seconds left."""
        return self.record.remaining

    def _wanted(self) -> float:
        return self.record.wanted

    def _work(self, branch: Branch, others: float) -> list[Branch]:
        """Bound a node and return what is left of it: nothing, itself where time was up, or its children."""
        best: DualBound | None = None
        for rounds in itertools.count():
            relaxed, before = self._relax(branch, best), branch.bound
            self.rounds += 1
            self._offer(relaxed)
            best = relaxed.best
            if best is not None:
                branch = replace(branch, bound=min(branch.bound, best.value), columns=relaxed.columns)
                self.record.lower(max(branch.bound, others, self._closed, self.record.value))
            if branch.bound < self._wanted():
                return []
            if relaxed.ended is Ended.INTERRUPTED or best is None:
                return [branch]
            listed = self._listed(branch, best, _FIRST_ROOM)
            if listed.pool is not None and branch.pool is None:
                branch = listed
                continue
            branch = listed
            stalled = 0 < before - branch.bound < _STALLED * (branch.bound - self._wanted())
            cuts = [] if stalled or rounds >= _ROUNDS else self._cuts(branch, relaxed)
            if not cuts:
                break
            branch = replace(branch, cuts=(*branch.cuts, *cuts))
        assert best is not None
        children = list(self._children(self._listed(branch, best, self.store.last.size), relaxed))
        if not children:  # every task is decided
            worth = self.record.problem.worth
            decided = worth.value(np.flatnonzero(branch.lo > 0).tolist()) + worth.rounding
            self._closed = max(self._closed, min(branch.bound, decided))
        return children

    def _relax(self, branch: Branch, best: DualBound | None) -> Relaxation:
        worth = self.record.problem.worth
        by_tour = worth if branch.pool is not None and worth.subadditive else None
        master = Master(self.counts, branch.lo, branch.hi, 2 * abs(self.record.upper) + 1, by_tour)
        master.overestimate(self.overestimates)
        master.cut_off(branch.cuts)
        master.add(branch.columns)
        pricers: list[Prices] = [branch.pool] if branch.pool is not None else []
        if branch.pool is None:
            wanted = self.cutting if branch.cuts else self.plain
            pricers += [Pricer(branch.groups, effort, self.store, self.time_left) for effort in wanted.pricing]
        tangent_at = None if worth.modular else partial(tangent, worth)
        node = Node(self.counts, branch.lo, branch.hi)
        relaxed = relax(master, node, pricers, self._wanted, tangent_at, best, self.time_left)
        self.overestimates = master.overestimates
        return relaxed

    def _listed(self, branch: Branch, best: DualBound, room: int) -> Branch:
        """Return the node with its tours listed, or its list shortened; as it was where `room` labels are too few."""
        wanted = self._wanted()
        if branch.pool is not None:
            return replace(branch, pool=branch.pool.needed(best, wanted))
        gap = branch.bound - wanted
        if gap > _AGAIN * branch.failed_gap and room <= _FIRST_ROOM:
            return branch
        effort = self.cutting.thorough if branch.cuts else self.plain.thorough
        pricer, worth = Pricer(branch.groups, effort, self.store, self.time_left), self.record.problem.worth
        pool = pricer.listing(best, wanted, worth, room, self.tours)
        return replace(branch, failed_gap=gap) if pool is None else replace(branch, pool=pool)

    def _cuts(self, branch: Branch, relaxed: Relaxation) -> list[Cut]:
        """Return subset-row cuts that the relaxation violates."""
        tours, n = [column.tasks for column in relaxed.columns], branch.lo.size
        return separate(tours, relaxed.at.weight, n, set(branch.cuts), _CUTS_A_ROUND)

    def _offer(self, relaxed: Relaxation) -> None:
        """Offer the tours that weigh most, as far as they do not meet."""
        routes: list[tuple[int, ...]] = [()] * self.record.problem.instance.n_depots
        free, taken = [list(uavs) for uavs in self._uavs], set[int]()
        for p in np.argsort(-relaxed.at.weight, kind="stable"):
            column = relaxed.columns[int(p)]
            if relaxed.at.weight[p] < _LIGHT:
                break
            if free[column.group] and taken.isdisjoint(column.tasks):
                routes[free[column.group].pop()] = column.tasks
                taken.update(column.tasks)
        self.record.offer(tuple(routes))

    def _children(self, branch: Branch, relaxed: Relaxation) -> Iterator[Branch]:
        """Yield the children of a node; none where nothing is left undecided."""
        y = relaxed.at.y
        if (task := _undecided(y)) is not None:
            yield from self._by_task(branch, task)
            return
        weighted = [(c, w) for c, w in zip(relaxed.columns, relaxed.at.weight, strict=True) if w > _WHOLE]
        visits = np.zeros((len(self.counts), y.size))
        for column, weight in weighted:
            visits[column.group, list(column.tasks)] += weight
        if (at := _undecided(visits.reshape(-1))) is not None:
            group, task = divmod(at, y.size)
            yield _forbidden(branch, task, [group])
            others = [g for g in range(len(self.counts)) if g != group]
            yield _forbidden(branch, task, others)
            return
        pool = branch.pool
        by_tours = list(_by_leg(branch, weighted, y.size) if pool is None else _by_pair(branch, pool, weighted, y.size))
        yield from by_tours
        if not by_tours and (branch.lo < branch.hi).any():
            yield from self._by_task(branch, int(np.flatnonzero(branch.lo < branch.hi)[0]))

    def _by_task(self, branch: Branch, task: int) -> Iterator[Branch]:
        """Yield the nodes in which a task is not selected, and in which it is."""
        yield _forbidden(branch, task, range(len(self.counts)), left_out=True)
        lo = branch.lo.copy()
        lo[task] = 1.0
        yield replace(branch, lo=lo)

    def _incumbent(self) -> list[Column]:
        """Return the tours of the best routes known."""
        routes = self.record.routes
        return [Column(g, routes[k]) for g, uavs in enumerate(self._uavs) for k in uavs if routes[k]]


def _undecided(values: Floats) -> int | None:
    """Return where a value is nearest to one half, or None where all are whole."""
    part = np.abs(values - np.round(values))
    return int(part.argmax()) if part.max(initial=0.0) > _WHOLE else None


def _forbidden(branch: Branch, task: int, groups: Sequence[int], left_out: bool = False) -> Branch:
    """Return the node with a task forbidden to some groups; where `left_out`, to all."""
    columns = tuple(c for c in branch.columns if c.group not in groups or task not in c.tasks)
    kept = [_without(group, task) if g in groups else group for g, group in enumerate(branch.groups)]
    pool = None if branch.pool is None else branch.pool.without(task, groups)
    hi = branch.hi.copy()
    hi[task] = 0.0 if left_out else hi[task]
    return replace(branch, hi=hi, groups=tuple(kept), pool=pool, columns=columns)


def _without(group: Group, task: int) -> Group:
    """Return the group with no legs at a task."""
    out, between, home = (part.copy() for part in group.legs)
    out[task] = home[task] = between[task, :] = between[:, task] = np.inf
    return group._replace(legs=UavLegs(out, between, home))


def _by_pair(branch: Branch, pool: Pool, weighted: Sequence[tuple[Column, float]], n: int) -> Iterator[Branch]:
    """Yield the nodes in which two tasks are visited by one tour, and not."""
    both = np.zeros((n, n))
    for column, weight in weighted:
        held = sorted(column.tasks)
        both[np.ix_(held, held)] += weight
    both = np.triu(both, 1)
    if (at := _undecided(both.reshape(-1))) is None:
        return
    i, j = divmod(at, n)
    for together in (True, False):
        kept = tuple(
            c for c in branch.columns if ((i in c.tasks) == (j in c.tasks)) == together or not _either(c, i, j)
        )
        yield replace(branch, pool=pool.paired(i, j, together), columns=kept)


def _either(column: Column, i: int, j: int) -> bool:
    return i in column.tasks or j in column.tasks


def _by_leg(branch: Branch, weighted: Sequence[tuple[Column, float]], n: int) -> Iterator[Branch]:
    """Yield the nodes in which a leg between tasks is not flown, and in which nothing else is at its ends."""
    flown = np.zeros((n, n))
    for column, weight in weighted:
        for i, j in itertools.pairwise(column.tasks):
            flown[i, j] += weight
    if (at := _undecided(flown.reshape(-1))) is None:
        return
    i, j = divmod(at, n)
    for forced in (False, True):
        groups = tuple(group._replace(legs=_leg(group.legs, i, j, forced)) for group in branch.groups)
        kept = tuple(c for c in branch.columns if _flies(groups[c.group].legs, c.tasks))
        yield replace(branch, groups=groups, columns=kept)


def _leg(legs: UavLegs, i: int, j: int, forced: bool) -> UavLegs:
    """Return the legs without i → j or, where it is `forced`, without all others from i and into j."""
    out, between, home = (part.copy() for part in legs)
    if not forced:
        between[i, j] = np.inf
        return UavLegs(out, between, home)
    kept = between[i, j]
    between[i, :], between[:, j], home[i], out[j] = np.inf, np.inf, np.inf, np.inf
    between[i, j] = kept
    return UavLegs(out, between, home)


def _flies(legs: UavLegs, tasks: Sequence[int]) -> bool:
    """Say whether a tour uses only legs that are left."""
    between = all(np.isfinite(legs.between[i, j]) for i, j in itertools.pairwise(tasks))
    return bool(between and np.isfinite(legs.out[tasks[0]]) and np.isfinite(legs.home[tasks[-1]]))
