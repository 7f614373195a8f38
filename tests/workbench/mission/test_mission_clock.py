"""Missions in a wind that changes: planned, flown and checked by the clock; what they cannot do is named."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from formulations.mapping.flight import Flight
from instances import InputError, tour_costs
from instances.environment.region import Region
from instances.environment.wind_changing import ChangingWind, Turning
from instances.environment.wind_forecast import Forecast, sampled
from instances.files import read_instance, read_routes
from instances.scenario import scenario_of
from workbench.mission.clock import refuse_beyond_endurance, refuse_wrong_clocks
from workbench.mission.file import mission_of
from workbench.mission.flight import kept_flights
from workbench.mission.pipeline import run_mission

CLOCKED = """
cost = "time"
airspeed = 20.0
size = [6000, 5000]
no_fly = "zones.json"
depots = [[500, 500], [5500, 500]]
tasks = [[900, 3900], [2100, 1200], [3200, 4400], [4400, 2200], [5200, 4300], [1500, 2600]]

[wind]
kind = "grid"
file = "wind.nc"

[radio]
position = [3000, 2500]

[field]
model = "free-space"
shadowing_sd = 2.0
cells = 30

[place]
length_scale = 1500.0
certificate = false

[costs]
options = { samples = 150 }

[routes]
solver = "subset-dp"
time_limit = 5.0
bound_time_limit = 0.0

[sensing]
period = 20.0

[map]
length_scale = 1500.0
refit_every = 50
cells = 20
frames = 4

