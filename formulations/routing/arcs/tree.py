"""The tree over arcs: down from case to case until one is closed, then on from the newest open one.

Cases that follow each other then have most of their cuts in common, which a third less rounds came of than of going on
from the least bound. Every tenth time it is the least, for bounds to rise meanwhile.

A case is solved, cut and solved again until its bound passes the cap, or cuts hardly raise it; then it is split where
that raises the value of both cases after it most, as trials say: first on who takes which task, then on arcs
(Applegate, Bixby, Chvátal & Cook, "Finding cuts in the TSP", DIMACS 1995).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from enum import Enum, auto

import numpy as np

from formulations.routing.arcs.case import Case, Fly, Give, Split
from formulations.routing.arcs.helper import TURN, Found, Helper
from formulations.routing.arcs.programme import Programme
from formulations.routing.arcs.proof import ArcProof
from formulations.routing.proved import StoppedBy
from formulations.routing.recorder import Recorder
from instances import Routes
from instances.arrays import Floats, Ints

_PIVOTS = 40
"""Pivots of a trial."""
_PROGRESS, _DULL = 0.02, 5
"""Share of the gap that a round of cuts is to close, and rounds in which it may close less."""
_WHOLE, _UNDECIDED = 1e-5, 1e-6
"""What numbers may be off whole ones in routes, and from where on a split tells them apart."""
_LOWEST = 10
"""Of so many closed cases one is followed by that of the least bound."""
_WAIT = 0.05
"""How long to wait for a helper where nothing else is to be done [s]."""
_LEAST = 1e-6
"""What a trial counts for at least."""


class Settled(Enum):
    """How the work on a case ended."""

    CLOSED = auto()
    """Its bound passed the cap."""
    OPEN = auto()
    """Nothing but a split helps."""
    ROUTES = auto()
    """The programme has come to routes, as far as its tolerances tell."""
    STUCK = auto()
    """The programme could not be solved: its bound holds as far as it got."""
    INTERRUPTED = auto()
    """Time is up; the same."""


class CaseTree:
    """Branch and cut over a programme.

    kinds (m,) : UAVs of one number are alike; unit [s] : that of the programme's costs; far (n,) : the way to each
    task and back; remaining : how long it may go on [s]; tried : splits that are tried before one is chosen.

    better : searches on for routes where that is due; proof : keeps what bounds rest on; helpers : work on cases too,
    where no proof is kept. None does anything unless set.
    """

    def __init__(
        self,
        programme: Programme,
        kinds: Ints,
        unit: float,
        far: Floats,
        remaining: Callable[[], float],
        tried: int,
    ) -> None:
        self.programme, self.unit, self.far, self.remaining, self.tried = programme, unit, far, remaining, tried
        self.better: Callable[[], object] = lambda: None
        self.proof, self.counts = ArcProof(), Counter[str]()
        self.helpers: Sequence[Helper] = ()
        self._open: list[Case] = []
        """The newest last."""
        self._next: Case | None = Case.root(kinds, programme.n)
        self._stuck, self._taken = math.inf, 0

    def bound(self, cap: float) -> float:
        """Return a lower bound on all routes, no higher than `cap` [s]."""
        least = min([self._stuck, *(case.bound for case in self._open), *(helper.bound for helper in self.helpers)])
        least = least if self._next is None else min(least, self._next.bound)
        return min(cap, self.unit * least)

    def close(self) -> None:
        """Note the cases left open in the proof that is kept."""
        for case in self._open:
            self.proof.leave(case)
        if self._next is not None:
            self.proof.leave(self._next)

    def grow(self, recorder: Recorder, cap: Callable[[], float], nodes: float) -> StoppedBy:
        """Improve the recorder's routes and bound until no case is below the `cap` [s], or until stopped."""
        while self._any_left() and cap() > 0:  # no routes cost less than nothing
            if nodes <= 0 or self.remaining() <= 0:
                return StoppedBy.ITERATIONS if nodes <= 0 else StoppedBy.TIME
            if self._next is None and not self._open:
                self._share(recorder, cap(), _WAIT)
                recorder.raise_bound(self.bound(cap()))
                continue
            self._next = self._next or self._take()
            settled = self._settle(cap)
            if settled is Settled.INTERRUPTED:
                recorder.raise_bound(self.bound(cap()))
                return StoppedBy.TIME
            self.counts["nodes"] += 1
            nodes -= 1
            if settled is Settled.ROUTES:
                recorder.incumbent(self._routes())
            self.better()
            self._after(settled, cap())
            self._share(recorder, cap(), 0.0)
            recorder.raise_bound(self.bound(cap()))
        return StoppedBy.PROOF if self.unit * self._stuck > cap() or cap() <= 0 else StoppedBy.STUCK

    def turn(self, cases: list[Case], recorder: Recorder, cap: float) -> Found:
        """Work on some cases alone, as a helper does."""
        self._open, self._next, self._stuck, self.counts = cases, None, math.inf, Counter()
        self.grow(recorder, lambda: cap, TURN)
        left = self._open if self._next is None else [*self._open, self._next]
        return Found(left, self._stuck, recorder.routes, self.counts)

    def _any_left(self) -> bool:
        """Say whether any case is open, here or with a helper."""
        return self._next is not None or bool(self._open) or any(helper.cases for helper in self.helpers)

    def _share(self, recorder: Recorder, cap: float, wait: float) -> None:
        """Take in what helpers have found, for which to `wait` [s], and deal out cases anew, the oldest first."""
        for helper in self.helpers:
            if helper.busy and (found := helper.end(wait)) is not None:
                self.counts += found.counts
                self._stuck = min(self._stuck, found.stuck)
                if found.routes is not None:
                    recorder.incumbent(found.routes)
            if helper.busy:
                continue
            helper.cases = [case for case in helper.cases if case.bound * self.unit <= cap]
            spare = self._open if self._next is not None else self._open[:-1]
            if not helper.cases and spare:
                helper.cases = [self._open.pop(0)]
            if helper.cases and not (self._open or self._next):
                self._open.append(helper.cases.pop(0))
            if not helper.alive:
                self._open[:0], helper.cases = helper.cases, []
            if helper.cases:
                helper.begin(cap, self.remaining())

    def _take(self) -> Case:
        """Take an open case to go on with."""
        self._taken += 1
        if self._taken % _LOWEST:
            return self._open.pop()
        return self._open.pop(min(range(len(self._open)), key=lambda at: self._open[at].bound))

    def _settle(self, cap: Callable[[], float]) -> Settled:
        """Work on the next case until it is closed, or cuts do no more."""
        case, programme, dull = self._next, self.programme, 0
        assert case is not None
        if case.lost:
            self._next = replace(case, bound=math.inf)
            return Settled.CLOSED
        programme.enter(case)
        while True:
            if not programme.solve(self.remaining()):
                return Settled.STUCK if self.remaining() > 0 else Settled.INTERRUPTED
            self.counts["rounds"] += 1
            rise, case = programme.bound - case.bound, self._raised(programme.bound)
            if case.bound > cap() / self.unit:
                return Settled.CLOSED
            if self.remaining() <= 0:
                return Settled.INTERRUPTED
            whole = bool((np.abs(programme.theta - np.round(programme.theta)) < _WHOLE).all())
            found, grown = programme.cut(cap() / self.unit), programme.grow()
            self.counts["cuts"] += found
            if not found and not grown and not programme.insist():
                return Settled.ROUTES if whole else Settled.OPEN
            dull = dull + 1 if not grown and rise < _PROGRESS * (cap() / self.unit - case.bound) else 0
            if dull > _DULL and not whole and case.number > 0 and programme.solve(self.remaining()):
                case = self._raised(programme.bound)
                return Settled.CLOSED if case.bound > cap() / self.unit else Settled.OPEN

    def _raised(self, bound: float) -> Case:
        """Raise the bound of the next case, and return it."""
        assert self._next is not None
        if bound > self._next.bound:
            self._next = replace(self._next, bound=bound)
            self.proof.raise_bound(self._next, self.programme.prices)
        return self._next

    def _after(self, settled: Settled, cap: float) -> None:
        """Close the case worked on, or split it; go on with one of those after it."""
        case, self._next = self._next, None
        assert case is not None
        self.programme.forget()
        if case.bound * self.unit > cap:
            self.proof.leave(case)
            return
        split = None if settled is Settled.STUCK else self._choose(case, cap / self.unit)
        if split is None:  # stuck, or nothing is left to be decided
            self._stuck = min(self._stuck, case.bound)
            self.proof.leave(case)
            return
        without, within = (
            replace(part, number=self.proof.split(case, split, part))
            for part in (split.without(case), split.within(case))
        )
        self._open.append(without)
        self._next = within

    def _choose(self, case: Case, cap: float) -> Split | None:
        """Return the split that raises the values of the cases after it most."""
        if case.all_alike:  # whoever takes the task farthest out may be called the first
            return Give(0, int(np.argmax(self.far)))
        programme = self.programme
        candidates = self._candidates(case)[: self.tried]
        if len(candidates) < 2:
            return candidates[0] if candidates else None
        worth: list[float] = []
        if not programme.solve(self.remaining()):
            return candidates[0]
        for split in candidates:
            rises = [programme.trial(part(case), _PIVOTS) - programme.value for part in (split.without, split.within)]
            worth.append(math.prod(min(max(rise, _LEAST), cap) for rise in rises))
        return candidates[int(np.argmax(worth))]

    def _candidates(self, case: Case) -> list[Split]:
        """Return splits that the programme's θ leaves open, the most undecided first: tasks, else edges, else arcs.

        Where it leaves none but the case does, by less than the programme can tell, those that it says are decided.
        """
        theta, n = self.programme.theta, self.programme.n
        visits = theta[:, :, :n].sum(axis=1)
        _, first = np.unique(case.kinds, return_index=True)
        undecided = (~case.forbidden).sum(axis=0) > 1
        open_visits = np.minimum(visits, 1.0 - visits) * self.far * undecided
        pairs = [(k, i) for k in first.tolist() for i in np.flatnonzero(open_visits[k] > _UNDECIDED * self.far)]
        if pairs:
            pairs.sort(key=lambda pair: -open_visits[pair])
            return [Give(k, int(i)) for k, i in pairs]
        flown = theta.sum(axis=0)[:n, :n]
        for values, both in ((np.tril(flown + flown.T), True), (flown, False)):
            undecided = np.minimum(values, 1.0 - values)
            arcs = np.argwhere(undecided > _UNDECIDED)
            if arcs.size:
                order = np.argsort(-undecided[tuple(arcs.T)], kind="stable")
                return [_fly(i, j, both) for i, j in arcs[order].tolist()]
        taken = np.argwhere((visits[first] > 0.5) & ((~case.forbidden).sum(axis=0) > 1))
        flies = (_fly(i, j, False) for i, j in np.argwhere(flown > 0.5).tolist())
        return [Give(int(first[k]), i) for k, i in taken.tolist()] or [
            split for split in flies if split.arcs not in case.needed
        ]

    def _routes(self) -> Routes:
        """Return the routes that θ is."""
        return tuple(tuple(_tour(theta > 0.5)) for theta in self.programme.theta)


def _fly(i: int, j: int, both: bool) -> Fly:
    return Fly(((i, j), (j, i)) if both else ((i, j),))


def _tour(arcs: np.ndarray) -> Iterable[int]:
    """Yield the tasks of a tour of these arcs, (n + 1, n + 1), the depot last."""
    depot = len(arcs) - 1
    here = depot
    while arcs[here].any() and (here := int(np.argmax(arcs[here]))) != depot:
        yield here
