"""Mission file: a scenario, what is measured, and the settings of each stage. TOML, SI units.

Its keys are declared in `settings`; files are relative to the mission file.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from instances.declared.reading import read_declared
from instances.disk import read_toml
from instances.errors import InputError, naming
from instances.scenario import Scenario, read_scenario, scenario_from
from workbench.mission.fitting import check_mission
from workbench.mission.settings import SCENARIO_KEYS, TABLES, Mission, MissionTable


def shipped_missions() -> dict[str, Path]:
    """Return the mission files that come with the workbench, by name.

    paper : the paper's numerical example. lee : one in a wind worth planning for.
    """
    folder = Path(str(files("workbench") / "missions"))
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def read_mission(path: Path | str) -> Mission:
    """Read a mission file; InputError names the file, the key and the value that cannot be used."""
    path = Path(path)
    table = read_toml(path)
    with naming(path):
        return mission_of(table, path.parent, path.stem)


def mission_of(table: Mapping[str, Any], folder: Path, name: str) -> Mission:
    """Return the mission a parsed TOML table describes, its files relative to `folder`; InputError names the key."""
    said = read_declared(MissionTable, table)
    scenario = _scenario(said, table, folder, name)
    settings = {key: getattr(said, key) for key in TABLES}
    mission = Mission(scenario, scenario.plane, folder, table, **settings)
    check_mission(mission)
    return mission


def _scenario(said: MissionTable, table: Mapping[str, Any], folder: Path, name: str) -> Scenario:
    if said.scenario is None:
        return scenario_from(said, table, folder, name)
    own = [key for key in table if key in SCENARIO_KEYS and key != "origin"]
    if own:
        raise InputError(f"'{own[0]}' belongs into the scenario file, which 'scenario' names; give one of them")
    return read_scenario(folder / said.scenario, {"origin": table["origin"]} if "origin" in table else {})
