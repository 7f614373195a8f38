"""A field file with times: read as frames, kept, measured as it is then, and bad files named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from formulations.kernel import SquaredExponential
from formulations.mapping.flight import plan_flight
from formulations.mapping.map_grid import MapGrid
from formulations.mapping.map_model import MapModel
from formulations.mapping.survey import fly_survey
from instances import InputError
from instances.arrays import Floats
from instances.environment.radio_changing import ChangingField
from instances.environment.radio_files import read_field, read_measured
from instances.scenario_folder import kept_field
from instances.value_maps import read_value_map
from workbench.mission import environment
from workbench.mission.file import mission_of
from workbench.mission.redraw import conditions, measured_field
from workbench.mission.settings import Mission

xarray = pytest.importorskip("xarray")
X, Y = np.linspace(0.0, 4000.0, 5), np.linspace(0.0, 3000.0, 4)
SLOPE = np.add.outer(Y, 2 * X) / 1000
TIMES = [0.0, 100.0, 160.0]
LIFTS = [0.0, 10.0, 4.0]
MODEL = MapModel(SquaredExponential(30.0, (4000.0, 4000.0)), tau=100.0)
TABLE = {
    "airspeed": 50.0,
    "size": [4000, 3000],
    "depots": [[500, 500]],
    "tasks": [[2000, 2500], [3000, 1000]],
    "field": {"file": "plume.nc", "unit": "ppm"},
    "compare": {"seeds": 3},
}


def write(path: Path, values: Floats | None = None, times: list[float] = TIMES) -> Path:
    """Write a plume that rises and falls as a whole."""
    given = SLOPE + np.array(LIFTS)[:, None, None] if values is None else values
    metres = {"units": "m"}
    axes = {"x": ("x", X, metres), "y": ("y", Y, metres)}
    axes["time"] = ("time", times, {"units": "seconds since 2026-05-01"})
    xarray.Dataset({"plume": (("time", "y", "x"), given)}, coords=axes).to_netcdf(path, engine="netcdf4")
    return path


@pytest.fixture
def mission(tmp_path: Path) -> Mission:
    write(tmp_path / "plume.nc")
    return mission_of(TABLE, tmp_path, "m")


def lift(time: Floats | float) -> Floats:
    return np.interp(time, TIMES, LIFTS)


def test_it_is_linear_between_frames_and_the_last_is_held(tmp_path: Path) -> None:
    field = read_measured(write(tmp_path / "plume.nc"))
    assert isinstance(field, ChangingField)
    for time in (0.0, 25.0, 100.0, 130.0, 160.0, 1e6):
        np.testing.assert_allclose(field.at(time).values, SLOPE + lift(time), atol=1e-12)
    assert (field.lasts, field.bounds) == (160.0, (0.0, 0.0, 4000.0, 3000.0))


def test_a_mission_keeps_it_and_measures_it_as_it_is_then(mission: Mission, tmp_path: Path) -> None:
    said = environment.make(mission, {}, tmp_path, lambda _: None)
    assert said == "field from 0.0 to 21.0 ppm, in 3 frames over 160 s, the last one held"
    kept = kept_field(tmp_path)
    measured = measured_field(mission, kept)
    assert isinstance(measured, ChangingField)
    assert measured.unit == "ppm"
    assert all(field is kept for field, _ in conditions(mission, kept))
    square = np.array([[500.0, 500.0], [3500.0, 500.0], [3500.0, 2500.0], [500.0, 2500.0], [500.0, 500.0]])
    flight = plan_flight([square[k : k + 2] for k in range(4)], speed=50.0, radius=50.0)
    points = MapGrid.over(mission.scenario.region, 8).points
    survey = fly_survey([flight], measured, points, model=MODEL, noise_sd=1e-3, refit_every=0)
    x, y = survey.positions.T
    np.testing.assert_allclose(survey.values, (y + 2 * x) / 1000 + lift(survey.times), atol=0.01)
    assert survey.times[-1] > 160.0
    posterior, truth = survey.ticks[-1].posterior, (points[:, 1] + 2 * points[:, 0]) / 1000 + LIFTS[-1]
    assert posterior is not None
    assert survey.ticks[-1].score.rmse == pytest.approx(np.sqrt(np.mean((posterior.mean - truth) ** 2)))


def test_where_a_field_that_stays_is_wanted_it_is_refused(mission: Mission, tmp_path: Path) -> None:
    path = tmp_path / "plume.nc"
    for read in (read_field, lambda file: read_value_map(file, mission.scenario.site, 1.0)):
        with pytest.raises(InputError, match=r"plume.nc: holds 3 times, where a field that stays is wanted"):
            read(path)


def test_bad_files_are_named_with_the_frame(tmp_path: Path) -> None:
    path, missing = tmp_path / "bad.nc", np.array([SLOPE, SLOPE, SLOPE])
    missing[1, 0, 0] = np.nan
    with pytest.raises(InputError, match=r"bad.nc: frame 1: .*missing"):
        read_measured(write(path, missing))
    with pytest.raises(InputError, match=r"bad.nc: coordinate 'time' must increase from frame to frame, frame 2"):
        read_measured(write(path, times=[0.0, 50.0, 20.0]))
    xarray.Dataset({"a": (("level", "y", "x"), missing)}, coords={"x": X, "y": Y}).to_netcdf(path)
    with pytest.raises(
        InputError, match=r"bad.nc: must hold one variable of two dimensions, or of these and the times"
    ):
        read_measured(path)
