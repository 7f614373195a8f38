"""Spread of fixed tours over an ensemble: closed forms of its measures, and files that hold one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.environment.region import Region
from instances.environment.wind_changing import Turning
from instances.environment.wind_forecast import Forecast, sampled
from instances.environment.wind_table import wind_from_toml
from instances.moving_cost import CostKind
from instances.paths import Paths
from instances.scenario import Scenario
from instances.scenario_folder import keep_scenario, kept_scenario
from instances.wind_ensemble import cvar, spread
from instances.wind_triangle import flight_times

SIDE = 8000.0
NODES = np.array([[1e3, 1e3], [7e3, 1e3], [4e3, 7e3]])
STRAIGHT = Paths.of(3, [NODES[[a, b]] if a != b else np.empty((0, 2)) for a in range(3) for b in range(3)])
REGION = Region.rectangle(SIDE, SIDE)


def still(u: float, v: float) -> Forecast:
    return sampled(Turning((u, v), 0.0), REGION, np.array([0.0, 600.0]), 4)


def test_cvar_is_between_mean_and_worst() -> None:
    values = np.array([3.0, 1.0, 2.0, 5.0, 4.0])
    assert [cvar(values, share) for share in (1.0, 0.4, 0.2, 0.3, 0.1)] == pytest.approx(
        [3.0, 4.5, 5.0, (5 + 0.5 * 4) / 1.5, 5.0]
    )


def test_the_spread_is_what_the_tour_takes_in_each_member() -> None:
    members = (still(5.0, 0.0), still(-3.0, 4.0))
    found = spread(STRAIGHT, ((0, 1),), 2, replace(still(0.0, 0.0), members=members), 20.0)
    assert found is not None
    tour = NODES[[2, 0, 1, 2]]
    assert found.planned == pytest.approx(float(np.hypot(*np.diff(tour, axis=0).T).sum()) / 20.0)
    assert found.members == pytest.approx(
        [flight_times(tour[:-1], tour[1:], each.at(0.0), 20.0).sum() for each in members]
    )
    assert found.worst == max(found.members)
    assert found.cvar == pytest.approx(found.worst), "a fifth of two members is the worse one"
    assert spread(STRAIGHT, ((0, 1),), 2, still(1.0, 0.0), 20.0) is None
    waited = spread(STRAIGHT, ((0, 1),), 2, replace(still(0.0, 0.0), members=members), 20.0, begins=[100.0])
    assert waited is not None
    assert waited.members == pytest.approx([100.0 + each for each in found.members]), "landings count"
    with pytest.raises(InputError, match="not less than the airspeed"):
        spread(STRAIGHT, ((0, 1),), 2, replace(still(0.0, 0.0), members=(still(25.0, 0.0),)), 20.0)


def test_files_hold_an_ensemble(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    wind = replace(still(1.0, 0.0), members=(still(2.0, 0.0), still(3.0, 0.0)))
    table = wind.to_toml(tmp_path)
    assert table["members"] == ["wind-1.nc", "wind-2.nc"]
    again = wind_from_toml(table, tmp_path)
    assert isinstance(again, Forecast)
    scenario = Scenario("s", REGION, NODES[2:], 20.0, again, NODES[:2], cost=CostKind.TIME)
    keep_scenario(scenario, tmp_path)
    kept = kept_scenario(tmp_path).wind
    assert isinstance(kept, Forecast)
    assert [each(NODES[:1])[0, 0] for each in kept.members] == pytest.approx([2.0, 3.0])
    wind.at(0.0).to_toml(tmp_path)
    with pytest.raises(InputError, match=r"wind.nc: holds the wind of one time: leave members out"):
        wind_from_toml(table, tmp_path)
