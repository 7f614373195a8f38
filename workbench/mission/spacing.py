"""The spacing ratio of a mission: how many turning radii its tasks lie apart, and what that advises."""

from __future__ import annotations

from typing import Any

from formulations.moving_cost.turns.spacing import advice, spacing_ratio
from instances.scenario import Scenario
from workbench.mission.settings import Mission

SPACING_FILE = "spacing.json"


def spacing_of(mission: Mission, scenario: Scenario, n_tasks: int) -> dict[str, Any]:
    """Return ratio ρ, turning radius [m], advice in words, and whether the mission couples, as JSON values."""
    radius = mission.flight.turning_radius
    ratio = spacing_ratio(scenario.free.area, n_tasks, radius)
    return {"ratio": ratio, "radius": radius, "advice": advice(ratio), "coupled": mission.flight.coupled}
