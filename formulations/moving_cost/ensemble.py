"""Moving costs over an ensemble of forecasts: what legs take in each member along the paths planned in one forecast.

A leg begun at t is flown along the path that is quickest then in the forecast planned with; in member s it takes
c^s_ij(t) [s], linear between knots. Whether a UAV that comes earlier or later in a member than it was planned to would
have been on another of the paths is left to the judge (`instances.wind_ensemble`), who follows each path as flown.
"""

from __future__ import annotations

import numpy as np

from instances.arrays import Floats
from instances.environment.wind_forecast import Forecast
from instances.paths import Paths
from instances.paths_clocked import beside
from instances.wind_flights import polyline_times

KNOTS = 9
"""Knots of departure: for five members of 36 tasks these take 4.6 s, and tours of an hour differ from the judge's by
up to 10 s in a wind that turns by 180° an hour."""
BESIDE = 3
"""Moments whose plans are flown at a knot: the one before it and those after, for a leg lasts."""


def member_costs(paths: Paths, forecast: Forecast, speed: float, until: float) -> tuple[Floats, Floats]:
    """Return knots (Q,) [s] from 0 to `until`, and the costs (1 + M, Q, N, N) [s] of legs begun at them.

    The first costs are those in `forecast` itself, the others those in its members. InputError where a wind is as
    strong as `speed` [m/s].
    """
    n, knots = paths.n_nodes, np.linspace(0.0, until, KNOTS)
    plans, by_knot = (paths, *paths.later), beside(paths, knots, BESIDE).T
    each, winds = np.arange(n * n), (forecast, *forecast.members)
    costs = np.zeros((len(winds), KNOTS, n * n))
    for q, time in enumerate(knots):
        some, begun = [plans[p] for p in np.flatnonzero(by_knot[q])], np.full(n * n, time)
        flown = np.stack([polyline_times(plan.points, plan.offsets, each, begun, forecast, speed) for plan in some])
        quickest = flown.argmin(axis=0)
        costs[0, q] = flown.min(axis=0)
        for p, plan in enumerate(some):
            which = np.flatnonzero(quickest == p)
            for s, member in enumerate(forecast.members, 1):
                costs[s, q, which] = polyline_times(plan.points, plan.offsets, which, begun[which], member, speed)
    return knots, costs.reshape(len(winds), KNOTS, n, n)
