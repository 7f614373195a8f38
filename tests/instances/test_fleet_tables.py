"""Fleets in scenario files: who flies from where, what is written back, and what is refused."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from instances.errors import InputError
from instances.fleet import Fleet, Return
from instances.scenario import Scenario, read_scenario, scenario_of, write_scenario

BASE = """
ground_speed = 20.0
size = [100, 100]
depots = [[1, 1], [9, 9]]
tasks = [[3, 3], [4, 5], [6, 2]]
"""
UAVS = """
service = [1, 2.5, 0]
return = "any"
[[uav]]
depot = 1
count = 2
speed = 30.0
[[uav]]
depot = 0
endurance = 50
"""


def scenario(text: str) -> Scenario:
    return scenario_of(tomllib.loads(BASE + text), Path(), "s")


def test_each_uav_has_a_depot_of_its_own() -> None:
    read = scenario(UAVS)
    assert read.depots.tolist() == [[9, 9], [9, 9], [1, 1]]
    assert read.fleet.speeds is not None
    assert read.fleet.endurance is not None
    assert read.fleet.speeds.tolist() == [30, 30, 20]
    assert read.fleet.endurance.tolist() == [np.inf, np.inf, 50]
    assert (np.asarray(read.fleet.service).tolist(), read.fleet.returns) == ([1, 2.5, 0], Return.ANY)


def test_a_scenario_without_a_fleet_has_none() -> None:
    fleet = scenario("").fleet
    assert fleet.alike
    assert fleet.endurance is None
    assert scenario('service = 0\nreturn = "own"\n[[uav]]\ndepot = 0\nspeed = 20\n[[uav]]\ndepot = 1').fleet.alike


def test_a_wait_before_take_off_is_for_winds_that_change(tmp_path: Path) -> None:
    turning = '[wind]\nkind = "turning"\nvelocity = [3, 0]\nturning = 90\n'
    text = BASE.replace("ground_speed", 'cost = "time"\nwindow = 90\nairspeed')
    read = scenario_of(tomllib.loads(text + turning), Path(), "s")
    write_scenario(read, tmp_path / "s.toml")
    assert read_scenario(tmp_path / "s.toml").fleet.window == read.fleet.window == 90.0
    with pytest.raises(InputError, match=r"window is 90.0 s, and to wait before take-off helps only in a wind that"):
        scenario_of(tomllib.loads(text), Path(), "s")
    with pytest.raises(InputError, match="window"):
        scenario_of(tomllib.loads(text.replace("90", "-1") + turning), Path(), "s")


@pytest.mark.parametrize("text", ["", UAVS, "service = 30.0", 'return = "none"', UAVS.replace("speed = 30.0", "")])
def test_written_and_read_again(tmp_path: Path, text: str) -> None:
    first = scenario(text)
    write_scenario(first, tmp_path / "s.toml")
    again = read_scenario(tmp_path / "s.toml")
    assert again.depots.tolist() == first.depots.tolist()
    for name in ("speeds", "endurance", "service", "returns"):
        np.testing.assert_array_equal(getattr(again.fleet, name), getattr(first.fleet, name))


REFUSED = {
    "service = -1": "service must be a number of at least 0 [s] or a list of numbers of at least 0 [s], got -1",
    "service = [1, 2]": "service [s] must be 3 numbers for the 3 tasks",
    "service = 'long'": "service must be a number of at least 0 [s] or a list of numbers of at least 0 [s], got 'long'",
    "service = 1e30": "service must be a number from 0 to 1e+12 [s]",
    "return = 'home'": "return must be one of 'own', 'any', 'none', got 'home'",
    "uav = 3": "[[uav]] must be tables, got 3",
    "[[uav]]\ndepot = 0": "depots[1] has no [[uav]]",
    "[[uav]]\nspeed = 3": "[[uav]] 1 depot must be the number of a depot, 0 to 1, got None",
    "[[uav]]\ndepot = 2": "[[uav]] 1 depot must be the number of a depot, 0 to 1, got 2",
    "[[uav]]\ndepot = true": "[[uav]] 1 depot must be a whole number of at least 0, got True",
    "[[uav]]\ndepot = 0\ncount = 0": "[[uav]] 1 count must be a whole number from 1 to 10000, got 0",
    "[[uav]]\ndepot = 0\nspeed = -3": "[[uav]] 1 speed must be a positive number [m/s], got -3",
    "[[uav]]\ndepot = 0\nendurance = 'x'": "[[uav]] 1 endurance must be a positive number [s], got 'x'",
    "[[uav]]\ndepot = 0\nspede = 3": "[[uav]] 1: unknown key 'spede'; did you mean 'speed'?",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_cannot_be_used_is_named(text: str) -> None:
    with pytest.raises(InputError) as error:
        scenario(text)
    assert REFUSED[text] in str(error.value)


def test_a_fleet_fits_its_scenario() -> None:
    with pytest.raises(InputError, match=r"speed .* must be 2 numbers for the 2 UAVs, each positive"):
        Fleet(speeds=np.array([20.0])).checked(3, 2)
