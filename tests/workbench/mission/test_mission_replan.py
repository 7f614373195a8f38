"""Re-planning in a mission: what is written and flown, that nothing changes without it, and bad input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import shapely

from instances import InputError
from workbench.mission.events import scenarios_after
from workbench.mission.file import mission_of
from workbench.mission.map import settings
from workbench.mission.pipeline import FOLDERS, run_mission
from workbench.mission.replan import Replanning

TABLE: dict[str, Any] = {
    "ground_speed": 50.0,
    "size": [6000, 5000],
    "depots": [[500, 500], [5500, 500]],
    "tasks": [[1000, 3000], [2500, 4000], [4000, 3800], [5000, 2000]],
    "radio": {"position": [3000, 2500]},
    "field": {"model": "free-space", "cells": 20},
    "place": {"tests": [6, 6]},
    "costs": {"method": "closed-form"},
    "routes": {"solver": "greedy", "time_limit": 1.0, "bound_time_limit": 0.0},
    "map": {"length_scale": 1500.0, "cells": 12, "kernel": "se", "refit_every": 30, "frames": 2},
}
ZONE = [[1500.0, 1200.0], [2600.0, 1200.0], [2600.0, 2400.0], [1500.0, 2400.0]]
LOST = {"time": 70.0, "kind": "lost-uav", "uav": 1}
CLOSED = {"time": 35.0, "kind": "no-fly", "polygon": ZONE}
WIND = {"time": 20.0, "kind": "wind", "velocity": [5.0, 0.0]}
STAGES = ("environment", "place", "costs", "routes", "flight", "map")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("replan")
    events = [LOST, CLOSED, {"time": 9000.0, "kind": "wind", "velocity": [1.0, 0.0]}]
    more = {"origin": [47.0, 8.0], "flight": {"endurance": 200.0}, "replan": {"every": 5, "event": events}}
    mission = mission_of(TABLE | more, Path(), "m")
    for stage in STAGES:
        run_mission(mission, out, only=stage)
    return out


def test_every_re_plan_is_told_and_endurance_is_kept(made: Path) -> None:
    told = json.loads((made / "6-map/replans.json").read_text())
    reasons = {row["time"]: row["reason"] for row in told["replans"]}
    assert reasons[35.0] == "a no-fly zone appears"
    assert reasons[50.0] == "5 rounds of measurements"
    assert reasons[70.0] == "UAV 1 is lost"
    assert told["late"] == ["the wind is now (1, 0) m/s at 9000 s"]
    assert told["budgets"] == [200.0, 200.0]
    assert any(row["accepted"] for row in told["replans"])
    for row in told["replans"]:
        assert not row["accepted"] or row["sd_before"] is None or row["sd_after"] < row["sd_before"]
        assert row["accepted"] or row["left_before"] == row["left_after"]
    flown = pd.read_csv(made / "6-map/flight-check.csv")
    assert (flown["length"] <= 200.0 * 50.0 + 1e-6).all()
    assert (flown["least_radius"] > 49.9).all()


def test_what_was_planned_stays_and_what_was_flown_is_mapped(made: Path) -> None:
    planned, flown = (pd.read_csv(made / f"{folder}/flown.csv") for folder in ("5-flight", "6-map"))
    before, after = (table[table["time"] <= 30.0] for table in (planned, flown))
    pd.testing.assert_frame_equal(before.reset_index(drop=True), after.reset_index(drop=True), atol=1e-3)
    assert planned.loc[planned["uav"] == 1, "time"].max() > 70.0
    assert flown.loc[flown["uav"] == 1, "time"].max() == pytest.approx(70.0)
    samples = pd.read_csv(made / "6-map/samples.csv")
    for uav, own in samples.groupby("uav"):
        track = flown[flown["uav"] == uav]
        for axis in ("x", "y"):
            assert np.allclose(np.interp(own["time"], track["time"], track[axis]), own[axis], atol=0.5)


def test_a_zone_that_appears_is_flown_round_from_then_on(made: Path) -> None:
    zone = shapely.Polygon(ZONE)
    crossing = {}
    for folder in ("5-flight", "6-map"):
        flown = pd.read_csv(made / f"{folder}/flown.csv")
        late = flown[flown["time"] > 35.0]
        crossing[folder] = shapely.contains_xy(zone, late["x"], late["y"]).any()
    assert crossing == {"5-flight": True, "6-map": False}


def test_flights_that_may_be_flown_so_again_are_exported(made: Path) -> None:
    said = json.loads((made / "6-map/exports.json").read_text())
    assert said["without"]["UAV 1"] == "no plan: it is lost"
    assert not (made / "6-map/uav-1.plan").exists()
    plan = json.loads((made / "6-map/uav-0.plan").read_text())
    assert [fence["inclusion"] for fence in plan["geoFence"]["polygons"]] == [True, False]  # the zone that appeared


def test_what_remains_is_placed_by_the_criterion_and_weights_of_place(made: Path, tmp_path: Path) -> None:
    (tmp_path / "w.csv").write_text("x,y,value\n1000,2500,9\n5000,2500,1\n")
    folders = {name: made / folder for name, folder in FOLDERS.items()}
    for criterion in ("b", "j"):
        place = TABLE["place"] | {"criterion": criterion, "weights": "w.csv"}
        mission = mission_of(TABLE | {"place": place, "replan": {"every": 5}}, tmp_path, "m")
        planner = Replanning(mission, folders).planner
        assert planner.by_variance == (criterion == "j")
        for points, weights in ((planner.tests, planner.test_weights), (planner.targets, planner.weights)):
            assert weights is not None
            assert weights[points[:, 0] < 1500].min() > 8 * weights[points[:, 0] > 4500].max() - 1


def test_without_replan_nothing_is_different() -> None:
    plain, empty = (mission_of(TABLE | more, Path(), "m") for more in ({}, {"replan": {}}))
    assert settings(plain) == settings(empty)
    assert "replan" not in settings(plain)
    assert settings(mission_of(TABLE | {"replan": {"every": 5}}, Path(), "m")) != settings(plain)


def test_scenarios_add_up_in_order_of_time() -> None:
    mission = mission_of(TABLE | {"replan": {"event": [LOST, CLOSED, WIND]}}, Path(), "m")
    (wind, first), (closed, second), (lost, third) = scenarios_after(mission, mission.scenario)
    assert [wind.kind, closed.kind, lost.kind] == ["wind", "no-fly", "lost-uav"]
    assert [len(scenario.no_fly) for scenario in (first, second, third)] == [0, 1, 1]
    assert third.wind is not None
    assert third.wind([[0.0, 0.0]]).tolist() == [[5.0, 0.0]]


@pytest.mark.parametrize(
    ("event", "said"),
    [
        ({"kind": "lost-uav"}, r'\[\[replan\.event\]\] 1: kind = "lost-uav" needs uav'),
        (LOST | {"uav": 2}, r"\[\[replan\.event\]\] 1: uav must be the number of a UAV, 0 to 1, got 2"),
        (LOST | {"velocity": [1.0, 0.0]}, r'velocity is of kind = "wind", and this is kind = "lost-uav"'),
        (CLOSED | {"file": "zone.kml"}, r'kind = "no-fly" needs polygon or file, not both'),
        (CLOSED | {"polygon": ZONE[:2]}, "polygon"),
        (CLOSED | {"polygon": [[0.0, 0.0], [900.0, 0.0], [900.0, 900.0], [0.0, 900.0]]}, r"depots\[0\]"),
        ({"kind": "no-fly", "file": "none.kml"}, r"none\.kml"),
        ({"kind": "storm"}, "storm"),
        (WIND | {"time": -1.0}, "time"),
    ],
)
def test_events_that_cannot_be_are_refused(event: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        mission_of(TABLE | {"replan": {"event": [{"time": 10.0} | event]}}, Path(), "m")


def test_re_planning_that_never_comes_is_refused() -> None:
    with pytest.raises(InputError, match="every"):
        mission_of(TABLE | {"replan": {"every": 0}}, Path(), "m")


@pytest.mark.slow
def test_tours_flown_again_are_polished_and_re_planned_within_endurance(tmp_path: Path) -> None:
    laps = {"flight": {"laps": 2, "endurance": 400.0}, "place": TABLE["place"] | {"polish": True}}
    mission = mission_of(TABLE | laps | {"replan": {"every": 12}, "sensing": {"period": 15.0}}, Path(), "m")
    for stage in STAGES:
        run_mission(mission, tmp_path, only=stage)
    said = json.loads((tmp_path / "5-flight/polish.json").read_text())
    assert min(said["lengths_before"]) > 12_000.0  # two laps
    assert said["rms_sd_after"] < 0.5 * said["rms_sd_before"]  # a second lap need not be the first
    told = json.loads((tmp_path / "6-map/replans.json").read_text())
    assert any(row["accepted"] for row in told["replans"])
    flown = pd.read_csv(tmp_path / "6-map/flight-check.csv")
    assert (flown["length"] <= 400.0 * 50.0 + 1e-6).all()


def test_an_airspeed_must_be_above_the_wind_of_an_event() -> None:
    table = {key: value for key, value in TABLE.items() if key != "ground_speed"} | {"cost": "time", "airspeed": 30.0}
    with pytest.raises(InputError, match=r"a wind of 30 m/s is as strong as the airspeed of 30 m/s"):
        mission_of(table | {"replan": {"event": [WIND | {"velocity": [30.0, 0.0]}]}}, Path(), "m")
