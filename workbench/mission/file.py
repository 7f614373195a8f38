"""Mission file: a scenario, what is measured, and the settings of each stage. TOML, SI units, every key checked.

    scenario = "file.toml"       # or the scenario's own keys here: ground_speed, region, depots, tasks, [wind] …
    origin = [lat, lon]          # of the point (0, 0) [degrees], for files in WGS 84; that of a region in degrees
                                 # unless given
    [field] [place] [costs] [routes] [flight] [sensing] [map] [compare] [export]    # the classes of `settings`

Files are relative to the mission file.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from instances.declared.scenario import ScenarioTable
from instances.disk import read_toml
from instances.errors import InputError, naming, shown, suggestion
from instances.scenario import Scenario, read_scenario, scenario_of
from workbench.mission.fitting import check_mission
from workbench.mission.keys import settings_of
from workbench.mission.settings import TABLES, Mission

SCENARIO_KEYS = ScenarioTable.__struct_encode_fields__
KEYS = ("scenario", *SCENARIO_KEYS, *TABLES)
"""Every key of a mission file."""


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
    for key in table:
        if key not in KEYS:
            raise InputError(f"unknown key {shown(key)}{suggestion(key, KEYS)}")
    settings = {key: settings_of(cls, table.get(key, {}), key) for key, cls in TABLES.items()}
    scenario = _scenario(table, folder, name)
    mission = Mission(scenario, scenario.plane, folder, table, **settings)
    check_mission(mission)
    return mission


def _scenario(table: Mapping[str, Any], folder: Path, name: str) -> Scenario:
    own = {key: value for key, value in table.items() if key in SCENARIO_KEYS}
    if "scenario" not in table:
        return scenario_of(own, folder, name)
    placed = {key: own.pop(key) for key in ("origin",) if key in own}
    if own:
        raise InputError(
            f"'{next(iter(own))}' belongs into the scenario file, which 'scenario' names; give one of them"
        )
    if not isinstance(table["scenario"], str):
        raise InputError(f"scenario must be the name of a file, got {shown(table['scenario'])}")
    return read_scenario(folder / table["scenario"], placed)
