"""`workbench place --polish`: a random small mission with a zone, kept within what is allowed, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
import shapely

from formulations.mapping.flight import plan_flight
from tests.workbench.mission.small import SMALL, ZONE

AREA = shapely.geometry.shape(ZONE)
RADIUS = 50.0


@pytest.fixture
def mission(tmp_path):
    rng = np.random.default_rng(7)
    tasks = [p for p in rng.uniform([300, 300], [5700, 4700], (12, 2)) if AREA.distance(shapely.Point(p)) > 250][:6]
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE))

    def write(more=""):
        text = SMALL.replace("tasks = 8", f"tasks = {[p.round(1).tolist() for p in tasks]}")
        text = text.replace("origin = [47.0, 8.0]", more)
        (tmp_path / "m.toml").write_text(text)
        return "m.toml"

    return write


def test_less_stays_unknown_within_budget_radius_and_borders(cli, mission, tmp_path):
    code, out, err = cli("place", "--polish", mission(), "--out", "w.csv", "--json")
    assert code == 0, err
    said = json.loads(out)
    assert said["bound"] <= said["rms_sd_after"] < said["rms_sd_before"]
    assert (np.array(said["costs_after"]) <= said["budgets"]).all()
    assert pd.read_csv(tmp_path / "w.csv").to_dict("records") == said["waypoints"]
    for uav, path in pd.DataFrame(said["waypoints"]).groupby("uav"):
        points = path[["x", "y"]].to_numpy()
        flight = plan_flight([points], speed=50.0, radius=RADIUS)
        track = flight.poses(np.linspace(0, flight.length, 4000))
        turned = np.abs(np.angle(np.exp(1j * np.diff(track[:, 2]))))
        assert (turned <= 1.001 * flight.length / 3999 / RADIUS).all()
        line = shapely.linestrings(track[:, :2])
        assert shapely.box(-0.1, -0.1, 6000.1, 5000.1).covers(line)
        assert shapely.intersection(line, AREA.buffer(-0.1)).is_empty
        assert flight.length == pytest.approx(said["lengths_after"][int(str(uav))], rel=0.01)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("place --polish", "place --polish: needs a scenario or mission file (.toml), got none"),
        ("place --polish m.toml --tasks 4", "--tasks: cannot be given with --polish"),
        ("place --polish m.toml --out w.geojson", "origin: is not given, so w.geojson cannot be in degrees"),
    ],
)
def test_what_does_not_go_together_is_refused(cli, mission, words, sentence):
    mission()
    code, _, err = cli(*words.split())
    assert code == 2
    assert sentence in err


def test_waypoints_of_two_laps_in_degrees(cli, mission, tmp_path):
    laps = mission("origin = [47.0, 8.0]\nflight.laps = 2")
    code, out, err = cli("place", "--polish", laps, "--out", "w.geojson", "--json")
    assert code == 0, err
    said = json.loads(out)
    assert min(said["lengths_before"]) > 10_000
    assert said["rms_sd_after"] < said["rms_sd_before"]
    lines = json.loads((tmp_path / "w.geojson").read_text())["features"]
    assert [line["properties"]["uav"] for line in lines] == [0, 1]
    assert np.abs(np.array(lines[0]["geometry"]["coordinates"][0]) - [8.0, 47.0]).max() < 0.1
