"""The calm twin: what its tours cost in the wind, where that is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from instances import Instance
from instances.environment.wind import Rotation, Uniform, WindField
from instances.moving_cost import CostKind, CostMeasure
from instances.paths import Paths
from workbench.mission.calm import judged, tour_costs

V0 = 20.0
NODES = np.array([[1e3, 0.0], [1e3, 1e3], [0.0, 1e3], [5e3, 5e3], [0.0, 0.0], [5e3, 4e3]])
"""Four tasks, two depots: a square of 1 km with its depot in a corner, and a leg of 1 km."""
STRAIGHT = Paths.of(6, [NODES[[a, b]] if a != b else np.empty((0, 2)) for a in range(6) for b in range(6)])
INSTANCE = Instance("square", np.zeros((6, 6)), 4, 2, NODES)
ROUND, BACK = ((0, 1, 2), (3,)), ((2, 1, 0), (3,))


def longest(wind: WindField) -> dict[str, float]:
    """Judge a mission that flies anticlockwise beside a twin that came out clockwise."""
    table = judged(CostMeasure(CostKind.ENERGY, wind, V0), (INSTANCE, STRAIGHT, ROUND), (STRAIGHT, BACK))
    return dict(zip(table["plan"], table["longest"], strict=True))


def test_a_potential_wind_is_worth_nothing() -> None:
    assert list(longest(Uniform((5.0, -3.0))).values()) == pytest.approx([4e3 / V0] * 5)


def test_with_a_rotating_wind_is_cheaper_than_against_it() -> None:
    circulation = 2 * 1e-3 * 1e6  # 2 Ω times the area of the square
    cheap, dear = (4e3 / V0 - sign * circulation / V0**2 for sign in (1, -1))
    found = longest(Rotation(1e-3, (500.0, 500.0)))
    expected = {"wind": cheap, "paths": dear, "calm": dear, "better": cheap, "worse": dear}
    assert found == {plan: pytest.approx(cost) for plan, cost in expected.items()}


def test_a_uav_that_stays_home_costs_nothing() -> None:
    measure = CostMeasure(CostKind.ENERGY, Uniform((1.0, 0.0)), V0)
    assert tour_costs(measure, [NODES[[0, 4, 0]], np.empty((0, 2))])[1] == 0.0
