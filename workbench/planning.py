"""Plan the moving costs of a scenario, have them confirmed, write them; and confirm written ones."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from formulations.moving_cost.costing import instance_of, query_of
from formulations.moving_cost.fleet import classes_of, leg_costs
from formulations.moving_cost.registry import DEFAULT
from instances import Instance
from instances.environment.wind_changing import ChangingWind
from instances.errors import InputError, shown
from instances.files import read_instance, write_instance
from instances.moving_cost import CostKind
from instances.paths import ENDING, Paths, check_paths, paths_file, paths_of, read_paths_table, write_paths
from instances.paths_clocked import check_clocked
from instances.scenario import Scenario, read_scenario

CONFIRMED = "all confirmed (that they can be flown at this cost, not that none is cheaper)"
"""What the independent check says of paths."""


def plan(
    scenario: Scenario,
    method: str = DEFAULT,
    options: dict[str, Any] | None = None,
    progress: Callable[[float, str], None] = lambda fraction, words: None,
) -> tuple[Instance, Paths]:
    """Return the instance `scenario` becomes and its paths, re-evaluated independently; RuntimeError where refuted."""
    instance, paths = instance_of(scenario, method, options, progress)
    require_confirmed(instance, paths, scenario)
    return instance, paths


def require_confirmed(instance: Instance, paths: Paths, scenario: Scenario) -> None:
    """Raise RuntimeError where the moving costs of `instance` or the paths behind them are refuted."""
    if faults := refute(instance, paths, scenario):
        raise RuntimeError("the independent check refutes the moving costs: " + " ".join(faults))


def refute(instance: Instance, paths: Paths, scenario: Scenario) -> list[str]:
    """Return what is wrong with the moving costs of `instance` and the paths behind them, a sentence each."""
    made = instance.provenance.get("moving_cost")
    stated = made.get("cost", CostKind.ENERGY) if isinstance(made, dict) else scenario.cost
    if stated != scenario.cost:
        return [f"The instance's costs are {shown(stated)}, those of the scenario {str(scenario.cost)!r}."]
    shift = instance.provenance.get("node_potential")
    potential = None if shift is None else np.array(shift, dtype=float)
    speeds, classes = classes_of(scenario)
    if len(paths.others) != len(speeds) - 1:
        return [f"There are paths for {len(paths.others) + 1} speeds of UAVs, and {len(speeds)} speeds."]
    if isinstance(scenario.wind, ChangingWind):
        return _refute_clocked(instance, paths, scenario, scenario.wind)
    query, faults = query_of(scenario), list[str]()
    for g, speed in enumerate(speeds):
        faults += check_paths(
            paths.of_class(g),
            instance.uav_cost(classes.tolist().index(g)),
            query.terminals,
            query.region,
            query.wind,
            speed,
            potential if potential is None or len(speeds) == 1 else potential[g],
            query.kind,
            None if scenario.fleet.alike else partial(leg_costs, scenario),
        )
    return faults


def _refute_clocked(instance: Instance, paths: Paths, scenario: Scenario, wind: ChangingWind) -> list[str]:
    """Return what is wrong with moving costs by departure and the paths behind them."""
    if instance.travel is None or "time" not in instance.travel.axes:
        return ["The wind changes with time and the instance's costs do not."]
    service = np.zeros(instance.n_nodes)
    service[: instance.n_tasks] = scenario.fleet.service
    region, faults = scenario.free, list[str]()
    for g, speed in enumerate(classes_of(scenario)[0]):
        flown = paths.of_class(g), instance.travel, g, scenario.points, region, wind, speed, service
        faults += check_clocked(*flown, partial(leg_costs, scenario))
    return faults


def write_plan(instance: Instance, paths: Paths, out: Path, scenario_file: Path) -> None:
    """Write the instance to `out` and its paths beside it."""
    write_instance(instance, out)
    write_paths(paths, instance, paths_file(out), os.path.relpath(scenario_file, out.parent))


def check_plan(target: Path, scenario_file: Path | None) -> tuple[str, list[str]]:
    """Check a file of paths against the instance beside it and the scenario it names; what was seen, and problems."""
    table = read_paths_table(target)
    stem = target.name.removesuffix(ENDING)
    beside = [target.with_name(stem + ending) for ending in (".json", ".json.gz", ".atsp")]
    found = [path for path in beside if path.exists()]
    if not found:
        raise InputError(f"{target}: there is no instance {beside[0].name} beside it")
    instance = read_instance(found[0])
    paths = paths_of(table, instance, target)
    kept = table.get("scenario")
    if scenario_file is None and not isinstance(kept, str):
        raise InputError(f"{target}: scenario must be the name of a file, got {shown(kept)}")
    scenario = read_scenario(scenario_file or target.parent / str(kept))
    count = paths.n_nodes * (paths.n_nodes - 1) * (1 + len(paths.others))
    return f"{count} paths of {instance.name}", [f"{target}: {fault}" for fault in refute(instance, paths, scenario)]
