"""A mission's environment as a folder: scenario.toml with its gridded wind, the ground and the field, as NetCDF-3.

Unlike a scenario file of its own, it can be written and read without the extra ``geo``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from instances.arrays import Floats
from instances.disk import read_toml, write_aside
from instances.environment.radio import RadioMap
from instances.environment.radio_changing import ChangingField
from instances.environment.raster import SINCE, node_axes
from instances.environment.terrain import Terrain
from instances.environment.value_map import ValueMap
from instances.environment.wind_forecast import Forecast
from instances.environment.wind_grid import Grid
from instances.errors import InputError, naming, shown
from instances.formats.netcdf import Variable, read_grids, write_grids
from instances.geodesy import TangentPlane
from instances.scenario import Scenario, scenario_of, write_scenario
from instances.toml_text import toml_text


def keep_scenario(scenario: Scenario, folder: Path) -> None:
    """Write ``scenario.toml`` into `folder`; beside it a gridded wind as ``wind.nc``, polygons as ``.json``."""
    path = folder / "scenario.toml"
    grid = scenario.wind if isinstance(scenario.wind, Grid | Forecast) else None
    write_scenario(scenario if grid is None else replace(scenario, wind=None), path)
    table = read_toml(path)
    for key in ("region", "no_fly"):  # in metres, which are no GeoJSON to those who read the folder
        if key in table:
            given = folder / table[key]
            table[key] = given.rename(given.with_suffix(".json")).name
    if grid is not None:
        table["wind"] = {"kind": "grid", "file": "wind.nc"}
        if isinstance(grid, Forecast) and grid.take_off:
            table["wind"]["take_off"] = grid.take_off
        _keep_wind(grid, folder / "wind.nc", scenario.plane)
        members = grid.members if isinstance(grid, Forecast) else ()
        for number, member in enumerate(members, 1):
            name = f"wind-{number}.nc"
            _keep_wind(member, folder / name, scenario.plane)
            table["wind"].setdefault("members", []).append(name)
    write_aside(path, toml_text(table))


def _keep_wind(wind: Grid | Forecast, path: Path, plane: TangentPlane | None) -> None:
    """Write a gridded wind over y and x or, of a forecast, over its times since take-off, y and x."""
    x, y = node_axes(wind.origin, wind.spacing, wind.u.shape[-2:])
    over: tuple[str, ...] = ("y", "x")
    axes = {"x": x, "y": y}
    if isinstance(wind, Forecast):
        over, axes["time"] = ("time", *over), wind.times - wind.take_off
    components = {
        name: Variable(over, values, {"units": "m s-1", "standard_name": standard})
        for name, values, standard in (("u", wind.u, "x_wind"), ("v", wind.v, "y_wind"))
    }
    write_grids(path, axes, components, plane, SINCE)


def _kept_wind(path: Path) -> Grid | Forecast:
    """Read what `_keep_wind` wrote."""
    over: tuple[str, ...] = ("y", "x")
    if "time" in read_grids(path)[0]:
        over = ("time", *over)
    axes, values = read_grids(path, {"u": over, "v": over})
    with naming(path):
        u, v = values["u"].values, values["v"].values
        if len(over) == 2:
            return Grid(*_origin_spacing(axes), u, v, path.name)
        first = float(axes["time"][0])
        return Forecast(axes["time"] - first, *_origin_spacing(axes), u, v, path.name, take_off=-first)


def kept_scenario(folder: Path) -> Scenario:
    """Read what `keep_scenario` wrote."""
    path = folder / "scenario.toml"
    table = read_toml(path)
    wind = table.get("wind")
    gridded = isinstance(wind, dict) and wind.get("kind") == "grid"
    with naming(path):
        scenario = scenario_of({k: v for k, v in table.items() if k != "wind" or not gridded}, folder, path.stem)
    if not gridded:
        return scenario
    made = _kept_wind(folder / "wind.nc")
    if isinstance(made, Forecast) and isinstance(wind, dict):
        names = wind.get("members", [])
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise InputError(f"{path}: wind.members must be names of files, got {shown(names)}")
        others = (_kept_wind(folder / name) for name in names)
        made = replace(made, members=tuple(other for other in others if isinstance(other, Forecast)))
    return replace(scenario, wind=made)


def keep_terrain(terrain: Terrain, folder: Path, plane: TangentPlane | None = None) -> None:
    """Write ``terrain.nc`` into `folder`. plane : where on Earth it is, if known."""
    x, y = node_axes(terrain.origin, terrain.spacing, terrain.height.shape)
    height = Variable(("y", "x"), terrain.height, {"units": "m", "standard_name": "surface_altitude"})
    write_grids(folder / "terrain.nc", {"x": x, "y": y}, {"height": height}, plane)


def kept_terrain(folder: Path) -> Terrain | None:
    """Read what `keep_terrain` wrote; None where there is no terrain."""
    if not (folder / "terrain.nc").exists():
        return None
    axes, values = read_grids(folder / "terrain.nc", {"height": ("y", "x")})
    with naming(folder / "terrain.nc"):
        return Terrain(*_origin_spacing(axes), values["height"].values, "terrain.nc")


def keep_field(field: RadioMap | ChangingField, folder: Path, plane: TangentPlane | None = None) -> None:
    """Write ``field.nc`` into `folder`, of a field that changes over time, too. plane : where on Earth, if known."""
    first = field if isinstance(field, RadioMap) else field.frames[0]
    over: tuple[str, ...] = ("y", "x")
    axes, values = {"x": first.x, "y": first.y}, first.values
    if isinstance(field, ChangingField):
        over, axes["time"] = ("time", *over), np.asarray(field.times)
        values = np.stack([frame.values for frame in field.frames])
    about = {"long_name": "field", "units": field.unit or "1"}
    write_grids(folder / "field.nc", axes, {"field": Variable(over, values, about)}, plane, SINCE)


def kept_field(folder: Path) -> RadioMap | ChangingField:
    """Read what `keep_field` wrote."""
    path = folder / "field.nc"
    over: tuple[str, ...] = ("y", "x")
    if "time" in read_grids(path)[0]:
        over = ("time", *over)
    axes, found = read_grids(path, {"field": over})
    with naming(path):
        values, unit = found["field"].values, found["field"].attributes.get("units", "1")
        if len(over) == 2:
            return RadioMap(axes["x"], axes["y"], values, unit)
        return ChangingField(axes["time"], [RadioMap(axes["x"], axes["y"], frame, unit) for frame in values])


def keep_value_map(given: ValueMap, name: str, folder: Path, plane: TangentPlane | None = None) -> None:
    """Write ``<name>.nc`` into `folder`. plane : where on Earth it is, if known."""
    values = Variable(("y", "x"), given.values, {"units": given.unit or "1"})
    write_grids(folder / f"{name}.nc", {"x": given.x, "y": given.y}, {"value": values}, plane)


def kept_value_map(name: str, folder: Path) -> ValueMap | None:
    """Read what `keep_value_map` wrote; None where there is none."""
    path = folder / f"{name}.nc"
    if not path.exists():
        return None
    axes, values = read_grids(path, {"value": ("y", "x")})
    with naming(path):
        return ValueMap(axes["x"], axes["y"], values["value"].values)


def _origin_spacing(axes: Mapping[str, Floats]) -> tuple[tuple[float, float], tuple[float, float]]:
    x, y = axes["x"], axes["y"]
    if min(len(x), len(y)) < 2:
        raise InputError(f"must hold a grid of at least 2 × 2 nodes, got {len(x)} × {len(y)}")
    return (float(x[0]), float(y[0])), (float(x[1] - x[0]), float(y[1] - y[0]))
