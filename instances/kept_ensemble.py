"""An ensemble kept beside a stored instance: what routes take over its members can be computed again without the files
it was read from.

    instance.paths.json.gz                  the paths between nodes (`instances.paths`)
    scenario.toml, wind.nc, wind-1.nc, …    the scenario and the members (`instances.scenario_folder`)

They are written in the order from below, so that paths say that all is there.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from instances.errors import InputError
from instances.instance import Instance
from instances.paths import Paths, paths_file, paths_of, read_paths_table, write_paths
from instances.scenario import Scenario
from instances.scenario_folder import keep_scenario, kept_scenario
from instances.wind_ensemble import Ensemble

SCENARIO = "scenario.toml"
"""What `keep_scenario` writes."""


def has_nodes_of(scenario: Scenario, instance: Instance) -> bool:
    """Say whether tasks and depots of a scenario lie where those of `instance` do."""
    at = instance.coordinates
    return at is not None and scenario.points.shape == at.shape and np.allclose(scenario.points, at, atol=0.01)


def keep_ensemble(paths: Paths, scenario: Scenario, instance: Instance, folder: Path) -> None:
    """Write what `kept_ensemble` reads; ground and radio source are left out."""
    keep_scenario(replace(scenario, terrain=None, radio=None), folder)
    write_paths(paths, instance, paths_file(folder / "instance.json"), SCENARIO)


def kept_ensemble(folder: Path, instance: Instance) -> Ensemble | None:
    """Return the ensemble kept beside `instance`, None where there is none; InputError names what cannot be read."""
    file = paths_file(folder / "instance.json")
    if not file.exists():
        return None
    table = read_paths_table(file)
    if table.get("scenario") != SCENARIO:
        return None
    paths, scenario = paths_of(table, instance, file), kept_scenario(folder)
    if not has_nodes_of(scenario, instance):
        raise InputError(f"{folder / SCENARIO}: has other nodes than {instance.name}")
    return Ensemble.of(paths, scenario)
