"""Stage 3, costs: moving costs and reference paths in the wind (sub-problem 2).

Products: instance.json, instance.paths.json.gz.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from msgspec import structs

from formulations.moving_cost.effect import WindEffect
from formulations.moving_cost.registry import METHODS
from instances import Instance
from instances.arrays import Floats
from instances.files import read_instance, write_instance
from instances.paths import Paths, paths_file, read_paths, write_paths
from instances.scenario import Scenario
from instances.scenario_folder import kept_scenario
from workbench.mission.place import kept_tasks, widened
from workbench.mission.plugins import costs_by
from workbench.mission.settings import Mission
from workbench.planning import CONFIRMED, plan, require_confirmed


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    return structs.asdict(mission.costs) | {"clearance": mission.clearance}


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write the instance and the paths behind its costs."""
    scenario = kept_scenario(folders["environment"])
    instance, paths = moving_costs(mission, scenario, kept_tasks(folders["place"]))
    write_instance(instance, out / "instance.json")
    write_paths(paths, instance, paths_file(out / "instance.json"), "../1-environment/scenario.toml")
    n = instance.n_nodes
    effect = WindEffect(**instance.provenance["wind_effect"])
    return f"{n * (n - 1)} paths by {mission.costs.method}, {CONFIRMED}; {effect.summary(scenario.cost)}"


def moving_costs(mission: Mission, scenario: Scenario, tasks: Floats) -> tuple[Instance, Paths]:
    """Return the instance with these tasks and its paths, checked independently."""
    planned = widened(replace(scenario, tasks=tasks, n_tasks=len(tasks)), mission.clearance)
    method, options = mission.costs.method, mission.costs.options
    if method in METHODS.built_in:
        return plan(planned, method, options)
    instance, made = costs_by(planned, method, options)
    require_confirmed(instance, made, planned)
    return instance, made


def kept_costs(folder: Path) -> tuple[Instance, Paths]:
    """Read the instance and the paths this stage wrote."""
    instance = read_instance(folder / "instance.json")
    return instance, read_paths(paths_file(folder / "instance.json"), instance)
