"""The wind families: seeded scenarios with no-fly zones, winds with vorticity, files that come back."""

from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.families import make_scenario
from instances.scenario import read_scenario, write_scenario

MISSIONS = ["wind-uniform", "wind-vortices", "wind-mountains"]
SMALL = {"wind-mountains": {"cells": 60}}


@pytest.mark.parametrize("name", MISSIONS)
def test_scenarios_are_seeded_and_stay_outside_their_zones(name: str) -> None:
    one, same, other = (make_scenario(name, 12, 3, seed, **SMALL.get(name, {})) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.points, same.points)
    assert (one.points != other.points).any()
    assert len(one.no_fly) == 5
    assert one.free.contains(one.points).all()
    points = one.region.sample(200, np.random.default_rng(0))
    assert one.wind is not None
    assert same.wind is not None
    np.testing.assert_array_equal(one.wind(points), same.wind(points))
    assert np.hypot(*one.wind(points).T).max() < one.speed


@pytest.mark.parametrize("name", MISSIONS)
def test_their_winds_carry_vorticity(name: str) -> None:
    scenario = make_scenario(name, 5, 1, 3, **SMALL.get(name, {}))
    x0, y0, x1, y1 = scenario.region.bounds
    xs, ys = np.linspace(x0, x1, 101), np.linspace(y0, y1, 101)
    u, v = scenario.wind(np.stack(np.meshgrid(xs, ys), axis=-1)).reshape(101, 101, 2).transpose(2, 0, 1)
    curl = np.gradient(v, xs, axis=1) - np.gradient(u, ys, axis=0)
    assert np.sqrt((curl**2).mean()) > 1.5e-4


@pytest.mark.parametrize("name", MISSIONS)
def test_scenario_files_come_back(name: str, tmp_path: Path) -> None:
    scenario = make_scenario(name, 6, 2, 4, **SMALL.get(name, {}))
    write_scenario(scenario, tmp_path / "s.toml")
    again = read_scenario(tmp_path / "s.toml")
    np.testing.assert_allclose(again.points, scenario.points)
    points = scenario.free.sample(50, np.random.default_rng(1))
    assert scenario.wind is not None
    assert again.wind is not None
    np.testing.assert_allclose(again.wind(points), scenario.wind(points))
    assert again.free.area == pytest.approx(scenario.free.area)


def test_what_they_refuse() -> None:
    with pytest.raises(InputError, match=r"family wind-vortices: zones: 60 no-fly zones .* do not fit"):
        make_scenario("wind-vortices", 5, 1, 0, zones=60)
    with pytest.raises(InputError, match=r"300 vortices .* do not fit"):
        make_scenario("wind-vortices", 5, 1, 0, vortices=300)
    with pytest.raises(InputError, match="did you mean 'vortices'"):
        make_scenario("wind-vortices", 5, 1, 0, vortexes=3)
