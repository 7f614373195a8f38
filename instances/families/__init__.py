"""Generator families: random instances with moving costs in closed form, and missions in wind that need planning.

The same seed gives the same file.
"""

from __future__ import annotations

from typing import Any

from instances.errors import InputError, suggestion
from instances.families.corridor import CORRIDOR
from instances.families.family import Family
from instances.families.parameter import Parameter
from instances.families.square import CLUSTERED, RING, UNIFORM
from instances.families.square_wind import SQUARE_WIND
from instances.families.wind_missions import WIND_MOUNTAINS, WIND_UNIFORM, WIND_VORTICES
from instances.instance import Instance, check_size
from instances.scenario import Scenario

__all__ = ["FAMILIES", "MISSIONS", "Family", "Parameter", "family", "generate", "make_scenario"]

FAMILIES: dict[str, Family] = {f.name: f for f in (UNIFORM, CLUSTERED, RING, CORRIDOR, SQUARE_WIND)}
"""Name → family; its `description` and `parameters` (name, default, unit, meaning, choices) are there to be listed."""

MISSIONS: dict[str, Family] = {f.name: f for f in (WIND_UNIFORM, WIND_VORTICES, WIND_MOUNTAINS)}
"""Families that make a Scenario only: its moving costs are planned by ``formulations.moving_cost``."""


def family(name: str) -> Family:
    """Return the family of this name; InputError with the near miss."""
    known = FAMILIES | MISSIONS
    if name not in known:
        raise InputError(f"unknown family '{name}'{suggestion(name, known)} (known: {', '.join(known)})")
    return known[name]


def make_scenario(name: str, n_tasks: int, n_depots: int, seed: int, **parameters: Any) -> Scenario:
    """Return the mission a family makes of this size and seed; InputError says what it does not take."""
    for label, value, least in (("n_tasks", n_tasks, 1), ("n_depots", n_depots, 1), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise InputError(f"{label} must be a whole number of at least {least}, got {value!r}")
    check_size(n_tasks, n_depots)
    return family(name).scenario(n_tasks, n_depots, seed, parameters)


def generate(name: str, n_tasks: int, n_depots: int, seed: int, **parameters: Any) -> Instance:
    """Return the instance of a family of this size and seed, with moving costs in closed form [s].

    `parameters` are values of the family's parameters, as numbers or as text; those left out have their defaults.

    Raises
    ------
    InputError
        for an unknown family or parameter (with the near miss), for a value that cannot be used, and for a family
        whose moving costs have no closed form.
    """
    scenario = make_scenario(name, n_tasks, n_depots, seed, **parameters)
    return family(name).instance(scenario)
