"""Refinement: the headings of given routes, chosen from few candidates, then improved between them.

Of a tour with stops s = 0 … w, each with candidate headings, the best chain is a min-plus programme along it

    F_0(a) = 0,   F_s(b) = min_a F_{s−1}(a) + c_s(a, b),   C = min_a F_w(a)

(for each heading to begin with, where the tour must end with the same). Then every heading gets a few neighbours,
δ apart, and the programme is run again; where that gains nothing δ is halved. The headings known are always among the
candidates, so no round is worse than the one before. It finds the best of its neighbourhood, not of all headings.

What a leg costs is a function: its time over open country, in calm air or a steady wind (`open_legs`), or whatever else
is flown, such as legs that must stay in a polygon (`tracks.legs_inside`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from formulations.moving_cost.turns.headings import HeadingStates, headings
from formulations.moving_cost.turns.interval import free_end
from formulations.moving_cost.turns.travel import Turns, steady_turns_of
from formulations.moving_cost.turns.wind import wind_path_free
from instances import Instance, Routes
from instances.arrays import Floats
from instances.errors import InputError

Candidates = Floats | None
"""Headings [rad] at a stop, (a,); None: any heading, as at a depot that is free."""
LegCosts = Callable[[int, Candidates, Candidates], Floats]
"""What leg s, from stop s to stop s + 1, costs from each heading to each, (a, b), with 1 for None [any unit]."""

SPREAD = 2
"""Neighbours of a heading on either side."""
_WIDEST, _NARROWEST = 2 * np.pi / 64, 1e-6
_GAIN = 1e-9
"""Share by which a round must be better for the next to be as wide."""
_UNIFORM, _SIGHTS = 32, 3
"""Candidates beside those of the instance: uniform headings, and nearest nodes in whose line of sight they are."""


@dataclass(frozen=True)
class Chain:
    """Headings [rad] at the stops of a tour, (w + 1,), not a number where any was allowed, and what the tour costs."""

    headings: Floats
    cost: float


def best_chain(candidates: Sequence[Candidates], legs: LegCosts, *, closed: bool = False) -> Chain:
    """Return the cheapest chain of headings through the stops.

    candidates : of each stop, two stops or more. closed : whether the first and the last heading, of the same
        candidates, must be one.
    """
    begin = 1 if candidates[0] is None else len(candidates[0])
    spent = np.where(np.eye(begin, dtype=bool), 0.0, np.inf) if closed else np.zeros((1, begin))
    came = []
    for s, (here, there) in enumerate(pairwise(candidates)):
        total = spent[:, :, None] + legs(s, here, there)[None]
        came.append(total.argmin(axis=1))
        spent = total.min(axis=1)
    ends = np.where(np.eye(begin, dtype=bool), spent, np.inf) if closed else spent
    first, at = np.unravel_index(int(ends.argmin()), ends.shape)
    chosen = [int(at)]
    for step in came[::-1]:
        chosen.append(int(step[first, chosen[-1]]))
    picked = [np.nan if c is None else c[i] for c, i in zip(candidates, chosen[::-1], strict=True)]
    return Chain(np.array(picked), float(ends.min()))


def refine(candidates: Sequence[Candidates], legs: LegCosts, *, closed: bool = False) -> Chain:
    """Return the best chain of the candidates, improved between them; arguments as of `best_chain`."""
    best, width = best_chain(candidates, legs, closed=closed), _WIDEST
    around = np.concatenate([[0.0], np.arange(1, SPREAD + 1), -np.arange(1.0, SPREAD + 1)])
    while width > _NARROWEST:
        near = [None if math.isnan(heading) else heading + width * around for heading in best.headings]
        found = best_chain(near, legs, closed=closed)
        if not found.cost < best.cost * (1 - _GAIN):
            width /= 2
        if found.cost < best.cost:
            best = found
    return best


def open_legs(stops: Floats, turns: Turns) -> LegCosts:
    """Return what legs between `stops` [m], (w + 1, 2), cost over open country [s]."""

    def legs(s: int, here: Candidates, there: Candidates) -> Floats:
        lows, widths = zip(*((np.zeros(1), 2 * np.pi) if c is None else (c, 0.0) for c in (here, there)), strict=True)
        nodes = np.repeat([0, 1], [len(each) for each in lows])
        states = HeadingStates(nodes, np.concatenate(lows), np.array(widths)[nodes])
        lengths = turns.lengths(np.ascontiguousarray(stops[s : s + 2]), states)
        return np.asarray(lengths[: len(lows[0]), len(lows[0]) :]) / turns.speed

    return legs


def flown_headings(chain: Chain, stops: Floats, turns: Turns) -> Floats:
    """Return the headings [rad] at `stops` [m] over open country, with those of the quickest paths at free ends."""
    flown = chain.headings.copy()
    if math.isnan(flown[0]):
        flown[0] = _free_heading(stops[1] - stops[0], True, flown[1], turns)
    if math.isnan(flown[-1]):
        flown[-1] = _free_heading(stops[-1] - stops[-2], False, flown[-2], turns)
    return flown


def _free_heading(away: Floats, first: bool, heading: float, turns: Turns) -> float:
    """Return the free heading [rad] of a leg `away` [m], at its start or else its end, the other heading given."""
    dx, dy = away.tolist()
    if not turns.calm:
        return float(wind_path_free(dx, dy, first, heading, turns.radius, *turns.drift)[4])
    if first:
        return free_end(-dx, -dy, heading + math.pi, turns.radius) + math.pi
    return free_end(dx, dy, heading, turns.radius)


def refined_routes(instance: Instance, routes: Routes) -> tuple[Chain | None, ...]:
    """Return the refined headings of each tour and its flown time [s], None for a UAV that stays home.

    Candidates are the instance's own headings, uniform ones and lines of sight, so that no tour takes longer than it
    costs in the instance. InputError where it does not say how its UAVs turn.
    """
    known, points, travel = steady_turns_of(instance), instance.coordinates, instance.travel
    if known is None or points is None or travel is None:
        raise InputError(f"{instance.name} does not say how its UAVs turn (turns, in its provenance)")
    turns, states = known
    free = np.isin(np.arange(instance.n_nodes), states.nodes[states.widths > 0])
    more = headings(points, instance.n_tasks, uniform=_UNIFORM, sights=_SIGHTS, free_depots=False, drift=turns.drift)
    chains: list[Chain | None] = []
    for k, route in enumerate(routes):
        if not route:
            chains.append(None)
            continue
        stops = [instance.n_tasks + k, *route, instance.n_tasks + k]
        given = [None if free[i] else np.concatenate([states.of(i), more.of(i)]) for i in stops]
        closed = travel.closed and given[0] is not None
        chains.append(refine(given, open_legs(points[stops], turns), closed=closed))
    return tuple(chains)
