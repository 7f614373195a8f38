"""A mission from files in degrees: its first stage, and the whole of one over real ground."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely.geometry import box, mapping

from instances.environment.site import Site
from instances.environment.terrain import read_terrain
from instances.errors import InputError
from instances.geodesy import TangentPlane
from instances.scenario_folder import kept_field, kept_scenario, kept_terrain
from workbench.mission import environment
from workbench.mission.environment import field_of
from workbench.mission.file import mission_of, read_mission

WEST, SOUTH, EAST, NORTH = 8.0, 47.0, 8.06, 47.04
TABLE: dict[str, Any] = {
    "airspeed": 20.0,
    "region": "area.geojson",
    "depots": [[8.01, 47.01]],
    "tasks": [[8.05, 47.03], [8.03, 47.03]],
    "terrain": "dem.tif",
    "field": {"file": "field.csv"},
    "flight": {"turning_radius": 40.0},
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A region, ground and a field, all in degrees."""
    rasterio = pytest.importorskip("rasterio")
    (tmp_path / "area.geojson").write_text(json.dumps(mapping(box(WEST, SOUTH, EAST, NORTH))))
    step = 0.001
    about = {"driver": "GTiff", "width": 80, "height": 60, "count": 1, "dtype": "int16", "crs": "EPSG:4326"}
    transform = rasterio.Affine(step, 0, 7.99, 0, -step, 47.05)
    with rasterio.open(tmp_path / "dem.tif", "w", transform=transform, **about) as out:
        out.write(np.arange(4800, dtype=np.int16).reshape(60, 80), 1)
    axes = np.arange(7.99, 8.07, 0.002), np.arange(46.99, 47.05, 0.002)
    lines = [f"{x},{y},{x - 8 + y - 47}" for x in axes[0].tolist() for y in axes[1].tolist()]
    (tmp_path / "field.csv").write_text("\n".join(["lon,lat,ppm", *lines]))
    return tmp_path


def test_the_environment_of_a_mission_in_degrees(folder: Path) -> None:
    mission = mission_of(TABLE, folder, "m")
    assert mission.origin == mission.scenario.plane == TangentPlane(47.02, 8.03)
    out = folder / "out"
    out.mkdir()
    environment.make(mission, {}, out, lambda words: None)
    scenario, ground, field = kept_scenario(out), kept_terrain(out), kept_field(out)
    assert scenario.plane == mission.origin
    np.testing.assert_array_equal(scenario.points, mission.scenario.points)
    assert ground is not None
    assert field.unit == "ppm"
    latitude, longitude = mission.origin.geographic(scenario.points).T
    np.testing.assert_allclose(field(scenario.points), longitude - 8 + latitude - 47, atol=1e-4)
    again = read_terrain(out / "terrain.nc", Site(scenario.region, scenario.plane))  # by its grid mapping
    np.testing.assert_allclose(again(scenario.points), ground(scenario.points), atol=0.1)
    for name in ("terrain.nc", "field.nc"):
        xarray = pytest.importorskip("xarray")
        with xarray.open_dataset(out / name) as data:
            assert data["crs"].attrs["latitude_of_projection_origin"] == 47.02
            assert all(v.attrs.get("grid_mapping") == "crs" for k, v in data.data_vars.items() if k != "crs")


def test_units_of_fields(folder: Path) -> None:
    asked = TABLE["field"] | {"unit": "ppb"}
    assert field_of(mission_of(TABLE | {"field": asked}, folder, "m"), None).unit == "ppb"
    without = {key: value for key, value in TABLE.items() if key != "field"}
    radio = mission_of(without | {"radio": {"position": [8.03, 47.02]}, "field": {"unit": "ppm"}}, folder, "m")
    with pytest.raises(InputError, match=r"field\.unit is that of a file's values: give field\.file"):
        field_of(radio, None)


def test_the_origin_of_a_scenario_file_and_of_its_mission(folder: Path) -> None:
    (folder / "s.toml").write_text(
        "airspeed = 20\nsize = [4000, 3000]\ndepots = [[5, 5]]\ntasks = 3\n[radio]\nposition = [1, 1]\n"
    )
    (folder / "m.toml").write_text('scenario = "s.toml"\norigin = [47, 8]\n')
    assert read_mission(folder / "m.toml").origin == TangentPlane(47.0, 8.0)
    (folder / "s.toml").write_text(f"origin = [46, 8]\n{(folder / 's.toml').read_text()}")
    with pytest.raises(InputError, match=r"s\.toml: origin is \[46, 8\] here and \[47, 8\] in the mission"):
        read_mission(folder / "m.toml")


@pytest.mark.slow
def test_a_mission_over_the_jacksboro_fault(tmp_path: Path) -> None:
    """By hand: ``pytest -m slow tests/workbench/mission/test_mission_coordinates.py``; a minute or two."""
    made = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "jacksboro.py"))
    made["run"](made["write_mission"](tmp_path), tmp_path / "out")
    assert {
        name: figure for name, (figure, met) in made["figures"](tmp_path, tmp_path / "out").items() if not met
    } == {}
    assert len(made["opened"](tmp_path / "out")) > 15
