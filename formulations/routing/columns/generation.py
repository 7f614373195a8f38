"""Column generation: the master and pricing in turn, until the capped relaxation is solved or its bound passes the cap.

Only tours of cost ≤ cap < U exist, which is what makes the bound strong: a relaxation without columns enough is itself
a proof. Duals are smoothed (`smoothing.py`): priced between the best so far and the master's; where that finds nothing
the master's own are priced. Every pricing gives a Lagrangian bound. A pricer that can neither find columns nor exclude
them is followed by the next, stronger one; so is one that loses labels and has hardly brought value and bound together
for some rounds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from formulations.routing.columns.label_search import Clock
from formulations.routing.columns.master import Master, Optimum
from formulations.routing.columns.pricing import DualBound, Duals, Priced, Prices
from formulations.routing.columns.smoothing import HALF_WAY, adapted
from instances.arrays import Floats

_CLOSE = 0.02  # of the gap to the cap: how near the master's value and the bound must come
_PROGRESS, _DULL = 0.02, 3  # share by which the span from bound to value shrinks, and rounds in which it does not
_EXACT = 1e-7  # of the cap: columns that gain less are not worth adding


class Ended(Enum):
    """How column generation ended."""

    PRUNED = auto()
    """The bound passed the cap: no routes below it are left."""
    SOLVED = auto()
    """No column is missing that could lower the master's value by more than a fraction of the gap."""
    STUCK = auto()
    """Even the strongest pricer loses labels: columns may be missing."""
    INTERRUPTED = auto()
    """Time is up."""
    OVERTAKEN = auto()
    """Meanwhile the cap has fallen."""


@dataclass(frozen=True)
class Relaxation:
    """The capped relaxation as far as it was solved: its best bound, and λ of the master's columns, `weight`."""

    ended: Ended
    best: DualBound
    weight: Floats
    rounds: int


def generate(
    master: Master,
    pricers: Sequence[Prices],
    cap: float,
    time_left: Clock,
    centre: DualBound | None = None,
    reserve: Prices | None = None,
    start: Duals | None = None,
    meanwhile: Callable[[DualBound, int], bool] = lambda _best, _in_vain: False,
    roughly: bool = False,
    steady: bool = False,
) -> Relaxation:
    """Solve the relaxation over tours of cost ≤ `cap`, by `pricers` from the quickest to the strongest.

    centre : the best bound of a relaxation with no fewer tours and no more cuts; it still holds, and new duals are
        sought near it. With it alone to fall back to, generation is stuck as soon as the strongest pricer loses labels
        and hardly raises the bound.
    reserve : prices some tours of some UAVs quickly; what it finds needs no other pricer, that it finds none is no
        bound.
    start : duals to seek others near, and to price first where no centre is known. With these, what the strongest
        pricer loses labels for may take some rounds in which it hardly brings value and bound together.
    meanwhile : told of the best bound so far and the labels made by the strongest pricer where it loses some, which may
        go on and on; says whether the cap has fallen.
    roughly : no bound is asked for: it is stuck as well where value and bound are hardly brought together any more.
    steady : smoothing stays half-way, as it does where a start is given.
    """
    optimum = _settled(master, reserve, cap, time_left)
    best, trust = DualBound(-np.inf, optimum.duals if optimum else master.any_duals, np.zeros(pricers[0].n_uavs)), 1.0
    if centre is not None:
        best, trust = centre, HALF_WAY
    elif start is not None:
        best, trust = replace(best, duals=start), 0.0
    ladder, rounds, share = _Ladder(pricers), 0, HALF_WAY
    while optimum is not None:
        rounds += 1
        value, at_master, weight = optimum
        duals = best.duals.towards(at_master, trust)
        priced = _price_all(ladder.pricer, master, duals, cap, time_left)
        if priced is None:
            break
        least = np.array([min(0.0, priced[k].least) for k in master.first])
        found = DualBound(duals.offset + float(least.sum()) - duals.margin(cap, master.m), duals, least)
        rise = found.value - best.value
        if trust < 1.0 and start is None and not steady:
            share = adapted(share, priced, duals, master, at_master)
        if rise > 0:
            best = found
        if best.value > cap:
            return Relaxation(Ended.PRUNED, best, weight, rounds)
        complete = all(p.complete for p in priced.values())
        if ladder.at_top and not complete and meanwhile(best, sum(p.in_vain for p in priced.values())):
            return Relaxation(Ended.OVERTAKEN, best, weight, rounds)
        alone = centre is not None and start is None
        if alone and ladder.at_top and not complete and rise < _CLOSE * (cap - best.value):
            return Relaxation(Ended.STUCK, best, weight, rounds)
        dull, widened = ladder.dull(complete, value - best.value), False
        if master.add([c for p in priced.values() for c in p.columns]):
            optimum = _settled(master, reserve, cap, time_left)
            if optimum is None:
                break
            value, _, weight = optimum
            close = value - best.value <= _CLOSE * (cap - best.value)
            if close and not master.penalised:
                return Relaxation(Ended.SOLVED, best, weight, rounds)
            widened, trust = close and master.widen(2 * cap), share if value - best.value > _EXACT * cap else 1.0
        elif trust < 1.0:
            trust = 1.0
        elif not (widened := master.widen(2 * cap)):
            if complete or ladder.at_top:
                return Relaxation(Ended.SOLVED if complete else Ended.STUCK, best, weight, rounds)
            dull = True
        if widened:
            optimum = _settled(master, reserve, cap, time_left)
            ladder = _Ladder(pricers)
        elif dull:
            if ladder.at_top and (roughly or start is not None):
                return Relaxation(Ended.STUCK, best, weight, rounds)
            ladder.climb()
    return Relaxation(Ended.INTERRUPTED, best, np.zeros(len(master.columns)), rounds)


@dataclass
class _Ladder:
    """The pricers from the quickest to the strongest, the one in use, and how far it has brought value and bound."""

    pricers: Sequence[Prices]
    at: int = 0
    rounds_dull: int = 0
    span: float = np.inf

    @property
    def pricer(self) -> Prices:
        """The one in use."""
        return self.pricers[self.at]

    @property
    def at_top(self) -> bool:
        """Whether it is the strongest."""
        return self.at + 1 == len(self.pricers)

    def climb(self) -> None:
        """Go on to the next, if there is one."""
        self.at, self.rounds_dull = min(self.at + 1, len(self.pricers) - 1), 0

    def dull(self, complete: bool, span: float) -> bool:
        """Say whether this one loses labels and has hardly brought value and bound, `span` [s] apart, closer lately."""
        hardly = not complete and span > (1 - _PROGRESS) * self.span
        self.rounds_dull, self.span = self.rounds_dull + 1 if hardly else 0, min(self.span, span)
        return self.rounds_dull >= _DULL


def _settled(master: Master, reserve: Prices | None, cap: float, time_left: Clock) -> Optimum | None:
    """Solve the master over its columns and all of the reserve; None where time is up."""
    optimum = master.solve(time_left)
    while reserve is not None and optimum is not None:
        priced = _price_all(reserve, master, optimum.duals, cap, time_left)
        if priced is None or not master.add([c for p in priced.values() for c in p.columns]):
            break
        optimum = master.solve(time_left)
    return optimum


def _price_all(pricer: Prices, master: Master, duals: Duals, cap: float, time_left: Clock) -> dict[int, Priced] | None:
    """Price the first UAV of every kind; None where time is up."""
    priced = pricer.price_all(master.uavs.tolist(), duals, -duals.rent - _EXACT * cap)
    return None if time_left() <= 0 else priced
