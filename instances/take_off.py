"""When a UAV takes off that may wait: as early as its endurance lets it, within the window of its instance's `Travel`.

With A(t) the landing of a tour begun at t, 0 ≤ t ≤ window, it is to land within endurance L and as early as it can:

    least A(t)   such that   A(t) − t ≤ L

Who departs later never lands earlier (`Travel` checks it), so that is the least t within endurance: waiting never
shortens a makespan, which counts landings, but it may shorten a flight. Legs are linear in t between knots, so A is a
chain of lines that bends only where some leg begins at a knot: every line is walked along, from t = 0, and the root of
A(t) − t = L on it taken in closed form. A tour of p legs has at most p · Q lines for the Q knots.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from instances.arrays import Ints
from instances.travel import Travel

_STEP = 1e-12
"""Least share of a take-off [s] that the walk goes on by: a line shorter than rounding cannot hold it up."""


class Line(NamedTuple):
    """One line of A: begun at `begins` [s] a tour lands at `landing` [s], and `rate` later per second until `until`."""

    begins: float
    landing: float
    rate: float
    until: float


def take_off(travel: Travel, uav: int, stops: Ints, endurance: float) -> float:
    """Return the earliest take-off [s] of UAV `uav` within `endurance` [s]; where none is, that of its least flight.

    Parameters
    ----------
    travel
        What legs cost, of one state a node.
    uav
        Number of the UAV, from 0.
    stops
        Depot, tasks in flying order, depot.
    endurance
        Longest flight [s].

    Returns
    -------
    float
        Between 0 and ``travel.window``; 0 where the tour cannot be flown.
    """
    shortest, best = np.inf, 0.0
    for line in lines(travel, uav, stops):
        flight = line.landing - line.begins
        if flight <= endurance:
            return line.begins
        if line.rate < 1 and (root := line.begins + (flight - endurance) / (1 - line.rate)) <= line.until:
            return root
        for time in (line.begins, line.until):  # a line is shortest at one of its ends
            shortest, best = min((shortest, best), (flight + (line.rate - 1) * (time - line.begins), time))
    return best


def lines(travel: Travel, uav: int, stops: Ints) -> Iterator[Line]:
    """Yield the lines of A over the window, the earliest first, as long as the tour can be flown."""
    knots, begins = travel.departures, 0.0
    legs = travel.cost[travel.classes[uav]][:, stops[:-1], stops[1:]]
    slopes = np.zeros_like(legs)
    with np.errstate(invalid="ignore"):
        slopes[:-1] = np.diff(legs, axis=0) / np.diff(knots)[:, None]
    while True:
        time, rate, until = begins, 1.0, travel.window
        for leg in range(len(stops) - 1):
            q = int(np.searchsorted(knots, time, side="right")) - 1
            since = time - float(knots[q])
            if q + 1 < len(knots) and rate > 0:
                until = min(until, begins + (float(knots[q + 1]) - time) / rate)
            time += float(legs[q, leg]) + (float(slopes[q, leg]) * since if since > 0 else 0.0)
            if not np.isfinite(time):
                return
            rate = max(0.0, rate * (1 + float(slopes[q, leg])))
        yield Line(begins, time, rate, until)
        if until >= travel.window:
            return
        begins = max(until, begins + _STEP * (1 + begins))
