"""Forecasts: files of winds of closed form come back as those winds, at any steps; what files cannot say is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.environment.region import Region
from instances.environment.wind_changing import ChangingWind, Drifting, Front, Turning
from instances.environment.wind_forecast import Forecast, sampled
from instances.environment.wind_grid import Grid
from instances.environment.wind_table import wind_from_toml
from instances.families import make_scenario
from instances.scenario import read_scenario, scenario_of
from instances.scenario_folder import keep_scenario, kept_scenario
from instances.wind_arrivals import quickest_times, track_times

TURNING = Turning((10.0, 0.0), np.pi / 2 / 3600)
FRONT = Front((5.0, 5.0), (-5.0, 3.0), 8.0, 30.0, -5000.0, 3000.0)
DRIFTING = Drifting((5.0, 0.0), (3.0, 1.0), ((5000.0, 5000.0), (9000.0, 3000.0)), (8e4, -8e4), (2500.0, 2500.0))
REGION = Region.rectangle(20000.0, 16000.0)
STEPS = np.array([0.0, 100.0, 250.0, 300.0, 600.0, 700.0, 900.0, 1200.0, 1500.0, 1600.0, 1800.0])


@pytest.mark.parametrize("wind", [TURNING, FRONT, DRIFTING])
def test_a_file_of_a_wind_is_that_wind(wind: ChangingWind, tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    rng = np.random.default_rng(0)
    points, times = rng.uniform(0, (20000, 16000), (400, 2)), rng.uniform(0, 1800, 400)
    made = sampled(wind, REGION, STEPS, 80)
    again = wind_from_toml(made.to_toml(tmp_path), tmp_path)
    assert isinstance(again, Forecast)
    np.testing.assert_array_equal(again.times, STEPS)
    np.testing.assert_array_equal(again.velocities(points, times), made.velocities(points, times))
    np.testing.assert_allclose(again.velocities(points, times), wind.velocities(points, times), atol=0.3)
    nodes = made.origin + np.array(made.spacing) * rng.integers(0, 60, (20, 2))
    at = rng.choice(STEPS, 20)
    np.testing.assert_allclose(again.velocities(nodes, at), wind.velocities(nodes, at), atol=1e-12)
    np.testing.assert_allclose(again.at(475.0)(nodes), again.velocities(nodes, np.full(20, 475.0)), atol=1e-12)
    np.testing.assert_allclose(again.line_integral(points, nodes[:1]), again.at(0.0).line_integral(points, nodes[:1]))


def test_legs_in_a_forecast_take_what_they_take_in_the_wind_it_is_of() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.uniform(0, (20000, 16000), (2, 30, 2))
    departures = rng.uniform(0, 600, 30)
    made = sampled(FRONT, REGION, np.arange(0.0, 4001.0, 50.0), 80)
    times = track_times(a, b, departures, made, 20.0)
    assert times == pytest.approx(track_times(a, b, departures, FRONT, 20.0), rel=1e-3)
    late = np.full(30, 1e5)
    still = Turning((6.0, -2.0), 0.0)
    assert track_times(a, b, late, sampled(still, REGION, STEPS, 4), 20.0) == pytest.approx(
        quickest_times(b - a, late, still, 20.0), rel=1e-9
    )


def test_the_last_frame_is_held_and_take_off_is_later_than_the_first() -> None:
    points = REGION.sample(5, np.random.default_rng(2))
    made = sampled(TURNING, REGION, STEPS, 4)
    last = TURNING.velocities(points, np.full(5, 1800.0))
    assert made.velocities(points, np.full(5, 9e9)) == pytest.approx(last)
    later = Forecast(made.times, made.origin, made.spacing, made.u, made.v, take_off=600.0)
    assert later.lasts == 1200.0
    assert later(points) == pytest.approx(TURNING.velocities(points, np.full(5, 600.0)))
    assert later.velocities(points, np.full(5, 1200.0)) == pytest.approx(last)


def test_a_scenario_and_its_folder_keep_a_forecast(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    sampled(TURNING, REGION, STEPS, 4).write(tmp_path / "given.nc")
    table = (
        'cost = "time"\nairspeed = 20.0\nsize = [20000.0, 16000.0]\ndepots = [[1.0, 1.0]]\ntasks = [[9000.0, 9000.0]]\n'
    )
    path = tmp_path / "s.toml"
    path.write_text(table + '[wind]\nkind = "grid"\nfile = "given.nc"\ntake_off = 600.0\n')
    scenario = read_scenario(path)
    keep_scenario(scenario, tmp_path)
    kept = kept_scenario(tmp_path).wind
    assert isinstance(kept, Forecast)
    points, times = scenario.points, np.array([0.0, 500.0])
    assert kept.velocities(points, times) == pytest.approx(TURNING.velocities(points, times + 600.0), rel=5e-3)
    again = read_scenario(tmp_path / "scenario.toml").wind
    assert isinstance(again, Forecast)
    assert again.lasts == kept.lasts
    assert again.velocities(points, times) == pytest.approx(kept.velocities(points, times), rel=1e-9)
    with pytest.raises(InputError, match="energy is no clock"):
        scenario_of({**make_scenario_table(), "wind": {"kind": "grid", "file": "given.nc"}}, tmp_path, "s")


def make_scenario_table() -> dict[str, object]:
    return {"ground_speed": 20.0, "size": [20000.0, 16000.0], "depots": [[1.0, 1.0]], "tasks": [[2.0, 2.0]]}


@pytest.mark.parametrize(
    ("times", "unit", "take_off", "bad", "words"),
    [
        ([0, 600, 600], "s", 0.0, 0, r"wind.nc: coordinate 'time' must increase from frame to frame, frame 2 is at "),
        ([0, 600, 300], "s", 0.0, 0, "coordinate 'time' must increase from frame to frame, frame 2 is at "),
        ([0, 600, 900], "s", 900.0, 0, "take_off must be before its last frame, 900 s after its first, got 900 s"),
        ([0, 600, 900], "s", 0.0, 2, r"wind.nc, frame 1: 2 of 9 values are missing \(NaN or no data\), first at "),
        ([0], "s", 60.0, 0, "wind.nc: holds the wind of one time: leave take_off out"),
        (
            [0, 1, 2],
            "",
            0.0,
            0,
            r"one horizontal slice, its dimensions are time \(3\), y \(3\), x \(3\), or one at each of",
        ),
    ],
)
def test_what_forecasts_cannot_be(
    times: list[int], unit: str, take_off: float, bad: int, words: str, tmp_path: Path
) -> None:
    xarray = pytest.importorskip("xarray")
    values = np.ones((len(times), 3, 3))
    values[-2:-1, 0, :bad] = np.nan
    fields = {name: (("time", "y", "x"), values, {"units": "m/s"}) for name in ("u", "v")}
    since = {"units": "seconds since 2026-05-01"} if unit else {}
    coords = {"time": ("time", times, since), "y": [0.0, 1.0, 2.0], "x": [0.0, 1.0, 2.0]}
    xarray.Dataset(fields, coords=coords).to_netcdf(tmp_path / "wind.nc", engine="netcdf4")
    with pytest.raises(InputError, match=words):
        wind_from_toml({"kind": "grid", "file": "wind.nc"} | ({"take_off": take_off} if take_off else {}), tmp_path)


def test_frames_in_degrees_are_brought_to_the_plane_and_one_frame_is_a_wind_that_stays(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("pyproj")
    east, north = np.linspace(10.9, 11.4, 11), np.linspace(46.9, 47.3, 9)
    hours = np.array([0.0, 1.0, 3.0])
    u = np.broadcast_to(hours[:, None, None] * 2.0, (3, 9, 11))
    fields = {
        name: (("valid_time", "latitude", "longitude"), w, {"units": "m s-1", "standard_name": standard})
        for name, w, standard in (("u10", u, "eastward_wind"), ("v10", 0 * u, "northward_wind"))
    }
    since = ("valid_time", hours, {"units": "hours since 2026-05-01T06:00"})
    coords = {"valid_time": since, "latitude": north, "longitude": east}
    data = xarray.Dataset(fields, coords=coords)
    data.to_netcdf(tmp_path / "w.nc", engine="netcdf4")
    data.isel(valid_time=[1]).to_netcdf(tmp_path / "one.nc", engine="netcdf4")
    table = {"cost": "time", "airspeed": 20.0, "origin": [47.1, 11.15], "crs": "local", "size": [9000.0, 9000.0],
             "depots": [[1.0, 1.0]], "tasks": [[2000.0, 2.0]]}  # fmt: skip
    wind = scenario_of({**table, "wind": {"kind": "grid", "file": "w.nc"}}, tmp_path, "s").wind
    assert isinstance(wind, Forecast)
    at = wind.velocities(np.full((4, 2), 4000.0), 3600 * np.array([0.5, 1.0, 2.0, 9.0]))
    np.testing.assert_allclose(at, [[1.0, 0.0], [2.0, 0.0], [4.0, 0.0], [6.0, 0.0]], atol=0.01)
    still = scenario_of({**table, "wind": {"kind": "grid", "file": "one.nc"}}, tmp_path, "s").wind
    assert isinstance(still, Grid)


def test_families_of_changing_winds_become_forecasts() -> None:
    scenario = make_scenario("wind-front", 4, 2, 0)
    assert isinstance(scenario.wind, ChangingWind)
    made = sampled(scenario.wind, scenario.region, STEPS, 20)
    assert made.bounds == pytest.approx(scenario.region.bounds)
    assert isinstance(made, ChangingWind)
