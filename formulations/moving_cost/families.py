"""Instances of generator families: the scenarios of `instances.families` with the moving costs their legs have."""

from __future__ import annotations

from typing import Any

from formulations.moving_cost.closed_form import open_country, straight_legs
from formulations.moving_cost.fleet import at_speed, classes_of, fleet_instance, leg_costs
from instances import Instance
from instances.environment.wind_changing import ChangingWind
from instances.families import FAMILIES, Legs, make_scenario
from instances.instance import MAX_NODES, check_size
from instances.metric_costs import MATRIX_NODES
from instances.paths import Paths
from instances.scenario import Scenario


def generate(name: str, n_tasks: int, n_depots: int, seed: int, **parameters: Any) -> Instance:
    """Return the instance of a family of this size and seed; InputError as `make_scenario` and `costed`."""
    return costed(make_scenario(name, n_tasks, n_depots, seed, **parameters), FAMILIES.load(name).legs)[0]


def costed(scenario: Scenario, legs: Legs) -> tuple[Instance, Paths | None]:
    """Return the instance `scenario` becomes with such legs, and the paths behind its costs where they were planned.

    Costs are those of the closed form where it is exact, else of the method refined; in a wind that changes with time
    they are those of `clocked`. InputError for a wind as strong as
    the ground speed and a node that cannot be reached.
    """
    named = legs is Legs.OPEN and not isinstance(scenario.wind, ChangingWind)
    named = named and scenario.fleet.alike and scenario.fleet.endurance is None
    check_size(scenario.n_tasks, scenario.n_depots, MAX_NODES if named else MATRIX_NODES)
    if legs is Legs.TURNS:
        return _between_headings(scenario), None
    if isinstance(scenario.wind, ChangingWind):
        from formulations.moving_cost.clocked import clocked_instance  # here: numba takes its time

        return clocked_instance(scenario), None
    if legs is not Legs.INSIDE:
        formula = open_country if legs is Legs.OPEN else straight_legs
        made = [formula(at_speed(scenario, speed)) for speed in classes_of(scenario)[0]]
        if scenario.fleet.alike and scenario.fleet.endurance is None:
            return made[0], None
        return fleet_instance(scenario, [leg_costs(scenario, each.cost) for each in made], scenario.provenance), None
    from formulations.moving_cost.costing import instance_of  # here: numba takes its time

    return instance_of(scenario)


def _between_headings(scenario: Scenario) -> Instance:
    """Return the instance of a dense survey: its headings are among the family's parameters."""
    from formulations.moving_cost.turns.scenario import HeadingOptions, between_headings  # here: numba takes its time

    said = scenario.provenance["parameters"]
    options = HeadingOptions(said["headings"], said["sights"], depots=said["depot_headings"])
    return between_headings(scenario, options)
