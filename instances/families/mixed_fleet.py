"""The family `mixed-fleet`: the instances of `square-wind`, flown by UAVs of different speeds.

The speeds of the m UAVs are spread evenly from the slowest to the fastest; straight legs i → j of UAV k cost
|Q_j − Q_i|/v_k − W_ij/v_k², W as in ``square_wind.py``. All have the same endurance, if one is given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from instances.errors import InputError
from instances.families.family import Legs
from instances.families.parameter import Parameter
from instances.families.square import uniform_tasks
from instances.families.square_wind import SQUARE_WIND, SquareWind
from instances.fleet import Fleet
from instances.scenario import Scenario

PARAMETERS = (
    Parameter("slowest", 20.0, "m/s", "speed of the first UAV; the wind blows at up to 12 m/s", at_least=12.0),
    Parameter("fastest", 30.0, "m/s", "speed of the last UAV", at_least=12.0),
    Parameter("endurance", 0.0, "s", "the longest tour of each UAV; 0: unlimited", at_least=0.0),
)


class MixedFleet(SquareWind):
    """The family: speeds and endurance beside the points of `square-wind`."""

    def scenario(self, n_tasks: int, n_depots: int, seed: int, given: Mapping[str, Any]) -> Scenario:
        """Return the mission of this size and seed; InputError where the fastest is slower than the slowest."""
        values = self.values(given)
        if values["fastest"] < values["slowest"]:
            raise InputError(
                f"family {self.name}: fastest must be at least slowest = {values['slowest']:g} m/s, "
                f"got {values['fastest']:g}"
            )
        speeds = np.linspace(values["slowest"], values["fastest"], n_depots)
        endurance = np.full(n_depots, values["endurance"]) if values["endurance"] else None
        return replace(super().scenario(n_tasks, n_depots, seed, given), fleet=Fleet(speeds, endurance))


MIXED_FLEET = MixedFleet("mixed-fleet", PARAMETERS, SQUARE_WIND.region, uniform_tasks, Legs.STRAIGHT)
