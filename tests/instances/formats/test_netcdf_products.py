"""Gridded products: what is written reads back to the last bit, also by other readers; and a scenario's folder."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pyproj
import pytest

from instances.environment.radio import RadioMap
from instances.environment.region import Region
from instances.environment.terrain import mountains
from instances.environment.wind_grid import Grid
from instances.errors import InputError
from instances.formats.netcdf import Variable, read_grids, write_grids
from instances.geodesy import TangentPlane
from instances.scenario import Scenario
from instances.scenario_folder import (
    keep_field,
    keep_scenario,
    keep_terrain,
    kept_field,
    kept_scenario,
    kept_terrain,
)

RNG = np.random.default_rng(0)
AXES = {"time": np.array([10.0, 20.0]), "y": np.arange(3.0), "x": np.arange(4.0)}
VALUES = RNG.normal(size=(2, 3, 4))


def test_round_trip_is_exact(tmp_path: Path) -> None:
    write_grids(tmp_path / "m.nc", AXES, {"mean": Variable(("time", "y", "x"), VALUES, {"units": "dBm"})})
    axes, variables = read_grids(tmp_path / "m.nc")
    assert set(axes) == set(AXES)
    assert variables["mean"].axes == ("time", "y", "x")
    assert variables["mean"].attributes["units"] == "dBm"
    np.testing.assert_array_equal(variables["mean"].values, VALUES)


def test_other_readers_take_it(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    write_grids(tmp_path / "m.nc", AXES, {"mean": Variable(("time", "y", "x"), VALUES, {"units": "dBm"})})
    with xarray.open_dataset(tmp_path / "m.nc", engine="netcdf4") as data:
        np.testing.assert_array_equal(data["mean"].values, VALUES)
        assert data["x"].attrs["units"] == "m"


def test_a_file_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "m.nc").write_bytes(b"no grid")
    with pytest.raises(InputError, match=r"m\.nc: cannot be read as NetCDF-3"):
        read_grids(tmp_path / "m.nc")


def test_the_environment_folder_reads_back(tmp_path: Path) -> None:
    wind = Grid((0.0, 0.0), (100.0, 200.0), RNG.normal(size=(5, 6)), RNG.normal(size=(5, 6)))
    scenario = Scenario("s", Region.rectangle(500.0, 800.0), [[1.0, 2.0]], 20.0, wind, n_tasks=3)
    keep_scenario(scenario, tmp_path)
    again = kept_scenario(tmp_path)
    assert (again.name, again.n_tasks, again.speed) == ("s", 3, 20.0)
    points = RNG.uniform(0, 800, (20, 2))
    np.testing.assert_allclose(again.wind(points), wind(points), rtol=1e-12)
    assert kept_terrain(tmp_path) is None
    ground = mountains(1000.0, 10)
    keep_terrain(ground, tmp_path)
    np.testing.assert_array_equal(kept_terrain(tmp_path).height, ground.height)
    field = RadioMap(np.arange(3.0), np.arange(4.0), RNG.normal(size=(4, 3)))
    keep_field(field, tmp_path)
    np.testing.assert_array_equal(kept_field(tmp_path).values, field.values)
    assert kept_field(tmp_path).unit == "dBm"


def test_a_grid_mapping_places_the_grid_on_earth(tmp_path: Path) -> None:
    plane, y, x = TangentPlane(47.1, 8.3), np.arange(50.0, 350.0, 100.0), np.arange(50.0, 450.0, 100.0)
    mean = Variable(("y", "x"), VALUES[0], {"units": "dBm"})
    write_grids(tmp_path / "m.nc", {"y": y, "x": x}, {"mean": mean}, plane)
    with netCDF4.Dataset(tmp_path / "m.nc") as data:
        said = {name: data[data["mean"].grid_mapping].getncattr(name) for name in data["crs"].ncattrs()}
    assert (said["latitude_of_projection_origin"], said["longitude_of_projection_origin"]) == (47.1, 8.3)
    by_name = pyproj.CRS.from_cf({key: value for key, value in said.items() if key != "crs_wkt"})
    for crs in (by_name, pyproj.CRS.from_wkt(said["crs_wkt"])):
        place = pyproj.Transformer.from_crs(crs, "EPSG:4326").transform(300.0, 200.0)
        np.testing.assert_allclose(place, plane.geographic([[300.0, 200.0]])[0], atol=1e-9)
    _, variables = read_grids(tmp_path / "m.nc")
    assert set(variables) == {"mean"}
