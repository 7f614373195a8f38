"""Wind grids in files: NetCDF round trip, WindNinja's conventions, bad files named."""

from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.environment.wind_files import read_wind
from instances.environment.wind_grid import Grid
from instances.environment.wind_table import wind_from_toml

HEADER = "ncols 3\nnrows 2\nxllcorner -50\nyllcorner 950\ncellsize 100\nNODATA_value -9999\n"


@pytest.fixture
def grid() -> Grid:
    u, v = np.random.default_rng(5).normal(size=(2, 4, 3))
    return Grid((100.0, -200.0), (50.0, 25.0), u, v)


def test_netcdf_round_trip(tmp_path: Path, grid: Grid) -> None:
    pytest.importorskip("xarray")
    table = grid.to_toml(tmp_path)
    again = wind_from_toml(table, tmp_path)
    assert isinstance(again, Grid)
    np.testing.assert_array_equal(again.u, grid.u)
    np.testing.assert_array_equal(again.v, grid.v)
    assert (again.origin, again.spacing) == (grid.origin, grid.spacing)


def test_a_grid_whose_rows_go_south_is_turned(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    u = np.arange(6.0).reshape(2, 3)
    data = xarray.Dataset(
        {
            "u10": (("time", "y", "x"), u[None], {"units": "m s**-1"}),
            "v10": (("time", "y", "x"), u[None], {"units": "m s**-1"}),
        },
        coords={"x": [0.0, 1.0, 2.0], "y": [1.0, 0.0], "time": [0]},
    )
    data.to_netcdf(tmp_path / "era5.nc", engine="netcdf4")
    np.testing.assert_array_equal(read_wind(tmp_path / "era5.nc").u, u[::-1])


def test_windninja_direction_is_where_the_wind_comes_from(tmp_path: Path) -> None:
    (tmp_path / "hill_vel.asc").write_text(HEADER + "10 10 10\n20 20 20\n")
    (tmp_path / "hill_ang.asc").write_text(HEADER + "45 90 0\n180 270 360\n")
    wind = wind_from_toml({"kind": "grid", "file": "hill_vel.asc", "units": "kph"}, tmp_path)
    assert isinstance(wind, Grid)
    assert (wind.origin, wind.spacing) == ((0.0, 1000.0), (100.0, 100.0))
    # From the north-east: blows towards the south-west.
    np.testing.assert_allclose(wind([[0.0, 1100.0]]), [[-10 / 3.6 / 2**0.5, -10 / 3.6 / 2**0.5]])
    np.testing.assert_allclose(wind([[100.0, 1000.0]]), [[20 / 3.6, 0.0]], atol=1e-12)


def asc(tmp_path: Path, vel: str, ang: str) -> Path:
    (tmp_path / "a_vel.asc").write_text(vel)
    (tmp_path / "a_ang.asc").write_text(ang)
    return tmp_path / "a_vel.asc"


GOOD = HEADER + "1 1 1\n1 1 1\n"


@pytest.mark.parametrize(
    ("vel", "ang", "units", "words"),
    [
        (GOOD, GOOD, "furlongs", "units must be one of 'knots', 'kph', 'm/s', 'mph', got 'furlongs'"),
        (GOOD, GOOD.replace("cellsize 100", "cellsize 90"), "m/s", "different grids"),
        (GOOD.replace("nrows 2\n", ""), GOOD, "m/s", "no nrows"),
        (HEADER + "1 1 1\n1 1\n", GOOD, "m/s", "5 found"),
        (HEADER + "1 1 1\n1 -9999 1\n", GOOD, "m/s", "missing .NaN or no data., first at \\(100, 1000\\) m"),
        (HEADER + "1 1 x\n1 1 1\n", GOOD, "m/s", "could not convert"),
    ],
)
def test_bad_windninja_files_are_named(tmp_path: Path, vel: str, ang: str, units: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        wind_from_toml({"kind": "grid", "file": asc(tmp_path, vel, ang).name, "units": units}, tmp_path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"names": ("speed", "v")}, "no variable with standard_name eastward_wind or named u .it has: 'speed', 'v'"),
        ({"units": "knots"}, "'u' must be in m/s, its units are 'knots'"),
        ({"units": ""}, "not stated"),
        ({"dims": ("latitude", "longitude")}, "in degrees .WGS 84.; project"),
        ({"coordinate_units": "km"}, "must be in metres, its units are 'km'"),
        ({"x": [0.0, 1.0, 5.0]}, "equally spaced"),
        ({"times": 2}, "one horizontal slice, its dimensions are time \\(2\\)"),
    ],
)
def test_bad_netcdf_files_are_named(tmp_path: Path, change: dict, words: str) -> None:
    xarray = pytest.importorskip("xarray")
    names, (north, east) = change.get("names", ("u", "v")), change.get("dims", ("y", "x"))
    times = change.get("times", 1)
    attributes = {"units": change.get("units", "m/s")}
    fields = {name: (("time", north, east), np.zeros((times, 2, 3)), attributes) for name in names}
    axis = {"units": change.get("coordinate_units", "m")}
    coords = {east: (east, change.get("x", [0.0, 1.0, 2.0]), axis), north: (north, [0.0, 1.0], axis)}
    xarray.Dataset(fields, coords=coords).to_netcdf(tmp_path / "w.nc", engine="netcdf4")
    with pytest.raises(InputError, match=words):
        read_wind(tmp_path / "w.nc")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("absent.nc", "cannot be read \\(No such file"),
        ("wind.csv", "must be NetCDF"),
        ("wind.asc", "named \\*_vel.asc"),
    ],
)
def test_unreadable_files_are_named(tmp_path: Path, name: str, words: str) -> None:
    pytest.importorskip("xarray")
    with pytest.raises(InputError, match=words):
        read_wind(tmp_path / name)


def test_grid_table_needs_a_file() -> None:
    with pytest.raises(InputError, match="the key 'file' is missing: the name of a file"):
        wind_from_toml({"kind": "grid"})


@pytest.mark.parametrize(
    ("origin", "spacing", "words"),
    [
        ((0.0, 0.0), (1e-317, 100.0), "spacing must be positive, at least 1e-06 m"),
        ((0.0, 0.0), (float("nan"), 100.0), "spacing must be positive"),
        ((0.0, 0.0), (1e300, 100.0), "coordinates must be finite and at most 1e.09 m"),
        ((float("inf"), 0.0), (100.0, 100.0), "coordinates must be finite"),
    ],
)
def test_nodes_that_lie_nowhere_are_refused(
    origin: tuple[float, float], spacing: tuple[float, float], words: str
) -> None:
    with pytest.raises(InputError, match=f"wind grid: {words}"):
        Grid(origin, spacing, np.zeros((3, 4)), np.zeros((3, 4)))


def test_a_walk_over_a_grid_ends_however_far_and_fine(tmp_path: Path) -> None:
    grid = Grid((0.0, 0.0), (1e-6, 1e-6), np.ones((50, 9000)), np.ones((50, 9000)))
    ends = np.array([[1e9, 1e9], [-1e9, 3.0], [8e-3, 1e-300], [float("nan"), 0.0]])
    grid.line_integral(-ends, ends)
    assert grid.line_integral([[0.0, 0.0]], [[1e9, 0.0]])[0] == pytest.approx(1e9)
