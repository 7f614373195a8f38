"""Column generation at a node: master and pricing in turn, until no tour is missing or the bound is low enough.

Duals are smoothed (Wentges 1997) half-way between the best so far and the master's. Every pricing gives a Lagrangian
bound. A pricer that can neither find tours nor exclude them is followed by the next, stronger one. Where the worth is
not modular, the relaxation is tightened by tangents where its solution overestimates the concave extension: at the
solution, and half-way between it and a running mean of solutions, which cuts deeper (in-out separation, Ben-Ameur &
Neto, Networks 49, 2007) and reaches the same bound with a third of the tangents.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from formulations.routing.columns.label_search import Clock
from formulations.selection.duals import Column, DualBound, Duals
from formulations.selection.master import Master, Optimum
from formulations.selection.overestimates import Overestimate
from formulations.selection.pricing import Priced, Prices
from instances.arrays import Floats

_SMOOTHING = 0.5
_EXACT = 1e-7
"""Of the worth: tours that gain less are not worth adding, and tangents that cut off less."""
_MOST_TANGENTS = 30
"""Pairs of tangents taken in one relaxation."""
_MEMORY = 0.7
"""Weight of the mean of solutions so far in the next mean."""


class Ended(Enum):
    """How column generation ended."""

    PRUNED = auto()
    """The bound fell below what is wanted: no better selection is left here."""
    SOLVED = auto()
    """No tour is missing."""
    STUCK = auto()
    """Even the strongest pricer loses labels: tours may be missing."""
    INTERRUPTED = auto()
    """Time is up."""


@dataclass(frozen=True)
class Relaxation:
    """The relaxation as far as it was solved: its best bound, λ and y of the master."""

    ended: Ended
    best: DualBound | None
    at: Optimum
    columns: tuple[Column, ...]


@dataclass(frozen=True)
class Node:
    """What column generation must know of a node: m_g and the bounds of y."""

    counts: Sequence[int]
    lo: Floats
    hi: Floats


def relax(
    master: Master,
    node: Node,
    pricers: Sequence[Prices],
    wanted: Callable[[], float],
    tangent_at: Callable[[Floats], Overestimate] | None,
    best: DualBound | None,
    time_left: Clock,
) -> Relaxation:
    """Solve the relaxation at a node, begun at the duals of `best`, which is a bound of the same node or above."""
    at, level, trust, tangents = master.solve(), 0, 1.0 if best is None else _SMOOTHING, 0
    centre = at.y
    exact = _EXACT * max(abs(wanted()), 1e-9)
    while True:
        duals = at.duals if best is None or trust == 1.0 else best.duals.towards(at.duals, trust)
        priced = _price_all(pricers[level], duals, len(node.counts), exact, time_left)
        if priced is None:
            return _relaxation(Ended.INTERRUPTED, best, at, master)
        least = np.array([p.least for p in priced])
        found = DualBound(duals.bound(least, node.counts, node.lo, node.hi), duals, least)
        if best is None or found.value < best.value:
            best = found
        if best.value < wanted():
            return _relaxation(Ended.PRUNED, best, at, master)
        if master.add([c for p in priced for c in p.columns]):
            at, trust = master.solve(), _SMOOTHING
            continue
        if trust < 1.0:
            trust = 1.0
            continue
        if tangent_at is not None and tangents < _MOST_TANGENTS:
            over = tangent_at(at.y)
            if at.value - over.at(at.y) > 10 * exact and not master.missed:
                centre = _MEMORY * centre + (1 - _MEMORY) * at.y
                master.overestimate([over, tangent_at(0.5 * (at.y + centre))])
                at, trust, tangents = master.solve(), _SMOOTHING, tangents + 1
                continue
        complete = all(p.complete for p in priced)
        if complete or level + 1 == len(pricers):
            return _relaxation(Ended.SOLVED if complete else Ended.STUCK, best, at, master)
        level += 1


def _relaxation(ended: Ended, best: DualBound | None, at: Optimum, master: Master) -> Relaxation:
    return Relaxation(ended, best, at, tuple(master.columns))


def _price_all(pricer: Prices, duals: Duals, groups: int, exact: float, time_left: Clock) -> list[Priced] | None:
    """Price every group; None where time is up before that."""
    priced = []
    for g in range(groups):
        if time_left() <= 0:
            return None
        priced.append(pricer.price(g, duals, -float(duals.rent[g]) - exact))
    return priced
