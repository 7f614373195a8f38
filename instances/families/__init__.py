"""Generator families: random Scenarios, the same for the same seed.

`formulations.moving_cost.families.generate` turns them into Instances.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from instances.errors import InputError, suggestion
from instances.families.corridor import CORRIDOR
from instances.families.family import Family, Legs
from instances.families.parameter import Parameter
from instances.families.square import CLUSTERED, RING, UNIFORM
from instances.families.square_wind import SQUARE_WIND
from instances.families.wind_missions import WIND_MOUNTAINS, WIND_UNIFORM, WIND_VORTICES
from instances.instance import check_size
from instances.scenario import Scenario

__all__ = ["FAMILIES", "Family", "Legs", "Parameter", "check_family", "family", "make_scenario"]

FAMILIES: dict[str, Family] = {
    f.name: f for f in (UNIFORM, CLUSTERED, RING, CORRIDOR, SQUARE_WIND, WIND_UNIFORM, WIND_VORTICES, WIND_MOUNTAINS)
}
"""Name → family; its `description` and `parameters` (name, default, unit, meaning, choices) are there to be listed."""


def family(name: str) -> Family:
    """Return the family of this name; InputError with the near miss."""
    if name not in FAMILIES:
        raise InputError(f"unknown family '{name}'{suggestion(name, FAMILIES)} (known: {', '.join(FAMILIES)})")
    return FAMILIES[name]


def check_family(name: str, parameters: Mapping[str, Any]) -> None:
    """Raise InputError for an unknown family, parameter or value, without making anything."""
    family(name).values(parameters)


def make_scenario(name: str, n_tasks: int, n_depots: int, seed: int, **parameters: Any) -> Scenario:
    """Return the mission a family makes of this size and seed.

    `parameters` are values of the family's parameters, as numbers or as text; those left out have their defaults.
    InputError for an unknown family or parameter (with the near miss) and for a value that cannot be used.
    """
    for label, value, least in (("n_tasks", n_tasks, 1), ("n_depots", n_depots, 1), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise InputError(f"{label} must be a whole number of at least {least}, got {value!r}")
    check_size(n_tasks, n_depots)
    return family(name).scenario(n_tasks, n_depots, seed, parameters)
