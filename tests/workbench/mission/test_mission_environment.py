"""The mission's environment: a field of one's own, the signal of a transmitter, and widened no-fly zones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from instances.environment.radio import RadioMap
from instances.environment.radio_files import write_field
from instances.environment.region import Region
from instances.errors import InputError
from instances.scenario import Scenario
from workbench.mission.environment import field_of
from workbench.mission.file import mission_of
from workbench.mission.place import widened, zones_of
from workbench.mission.settings import Mission

TABLE = {"airspeed": 50.0, "size": [2000, 1000], "depots": [[100, 100]], "tasks": 3}


def with_field(folder: Path, field: RadioMap, name: str) -> Mission:
    write_field(field, folder / name)
    return mission_of(TABLE | {"field": {"file": name}}, folder, "m")


@pytest.mark.parametrize("name", ["own.csv", "own.nc"])
def test_a_field_of_ones_own(tmp_path: Path, name: str) -> None:
    if name.endswith(".nc"):
        pytest.importorskip("xarray")
    own = RadioMap(
        np.linspace(0, 2000, 9), np.linspace(0, 1000, 5), np.random.default_rng(0).normal(size=(5, 9)), "ppm"
    )
    found = field_of(with_field(tmp_path, own, name), None)
    points = np.random.default_rng(1).uniform(0, 1000, (50, 2))
    np.testing.assert_allclose(found(points), own(points), rtol=1e-12)
    assert found.unit == "ppm"


def test_a_field_that_does_not_cover_the_region(tmp_path: Path) -> None:
    own = RadioMap(np.linspace(0, 20, 9), np.linspace(0, 10, 5), np.zeros((5, 9)))  # in hundreds of metres
    with pytest.raises(InputError, match=r"own\.csv covers \(0, 0\) to \(20, 10\) m and not all of the region"):
        field_of(with_field(tmp_path, own, "own.csv"), None)


def test_a_field_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"field\.file: there is no file .*own\.csv"):
        mission_of(TABLE | {"field": {"file": "own.csv"}}, tmp_path, "m")


def test_the_signal_is_strongest_above_the_transmitter() -> None:
    radio = {"position": [1500, 500]}
    settings = {"model": "free-space", "shadowing_sd": 0, "cells": 40}
    field = field_of(mission_of(TABLE | {"radio": radio, "field": settings}, Path(), "m"), None)
    j, i = np.unravel_index(np.argmax(field.values), field.values.shape)
    assert (field.x[i], field.y[j]) == pytest.approx((1500, 500))


def test_zones_and_holes_are_widened_and_a_depot_too_near_is_said() -> None:
    hole = [[600, 600], [700, 600], [700, 700], [600, 700]]
    region = Region(Polygon([(0, 0), (2000, 0), (2000, 1000), (0, 1000)], [hole]))
    scenario = Scenario("s", region, [[100, 100]], 50.0, n_tasks=3, no_fly=[box(1000, 200, 1200, 400)])
    assert len(zones_of(scenario)) == 2
    free = widened(scenario, 50.0).free
    assert not free.contains([[960, 300], [650, 560]]).any()
    assert free.contains([[940, 300], [650, 540]]).all()
    assert widened(scenario, 0.0) is scenario
    with pytest.raises(InputError, match=r"depots\[0\] .*widened by 900 m: costs\.clearance"):
        widened(scenario, 900.0)
