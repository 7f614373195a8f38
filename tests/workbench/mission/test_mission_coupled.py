"""Missions whose routes and headings are planned together: what is planned is flown, and nothing leaves the region."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from formulations.mapping.flight import Flight
from instances.errors import InputError
from workbench.mission.file import mission_of
from workbench.mission.fitting import check_mission
from workbench.mission.pipeline import run_mission

TABLE: dict[str, Any] = {
    "cost": "time",
    "airspeed": 25.0,
    "size": [1600, 1400],
    "depots": [[200, 200], [1400, 200]],
    "tasks": [[300, 900], [520, 1000], [700, 700], [1200, 900], [1300, 600], [1000, 450]],
    "wind": {"kind": "uniform", "velocity": [6.0, 3.0]},
    "radio": {"position": [800, 700]},
    "field": {"model": "free-space", "cells": 20},
    "place": {"tests": [6, 6], "length_scale": 400.0},
    "costs": {"method": "closed-form"},
    "routes": {"solver": "subset-dp", "time_limit": 20.0, "bound_time_limit": 0.5},
    "map": {"length_scale": 400.0, "cells": 12},
    "sensing": {"period": 2.0},
    "flight": {"turning_radius": 120.0, "coupled": True},
}


def changed(**changes: Any) -> dict[str, Any]:
    return TABLE | changes


def made(table: dict[str, Any], out: Path) -> dict[str, Path]:
    """Make the stages up to the flight; return their folders."""
    mission = mission_of(table, Path(), "m")
    for stage in ("environment", "place", "costs", "routes", "flight"):
        run_mission(mission, out, only=stage)
    return {folder.name.partition("-")[2]: folder for folder in out.iterdir() if folder.is_dir()}


def test_the_mission_flies_the_headings_that_were_planned(tmp_path: Path) -> None:
    folders = made(TABLE, tmp_path)
    plan = json.loads((folders["routes"] / "headings.json").read_text())
    check = pd.read_csv(folders["flight"] / "flight-check.csv")
    assert check["duration"].to_numpy() == pytest.approx(plan["times"], rel=1e-12)
    bound = json.loads((folders["routes"] / "bound.json").read_text())
    assert bound["bound"] <= bound["objective"] == pytest.approx(max(plan["times"]))
    assert bound["objective"] == min(plan["longest"].values())
    assert check["least_radius"].min() >= 120.0 * (1 - 1e-9)
    assert check["task_distance"].max() < 0.02
    assert check["closure"].max() < 1e-6
    assert (check["outside"] == 0).all()
    # the wind triangle along the track, which no planner of headings made, agrees on the time
    tours = pd.read_csv(folders["routes"] / "tours.csv")
    assert tours["flight_time"].to_numpy() == pytest.approx(plan["times"], rel=1e-4)
    flights = [Flight.from_json(each) for each in json.loads((folders["flight"] / "flights.json").read_text())]
    for flight, own in zip(flights, plan["headings"], strict=True):
        assert flight.wind == (6.0, 3.0)
        assert flight.starts[:, 2] == pytest.approx(own[:-1])
        moved = np.diff(flight.poses(np.linspace(0, flight.length, 2000))[:, :2], axis=0)
        assert np.hypot(*moved.T).max() <= flight.fastest * flight.duration / 1999 * (1 + 1e-9)
    spacing = json.loads((folders["flight"] / "spacing.json").read_text())
    assert spacing["ratio"] == pytest.approx((1600 * 1400 / 6) ** 0.5 / 120)
    assert spacing["coupled"]


@pytest.mark.slow
def test_no_leg_enters_a_zone_and_what_cannot_be_flown_is_refused(tmp_path: Path) -> None:
    corners = [[620, 420], [980, 420], [980, 980], [620, 980], [620, 420]]
    (tmp_path / "zone.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [corners]}))
    table = {key: value for key, value in TABLE.items() if key != "wind"}
    table |= {
        "no_fly": str(tmp_path / "zone.geojson"),
        "crs": "local",
        "costs": {"method": "refined", "clearance": 0.0},
    }
    table["tasks"] = [[300, 900], [450, 1100], [1200, 1150], [1300, 600], [1150, 300], [800, 1200]]
    table["flight"] = {"turning_radius": 120.0, "coupled": True, "border_clearance": 20.0}
    check = pd.read_csv(made(table, tmp_path / "out")["flight"] / "flight-check.csv")
    assert (check["in_no_fly"] == 0).all()
    assert check["margin"].min() >= 20.0 - 0.02
    table["tasks"] = [[1590, 1390], *table["tasks"][1:]]  # no turn out of this corner stays inside
    with pytest.raises(InputError, match=r"found no routes whose Dubins legs"):
        made(table, tmp_path / "refused")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"cost": "energy", "ground_speed": 25.0}, "flight.coupled: cost = 'energy' in wind"),
        ({"wind": {"kind": "rotation", "rate": 1e-3, "centre": [800, 700]}}, "calm air and in a uniform wind"),
        ({"routes": {"solver": "greedy"}}, "'greedy' takes no states; memetic and subset-dp do"),
        ({"flight": TABLE["flight"] | {"laps": 2}}, "leave flight.laps out"),
        ({"flight": TABLE["flight"] | {"endurance": 900.0}}, "leave flight.endurance out"),
        ({"replan": {"every": 10}}, r"leave \[replan\] out"),
    ],
)
def test_what_headings_are_not_planned_for_is_refused(changes: dict[str, Any], words: str) -> None:
    table = changed(**changes)
    if "ground_speed" in changes:
        del table["airspeed"]
    with pytest.raises(InputError, match=words):
        check_mission(mission_of(table, Path(), "m"))
