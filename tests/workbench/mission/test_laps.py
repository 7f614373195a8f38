"""Laps: how often tours are flown, within the endurance, and what the flight stage makes of it."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from instances import InputError, Instance
from workbench.mission.file import mission_of
from workbench.mission.laps import Laps, kept_laps, laps_of
from workbench.mission.pipeline import run_mission
from workbench.mission.settings import Mission

TABLE: dict[str, Any] = {
    "airspeed": 50.0,
    "size": [6000, 5000],
    "depots": [[500, 500], [5500, 500]],
    "tasks": [[1000, 3000], [2500, 4000], [4000, 3800], [5000, 2000]],
    "origin": [47.0, 8.0],
    "radio": {"position": [3000, 2500]},
    "field": {"model": "free-space", "cells": 20, "tau": 300.0},
    "place": {"tests": [6, 6]},
    "costs": {"method": "closed-form"},
    "routes": {"solver": "greedy", "time_limit": 1.0, "bound_time_limit": 0.0},
    "map": {"length_scale": 1500.0, "cells": 12, "tau": 300.0, "kernel": "matern12", "refit_every": 30, "frames": 2},
}
ROUTES = ((0, 1), (2,))


def mission_with(**flight: Any) -> Mission:
    return mission_of(TABLE | {"flight": flight}, Path(), "m")


def instance(endurance: list[float] | None = None) -> Instance:
    """Return costs of which the two tours of `ROUTES` are 30 s and 20 s."""
    limits = None if endurance is None else np.array(endurance)
    return Instance("m", 10.0 * (1.0 - np.eye(5)), 3, 2, endurance=limits)


def counts(laps: Laps) -> list[int]:
    return [len(turned) for turned in laps.turned]


def test_endurance_is_used_up_by_each_uav_on_its_own() -> None:
    assert counts(laps_of(mission_with(), instance(), ROUTES)) == [1, 1]
    assert counts(laps_of(mission_with(laps=3), instance(), ROUTES)) == [3, 3]
    assert counts(laps_of(mission_with(laps="endurance", endurance=90.0), instance(), ROUTES)) == [3, 4]
    assert counts(laps_of(mission_with(laps="endurance", endurance=90.0), instance([59.9, math.inf]), ROUTES)) == [1, 4]
    assert counts(laps_of(mission_with(laps=2, endurance=60.0), instance(), ((0, 1), ()))) == [2, 0]


def test_more_laps_than_endurance_are_refused() -> None:
    with pytest.raises(InputError, match=r"flight\.laps = 3: 3 × 30\.0 s is more than UAV 0's endurance of 89\.9 s"):
        laps_of(mission_with(laps=3, endurance=89.9), instance(), ROUTES)
    with pytest.raises(InputError, match=r"1 × 30\.0 s is more than UAV 0's endurance of 25\.0 s"):
        laps_of(mission_with(laps="endurance", endurance=25.0), instance(), ROUTES)
    with pytest.raises(InputError, match=r"UAV 0 could fly its tour more than 1000 times"):
        laps_of(mission_with(laps="endurance", endurance=1e6), instance(), ROUTES)


@pytest.mark.parametrize("laps", [0, 1001, 1.5, "for ever", "endurance"])
def test_laps_that_are_none_are_refused(laps: object) -> None:
    with pytest.raises(InputError, match="laps"):
        mission_with(laps=laps)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("laps")
    mission = mission_with(laps="endurance", endurance=900.0)
    for stage in ("environment", "place", "costs", "routes", "flight", "map"):
        run_mission(mission, out, only=stage)
    return out


def test_all_laps_together_keep_the_endurance_and_fill_it(made: Path) -> None:
    laps = json.loads((made / "5-flight/laps.json").read_text())
    costs = json.loads((made / "4-routes/run.json").read_text())["tour_costs"]
    assert all(len(turned) == int(900.0 / cost) > 1 for turned, cost in zip(laps["turned"], costs, strict=True))
    assert laps["sd"] <= laps["unturned_sd"]
    assert kept_laps(made / "5-flight") == round(np.mean([len(turned) for turned in laps["turned"]]))
    checks = pd.read_csv(made / "5-flight/flight-check.csv")
    flown = [len(turned) * cost * 50.0 for turned, cost in zip(laps["turned"], costs, strict=True)]
    np.testing.assert_allclose(checks["reference_length"], flown, rtol=1e-6)
    assert (checks["least_radius"] >= 50.0 - 1e-6).all()
    assert (checks[["task_distance", "outside"]] <= 0.1).all(axis=None)


def test_plans_for_the_autopilot_pass_every_task_on_every_lap(made: Path) -> None:
    laps = [len(turned) for turned in json.loads((made / "5-flight/laps.json").read_text())["turned"]]
    routes = json.loads((made / "4-routes/run.json").read_text())["routes"]
    for uav, (count, route) in enumerate(zip(laps, routes, strict=True)):
        text = (made / f"5-flight/uav-{uav}.kml").read_text()
        for task in route:
            assert len(re.findall(rf"\b[Tt]ask {task}\b", text)) == count


def test_the_survey_goes_on_over_all_laps_and_its_map_knows_tau(made: Path) -> None:
    ticks, checks = pd.read_csv(made / "6-map/ticks.csv"), pd.read_csv(made / "5-flight/flight-check.csv")
    assert ticks["time"].iloc[-1] == pytest.approx(checks["duration"].max(), abs=10.0)
    np.testing.assert_allclose(ticks["tau"], 300.0)
    assert json.loads((made / "6-map/model.json").read_text())["tau"] == pytest.approx(300.0)
