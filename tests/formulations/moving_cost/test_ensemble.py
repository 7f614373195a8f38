"""Costs over an ensemble: legs along the path that is quickest in the forecast planned with, flown in each member."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from formulations.moving_cost.ensemble import member_costs
from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind_changing import Turning
from instances.environment.wind_forecast import Forecast, sampled
from instances.paths import Paths
from instances.wind_ensemble import spread
from instances.wind_flights import polyline_times

NODES = np.array([[1e3, 1e3], [7e3, 1e3], [4e3, 7e3]])
REGION, SPEED = Region.rectangle(8000.0, 8000.0), 20.0


def turning(degrees: float) -> Forecast:
    return sampled(Turning((12.0, 0.0), math.radians(degrees) / 600), REGION, np.arange(0.0, 1801.0, 60.0), 2)


def by_way_of(bend: Floats) -> Paths:
    """Return paths that bend by so much [m] half way."""
    pairs = [(a, b) for a in range(3) for b in range(3)]
    middle = {(a, b): 0.5 * (NODES[a] + NODES[b]) + bend for a, b in pairs}
    return Paths.of(3, [np.array([NODES[a], middle[a, b], NODES[b]]) if a != b else np.empty((0, 2)) for a, b in pairs])


def test_members_fly_the_path_that_is_quickest_as_planned() -> None:
    up, down = by_way_of(np.array([0.0, 300.0])), by_way_of(np.array([0.0, -300.0]))
    paths = replace(up, later=(down,), departures=(600.0,))
    wind = replace(turning(0.0), members=(turning(90.0), turning(-90.0)))
    knots, costs = member_costs(paths, wind, SPEED, 1600.0)
    assert costs.shape == (3, len(knots), 3, 3)
    assert not costs[:, :, range(3), range(3)].any()
    begun = np.full(9, knots[2])
    flown = np.array([[polyline_times(plan.points, plan.offsets, np.arange(9), begun, each, SPEED)
                       for plan in (up, down)] for each in (wind, *wind.members)])  # fmt: skip
    chosen = np.take_along_axis(flown, flown[:1].argmin(axis=1, keepdims=True), axis=1)[:, 0]
    assert costs[:, 2].reshape(3, 9) == pytest.approx(chosen, rel=2e-4)
    assert (chosen > flown.min(axis=1) + 0.01).sum() > 0, "members do not choose for themselves"


def test_tours_by_these_costs_are_nearly_those_of_the_judge() -> None:
    paths = by_way_of(np.zeros(2))
    wind = replace(turning(0.0), members=(turning(30.0), turning(-30.0)))
    knots, costs = member_costs(paths, wind, SPEED, 1600.0)
    judged = spread(paths, ((0, 1),), 2, wind, SPEED)
    assert judged is not None
    for cost, expected in zip(costs, (judged.planned, *judged.members), strict=True):
        time = 0.0
        for i, j in ((2, 0), (0, 1), (1, 2)):
            time += float(np.interp(time, knots, cost[:, i, j]))
        assert time == pytest.approx(expected, rel=3e-3)
