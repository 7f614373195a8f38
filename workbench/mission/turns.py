"""Endurance counts what is flown: tours are routed along legs, and their turns have to fit, too.

Legs may cost what the turns of the tours routed before leave of the endurance, until tours fit with their turns. Where
tours are flown more than once, endurance counts the legs of all laps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from formulations.mapping.flight import Flight
from formulations.replanning.spending import track_cost
from instances import Instance, Routes
from instances.arrays import Floats
from instances.environment.wind import Uniform
from instances.environment.wind_changing import ChangingWind
from instances.errors import InputError
from instances.moving_cost import CostMeasure
from instances.paths import Paths
from instances.routes import tour_costs
from instances.scenario import Scenario
from workbench.mission.settings import Mission

ROUNDING = 1e-6
"""Share of an endurance that is kept: costs along tracks are integrals."""


def measure_of(scenario: Scenario) -> CostMeasure:
    """Return what flying costs in `scenario`."""
    return CostMeasure(scenario.cost, scenario.wind or Uniform((0.0, 0.0)), scenario.speed)


@dataclass(frozen=True, eq=False)
class TurnCosts:
    """What turns of a mission's tours cost. limits : endurance of each UAV (m,) [s]."""

    mission: Mission
    scenario: Scenario
    instance: Instance
    paths: Paths
    limits: Floats

    @property
    def counted(self) -> bool:
        """Whether endurance counts turns: there is one, tours are flown once, and in a wind that stays."""
        once = self.mission.flight.laps == 1 and not isinstance(self.scenario.wind, ChangingWind)
        return once and bool(np.isfinite(self.limits).any())

    def left_for_legs(self, routes: Routes, allowed: Floats) -> Floats:
        """Return what legs may cost (m,) [s] of the `allowed` so far: less where `routes` do not fit when flown."""
        from workbench.mission.flight import fly
        from workbench.mission.safety import room_to_fly

        room = room_to_fly(self.mission, self.scenario)
        flights = fly(self.mission, self.scenario, self.instance, self.paths, routes, room).flights
        flown = flown_costs(self.scenario, flights)
        turns = flown - np.array(tour_costs(self.instance, routes))
        most = self.limits * (1.0 - ROUNDING)
        return np.where(flown > most, np.minimum(allowed, np.maximum(most - turns, 0.0)), allowed)


def flown_costs(scenario: Scenario, flights: Sequence[Flight]) -> Floats:
    """Return what each of `flights` costs (m,) [s], turns included."""
    return np.array([track_cost(flight, measure_of(scenario)) for flight in flights])


def refuse_beyond_endurance(scenario: Scenario, flights: Sequence[Flight], limits: Floats) -> None:
    """Raise InputError where one of `flights`, turns included, costs more than its UAV's of `limits` (m,) [s]."""
    for uav, (cost, limit) in enumerate(zip(flown_costs(scenario, flights), limits, strict=True)):
        if cost > limit:
            raise InputError(
                f"UAV {uav} would need {cost:.1f} s, turns included, which is more than its endurance of {limit:.1f} s "
                "(flight.endurance or [[uav]] endurance): give more, or fewer tasks"
            )
