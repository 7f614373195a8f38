"""Generator families: random Scenarios, the same for the same seed.

`formulations.moving_cost.families.generate` turns them into Instances.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from instances.errors import InputError, shown
from instances.families.family import Family, Legs
from instances.families.parameter import Parameter
from instances.instance import MAX_NODES, check_size
from instances.registry import PLAIN, Registry, is_plain
from instances.scenario import Scenario

__all__ = ["FAMILIES", "Family", "Legs", "Parameter", "check_family", "make_scenario"]

BUILT_IN = {
    "uniform": ("instances.families.square:UNIFORM", "tasks uniform in a square"),
    "clustered": ("instances.families.square:CLUSTERED", "tasks in normal clusters around random centres in a square"),
    "ring": ("instances.families.square:RING", "tasks on a ring about the centre of a square"),
    "corridor": (
        "instances.families.corridor:CORRIDOR",
        "tasks uniform in a winding corridor, a square crossed by walls that legs must fly around",
    ),
    "square-wind": (
        "instances.families.square_wind:SQUARE_WIND",
        "uniform in a 20 km square, straight legs in one wind with rotation: instances with published optima",
    ),
    "mixed-fleet": (
        "instances.families.mixed_fleet:MIXED_FLEET",
        "square-wind with UAVs of different speeds, if asked for with limited endurance",
    ),
    "dense-survey": (
        "instances.families.dense_survey:DENSE_SURVEY",
        "tasks a few turning radii apart in a square, Dubins paths between headings, in calm air or a steady wind",
    ),
    "wind-uniform": (
        "instances.families.wind_missions:WIND_UNIFORM",
        "a steady wind with turbulence (stream function), no-fly zones; "
        "turbulence=0 leaves a wind that changes no tour",
    ),
    "wind-vortices": (
        "instances.families.wind_missions:WIND_VORTICES",
        "a steady wind from the north-east with vortices, no-fly zones",
    ),
    "wind-mountains": (
        "instances.families.wind_missions:WIND_MOUNTAINS",
        "mass-consistent flow over synthetic mountains at an altitude, with turbulence in their lee, no-fly zones",
    ),
    "wind-turning": (
        "instances.families.wind_changing:WIND_TURNING",
        "flight times in a wind that turns with time, the same everywhere: instances with published optima",
    ),
    "wind-valley": (
        "instances.families.wind_changing:WIND_VALLEY",
        "flight times in a wind that blows up a valley and down again in turn",
    ),
    "wind-front": ("instances.families.wind_changing:WIND_FRONT", "flight times while a front passes"),
    "wind-drifting": (
        "instances.families.wind_changing:WIND_DRIFTING",
        "flight times among vortices that drift with a mean wind",
    ),
}

FAMILIES: Registry[Family] = Registry(
    "family",
    BUILT_IN,
    group="mmmdmtsp_workbench.families",
    listing="workbench families",
    having=("values", "scenario", "legs"),
)
"""Name → family; its `parameters` (name, default, unit, meaning, choices) are there to be listed."""


def check_family(name: str, parameters: Mapping[str, Any]) -> None:
    """Raise InputError for an unknown family, parameter or value, without making anything.

    A family that is not built in is not imported: whoever makes its scenarios says what is wrong with its parameters.
    """
    FAMILIES.target(name)
    if name in FAMILIES.built_in:
        FAMILIES.load(name).values(parameters)
        return
    for key, value in parameters.items():
        if not is_plain(value):
            raise InputError(f"family {name}: {shown(key)} must be {PLAIN}, got {shown(value)}")


def make_scenario(name: str, n_tasks: int, n_depots: int, seed: int, **parameters: Any) -> Scenario:
    """Return the mission a family makes of this size and seed.

    `parameters` are values of the family's parameters, as numbers or as text; those left out have their defaults.
    InputError for an unknown family or parameter (with the near miss) and for a value that cannot be used.
    """
    for label, value, least in (("n_tasks", n_tasks, 1), ("n_depots", n_depots, 1), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise InputError(f"{label} must be a whole number of at least {least}, got {shown(value)}")
    check_size(n_tasks, n_depots, MAX_NODES)
    return FAMILIES.load(name).scenario(n_tasks, n_depots, seed, parameters)
