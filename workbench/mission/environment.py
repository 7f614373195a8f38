"""Stage 1, environment: solve the wind, make or read the field that is measured, keep both with the scenario.

Products: scenario.toml, wind.nc (where the wind is a grid), terrain.nc, field.nc and field.csv, environment.json.
Of a field that changes, field.nc has all frames and field.csv that of take-off.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from msgspec import structs

from formulations.mapping.heights import Frame
from instances.disk import read_toml, write_aside
from instances.environment.propagation import radio_map
from instances.environment.radio import RadioMap, RadioSource
from instances.environment.radio_changing import ChangingField
from instances.environment.radio_files import read_measured, write_field
from instances.environment.terrain import Terrain, read_terrain
from instances.environment.wind_terrain import TerrainWind
from instances.errors import InputError
from instances.extent import FINEST
from instances.scenario import Scenario
from instances.scenario_folder import keep_field, keep_scenario, keep_terrain
from workbench.mission.settings import Mission
from workbench.mission.stamp import referenced_files


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on: the scenario, the field, and every file they name."""
    table = {key: value for key, value in mission.table.items() if key not in LATER}
    files = referenced_files(table, mission.folder)
    if "scenario" in table:  # a file that names files of its own
        scenario = mission.folder / table["scenario"]
        files |= referenced_files(read_toml(scenario), scenario.parent)
    return {
        "table": table,
        "files": files,
        "field": structs.asdict(mission.field),
        "altitude": asdict(mission.altitude),
    }


LATER = ("place", "costs", "routes", "flight", "sensing", "map", "replan", "compare", "export")
"""Tables this stage does not look at."""


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write the environment's products."""
    scenario = mission.scenario
    wind, terrain, ground = scenario.wind, terrain_of(scenario), ground_of(scenario)
    if ground is not None:
        refuse_part_of_region(ground, scenario.region.bounds)
    if isinstance(wind, TerrainWind):
        tell("solving the flow over the terrain")
        wind = wind.grid
    resolved = None if scenario.terrain is None else scenario.terrain.resolve()
    keep_scenario(replace(scenario, wind=wind, terrain=resolved), out)
    if ground is not None:
        keep_terrain(ground, out, scenario.plane)
    field = field_of(mission, terrain)
    keep_field(field, out, scenario.plane)
    frames = field.frames if isinstance(field, ChangingField) else [field]
    write_field(frames[0], out / "field.csv")
    low, high = min(float(f.values.min()) for f in frames), max(float(f.values.max()) for f in frames)
    facts: dict[str, Any] = {"unit": field.unit, "least": low, "most": high, "sd": float(frames[0].values.std())}
    if mission.field.tau is not None:
        facts["tau"] = mission.field.tau
    write_aside(out / "environment.json", json.dumps({"field": facts}, indent=1))
    said = f"field from {low:.1f} to {high:.1f} {field.unit}".rstrip()
    if isinstance(field, ChangingField):
        said += f", in {len(frames)} frames over {field.lasts:g} s, the last one held"
    return "; ".join([said, *differing_heights(mission)])


def terrain_of(scenario: Scenario) -> Terrain | None:
    """Return the ground: the scenario's elevation model, or what its wind blows over; None where neither is given."""
    if scenario.terrain is not None:
        return read_terrain(scenario.terrain, scenario.site)
    return scenario.wind.terrain if isinstance(scenario.wind, TerrainWind) else None


def ground_of(scenario: Scenario) -> Terrain | None:
    """Return the ground that flights are checked against: `terrain_of`, but every node of an elevation model.

    The flow is solved on a coarser grid, which cuts peaks off.
    """
    wind = scenario.wind
    if scenario.terrain is None and isinstance(wind, TerrainWind) and wind.dem is not None:
        return read_terrain(wind.dem, scenario.site)
    return terrain_of(scenario)


def refuse_part_of_region(ground: Terrain, region: tuple[float, float, float, float]) -> None:
    """Raise InputError where the ground is not known all over `region` (bounds [m]), half a cell aside."""
    (x0, y0, x1, y1), (a0, b0, a1, b1) = region, ground.bounds
    dx, dy = 0.5 * ground.spacing[0] + FINEST, 0.5 * ground.spacing[1] + FINEST
    if x0 < a0 - dx or y0 < b0 - dy or x1 > a1 + dx or y1 > b1 + dy:
        raise InputError(
            f"terrain {ground.source} covers ({a0:g}, {b0:g}) to ({a1:g}, {b1:g}) m and not all of the region, "
            f"({x0:g}, {y0:g}) to ({x1:g}, {y1:g}) m: the ground must be known wherever UAVs may fly"
        )


def differing_heights(mission: Mission) -> list[str]:
    """Return a sentence for each product of this stage that holds at another height than the flight's."""
    flown, wind = mission.altitude, mission.scenario.wind
    said = []
    if isinstance(wind, TerrainWind) and (flown.frame, flown.above) != (Frame.AMSL, wind.altitude):
        said.append(
            f"the wind is that at {wind.altitude:g} m above mean sea level, the flight at {flown.above:g} m "
            f"{flown.frame.words}"
        )
    if mission.field.file is None and flown.frame is Frame.ABOVE_GROUND:
        said.append(f"the signal is that at {flown.above:g} m above the ground; tracks rise above it")
    if mission.field.file is None and flown.frame is Frame.ABOVE_HOME and mission.scenario.n_depots > 1:
        said.append("the signal is that above the mean height of the depots, each UAV flies above its own")
    return said


def field_of(mission: Mission, terrain: Terrain | None) -> RadioMap | ChangingField:
    """Return the field that is measured; InputError where a file does not cover the region."""
    wanted, scenario = mission.field, mission.scenario
    if wanted.file is None and wanted.unit is not None:
        raise InputError("field.unit is that of a file's values: give field.file, or leave it out")
    if wanted.file is None:
        return signal_of(mission, terrain)
    field = read_measured(mission.folder / wanted.file, scenario.site, wanted.unit)
    (x0, y0, x1, y1), (a0, b0, a1, b1) = scenario.region.bounds, field.bounds
    # nodes may be cell centres: half a cell may be missing at the border
    nodes = field.frames[0] if isinstance(field, ChangingField) else field
    sx, sy = nodes.x[1] - nodes.x[0], nodes.y[1] - nodes.y[0]
    if x0 < a0 - sx or y0 < b0 - sy or x1 > a1 + sx or y1 > b1 + sy:
        raise InputError(
            f"field.file: {wanted.file} covers ({a0:g}, {b0:g}) to ({a1:g}, {b1:g}) m and not all of the region, "
            f"({x0:g}, {y0:g}) to ({x1:g}, {y1:g}) m: are both in the same projection and unit?"
        )
    return field


def signal_of(mission: Mission, terrain: Terrain | None) -> RadioMap:
    """Return the signal of the mission's transmitter at its altitude."""
    scenario, flown = mission.scenario, mission.altitude
    assert scenario.radio is not None
    source = RadioSource.from_table(scenario.radio)
    more = {key: value for key, value in structs.asdict(mission.field).items() if key not in ("file", "unit", "tau")}
    altitude, above_ground = flown.above, flown.frame is Frame.ABOVE_GROUND
    if flown.frame is Frame.ABOVE_HOME and terrain is not None:
        altitude += float(terrain(scenario.depots).mean())
    bounds = scenario.region.bounds
    return radio_map(source, bounds, terrain, altitude=altitude, above_ground=above_ground, **more)
