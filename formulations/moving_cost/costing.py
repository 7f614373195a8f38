"""From a Scenario to an Instance: sub-problem 2 of the paper, start to end."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from formulations.moving_cost.effect import wind_effect
from formulations.moving_cost.field import search_field
from formulations.moving_cost.fleet import classes_of, fleet_instance, leg_costs
from formulations.moving_cost.method import MovingCostMethod, MovingCosts, Progress, Query, silent
from formulations.moving_cost.registry import DEFAULT, make_method
from instances import Instance
from instances.arrays import Floats, Ints
from instances.environment.raster import same_projection
from instances.environment.terrain import read_terrain
from instances.environment.wind import Uniform, WindField
from instances.environment.wind_changing import ChangingWind
from instances.errors import InputError
from instances.fleet import Return
from instances.moving_cost import CostKind
from instances.paths import Paths
from instances.scenario import Scenario

CALM = Uniform((0.0, 0.0))


def query_of(scenario: Scenario) -> Query:
    """Return what a moving-cost method needs of `scenario`; InputError where its wind does not cover the region."""
    if scenario.fleet.turning_radii is not None:
        raise InputError(
            f"scenario {scenario.name}: its UAVs have a turning_radius, and legs between headings are no paths of a "
            "method: workbench costs makes them"
        )
    if isinstance(scenario.wind, ChangingWind):
        raise InputError(
            f"scenario {scenario.name}: its wind changes with time, which is for workbench costs, solve and mission; "
            "here paths are planned in a wind that stays"
        )
    return query_in(scenario, CALM if scenario.wind is None else scenario.wind)


def query_in(scenario: Scenario, wind: WindField) -> Query:
    """Return what a moving-cost method needs of `scenario` in a wind that stays; InputError as `query_of`."""
    region = scenario.free
    covered = getattr(wind, "bounds", None)
    if covered is not None:
        (x0, y0, x1, y1), (a0, b0, a1, b1) = region.bounds, covered
        slack = 1e-6 * max(x1 - x0, y1 - y0)
        if x0 < a0 - slack or y0 < b0 - slack or x1 > a1 + slack or y1 > b1 + slack:
            raise InputError(
                f"scenario {scenario.name}: the wind covers ({a0:g}, {b0:g}) to ({a1:g}, {b1:g}) m and not all of the "
                f"region, ({x0:g}, {y0:g}) to ({x1:g}, {y1:g}) m: are both in the same projection and unit?"
            )
    if scenario.plane is None and scenario.terrain is not None and (crs := getattr(wind, "crs", "")):
        same_projection(read_terrain(scenario.terrain).crs, crs, f"scenario {scenario.name}: terrain and wind")
    return Query(scenario.points, region, wind, scenario.speed, scenario.cost)


def solve_query(
    query: Query, method: str = DEFAULT, options: dict[str, Any] | None = None, progress: Progress = silent
) -> MovingCosts:
    """Return costs and paths between all terminals by the method of this name."""
    return all_pairs(query, make_method(method, options), progress)


def all_pairs(query: Query, method: MovingCostMethod, progress: Progress = silent) -> MovingCosts:
    """Return costs and paths between all terminals; terminals may coincide (several UAVs at one depot)."""
    places, of = distinct(query)
    if len(places.terminals) == 1:
        n = len(of)
        alone = Paths(1, np.empty((0, 2)), np.zeros(2, dtype=np.int64))
        return MovingCosts(np.zeros((n, n)), alone.repeated(of, query.terminals), {})
    found = method.solve(places, progress)
    if len(places.terminals) == len(of):
        return found
    return MovingCosts(found.cost[np.ix_(of, of)], found.paths.repeated(of, query.terminals), found.statistics)


def distinct(query: Query) -> tuple[Query, Ints]:
    """Return `query` with each of its terminals once, and which of these each of its terminals is."""
    _, first, of = np.unique(query.terminals, axis=0, return_index=True, return_inverse=True)
    # In order of first appearance, so that without coincidence nothing is renumbered.
    of, first = np.argsort(np.argsort(first))[of.ravel()], np.sort(first)
    return dataclasses.replace(query, terminals=query.terminals[first]), of


def instance_of(
    scenario: Scenario, method: str = DEFAULT, options: dict[str, Any] | None = None, progress: Progress = silent
) -> tuple[Instance, Paths]:
    """Return the Instance `scenario` becomes and the paths behind its costs, planned by the method of this name.

    Raises InputError for tasks still to be placed, a wind that does not cover the region or is as strong as the speed
    that is held constant, and a node that cannot be reached.
    """
    if isinstance(scenario.wind, ChangingWind):
        from formulations.moving_cost.departures import instance_by_clock  # here: it needs this file

        return instance_by_clock(scenario, method, options, progress)
    query, (speeds, _) = query_of(scenario), classes_of(scenario)
    found = []
    for done, speed in enumerate(speeds):

        def share(fraction: float, words: str, done: int = done) -> None:
            progress((done + fraction) / len(speeds), words)

        found.append(solve_query(dataclasses.replace(query, v0=speed), method, options, share))
    return instance_with(scenario, found, method, options)


def instance_with(
    scenario: Scenario, found: Sequence[MovingCosts], method: str, options: dict[str, Any] | None = None
) -> tuple[Instance, Paths]:
    """Return the Instance `scenario` becomes with the moving costs that `method` found, and the paths behind them.

    found : for each speed of `fleet.classes_of`.

    Where a tail wind makes a leg's cost negative, node potentials make all costs positive: cost[i, j] = C(σ) + p_j
    − p_i, which changes no closed tour; p [s] is then kept as ``provenance["node_potential"]``, where UAVs fly at
    several speeds for each of them. InputError where costs are negative and tours need not be closed. Costs that are no
    energies say so in ``provenance["moving_cost"]["cost"]``.
    """
    query, (speeds, _) = query_of(scenario), classes_of(scenario)
    made: dict[str, Any] = {"method": method, **(options or {})}
    if query.kind is not CostKind.ENERGY:
        made["cost"] = str(query.kind)
    provenance: dict[str, Any] = {**scenario.provenance, "moving_cost": made}
    first = dataclasses.replace(query, v0=speeds[0])
    provenance["wind_effect"] = dataclasses.asdict(wind_effect(first, found[0].cost))
    costs, potentials = [], np.zeros((len(speeds), len(query.terminals)))
    for p, speed, of_class in zip(potentials, speeds, found, strict=True):
        cost = leg_costs(scenario, of_class.cost)
        if cost.min() < 0:
            p[:] = _potential(scenario, dataclasses.replace(query, v0=speed))
            cost = cost + p[None, :] - p[:, None]
        np.fill_diagonal(cost, 0.0)
        costs.append(cost)
    if potentials.any():
        provenance["node_potential"] = (potentials if len(speeds) > 1 else potentials[0]).tolist()
    paths = dataclasses.replace(found[0].paths, others=tuple(each.paths for each in found[1:]))
    return fleet_instance(scenario, costs, provenance), paths


def _potential(scenario: Scenario, query: Query) -> Floats:
    """Return node potentials [s], at least 0, that make the costs of closed tours positive."""
    if scenario.fleet.returns is not Return.OWN:
        raise InputError(
            f"scenario {scenario.name}: a tail wind makes the cost of a leg negative, which node potentials make up "
            f"for on closed tours only, not with return = '{scenario.fleet.returns}'"
        )
    p = search_field(query.measure, query.region).potential(query.terminals) / query.v0**2
    least: Floats = p - p.min()
    return least
