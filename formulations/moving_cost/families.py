"""Instances of generator families: the scenarios of `instances.families` with the moving costs their legs have."""

from __future__ import annotations

from typing import Any

from formulations.moving_cost.closed_form import open_country, straight_legs
from instances import Instance
from instances.families import FAMILIES, Legs, make_scenario
from instances.paths import Paths
from instances.scenario import Scenario


def generate(name: str, n_tasks: int, n_depots: int, seed: int, **parameters: Any) -> Instance:
    """Return the instance of a family of this size and seed; InputError as `make_scenario` and `costed`."""
    return costed(make_scenario(name, n_tasks, n_depots, seed, **parameters), FAMILIES.load(name).legs)[0]


def costed(scenario: Scenario, legs: Legs) -> tuple[Instance, Paths | None]:
    """Return the instance `scenario` becomes with such legs, and the paths behind its costs where they were planned.

    Costs are those of the closed form where it is exact, else of the method refined. InputError for a wind as strong as
    the ground speed and a node that cannot be reached.
    """
    if legs is Legs.OPEN:
        return open_country(scenario), None
    if legs is Legs.STRAIGHT:
        return straight_legs(scenario), None
    from formulations.moving_cost.costing import instance_of  # here: numba takes its time

    return instance_of(scenario)