[compare]
baselines = []
seeds = 1
"""
FRONT = {
    "kind": "front",
    "before": [-6.0, -3.0],
    "after": [7.0, 4.0],
    "speed": 12.0,
    "position": -1000.0,
    "width": 800.0,
}
ZONE = {"type": "Polygon", "coordinates": [[[2600, 1800], [3400, 1800], [3400, 3000], [2600, 3000], [2600, 1800]]]}


def write_wind(folder: Path, last: float = 400.0) -> None:
    table = {"cost": "time", "airspeed": 20.0, "size": [6000, 5000], "depots": [[1, 1]], "tasks": 1, "wind": FRONT}
    scenario = scenario_of(table, folder, "s")
    assert isinstance(scenario.wind, ChangingWind)
    sampled(scenario.wind, scenario.region, np.arange(0.0, last + 1.0, 50.0), 24).write(folder / "wind.nc")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("xarray")
    folder = tmp_path_factory.mktemp("clocked")
    write_wind(folder)
    (folder / "zones.json").write_text(json.dumps(ZONE))
    return folder


@pytest.fixture(scope="module")
def made(folder: Path) -> tuple[Path, list[str]]:
    told: list[str] = []
    run_mission(mission_of(tomllib.loads(CLOCKED), folder, "clocked"), folder / "out", tell=told.append)
    return folder / "out", told


@pytest.mark.slow
def test_flights_keep_the_clock_that_they_were_planned_by(made: tuple[Path, list[str]]) -> None:
    out, told = made
    instance = read_instance(out / "3-costs/instance.json")
    assert instance.axes == {"time"}
    costs = tour_costs(instance, read_routes(out / "4-routes/routes.sol", instance))
    flown = pd.read_csv(out / "5-flight/flight-check.csv")
    assert (flown["duration"] / costs).between(0.97, 1.06).all(), "but for turns"
    assert (flown[["in_no_fly", "outside"]] == 0.0).all(axis=None)
    assert pd.read_csv(out / "4-routes/tours.csv")["flight_time"].to_numpy() == pytest.approx(costs, rel=0.02)
    assert any("clocks of two integrations within" in line and "its last frame is held" in line for line in told)


@pytest.mark.slow
def test_the_page_says_what_the_clock_is_worth(made: tuple[Path, list[str]]) -> None:
    out, _ = made
    said = json.loads((out / "7-compare/static.json").read_text())
    assert said["clocked"] <= said["directed"] * (1 + 1e-9)
    assert said["directed"] <= said["taken"]
    page = (out / "report.html").read_text()
    for words in (
        "What planning by the clock is worth",
        "The forecast ends 400 s after take-off",
        "wind at that moment",
    ):
        assert words in page
    assert page.count('class="wind"') == 2
    assert "Wins, draws and losses" not in page, "nothing else is flown"
    assert not (out / "7-compare/calm.csv").exists()


@pytest.mark.slow
def test_routes_are_chosen_by_their_risk_over_the_members(folder: Path, tmp_path: Path) -> None:
    """Judged anew along the same paths; the page says what they take over the members, and what others would."""
    members = []
    for name, turning in (("left.nc", 90.0), ("right.nc", -90.0)):
        wind = Turning((-7.0, 3.0), np.radians(turning) / 3600)
        sampled(wind, Region.rectangle(6000, 5000), np.arange(0.0, 801.0, 100.0), 4).write(folder / name)
        members.append(name)
    text = CLOCKED.replace('file = "wind.nc"', f'file = "wind.nc"\nmembers = {json.dumps(members)}')
    text = text.replace('solver = "subset-dp"', 'solver = "memetic"\nrisk = "worst"')
    run_mission(mission_of(tomllib.loads(text), folder, "risky"), tmp_path / "out")
    said = json.loads((tmp_path / "out/4-routes/ensemble.json").read_text())
    assert said["risk"] == "worst"
    assert said["worst"] == max(said["members"]) <= said["without"]["worst"]
    assert said["planned"] >= said["without"]["planned"] * (1 - 1e-9)
    page = (tmp_path / "out/report.html").read_text()
    assert "The routes were chosen by the worst; chosen by the forecast planned with alone" in page
    assert f"{said['without']['worst']:.1f} s" in page


@pytest.mark.slow
def test_wrong_clocks_and_flights_beyond_endurance_are_refused(made: tuple[Path, list[str]], folder: Path) -> None:
    scenario = mission_of(tomllib.loads(CLOCKED), folder, "clocked").scenario
    assert isinstance(scenario.wind, Forecast)
    flights = kept_flights(made[0] / "5-flight")
    assert refuse_wrong_clocks(scenario, flights) < 1e-3
    first = flights[0]
    assert first.clock is not None
    late = Flight(first.starts, first.words, first.segments, first.radius, first.speed, 1.01 * first.clock)
    with pytest.raises(RuntimeError, match="refutes the clock of UAV 0"):
        refuse_wrong_clocks(scenario, [late])
    with pytest.raises(InputError, match=r"UAV 1 would fly .* s, turns included, and its endurance is 100.0 s"):
        refuse_beyond_endurance(flights, np.array([np.inf, 100.0]))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('solver = "subset-dp"', 'solver = "circuit"'), "routes.solver: circuit cannot take costs that change"),
        (
            ("[compare]", "[replan]\nevery = 5\n[compare]"),
            r"\[replan\]: plans change in flight only in a wind that stays",
        ),
        (("[place]", "[place]\npolish = true"), "place.polish: paths are polished only in a wind that stays"),
        (("[compare]", "[flight]\nlaps = 2\n[compare]"), "flight.laps: tours are flown more than once only"),
        (("[compare]", "[flight]\nspeed = 25.0\n[compare]"), "flight.speed: another than the airspeed"),
        (("[costs]", '[costs]\nmethod = "mine:Own"'), "costs.method: mine:Own plans only in a wind that stays"),
        (('cost = "time"', 'cost = "energy"'), "energy is no clock"),
        (("[routes]", '[routes]\nrisk = "cvar"'), "routes.risk: cvar is over an ensemble of forecasts"),
        (('cost = "time"', 'cost = "time"\nwindow = 60'), "window: all UAVs of a mission take off at once"),
    ],
)
def test_what_needs_a_wind_that_stays(change: tuple[str, str], words: str, folder: Path) -> None:
    with pytest.raises(InputError, match=words):
        mission_of(tomllib.loads(CLOCKED.replace(*change)), folder, "clocked")
