"""Figures of tours beside an instance: each UAV at its own speed, along its own paths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import Polygon

from instances.environment.region import Region
from instances.environment.wind import Rotation
from instances.fleet import Fleet, Return
from instances.scenario import Scenario, write_scenario
from reports.figures.routes import draw_routes
from workbench.planning import plan, write_plan
from workbench.tours import planned_beside

SCENARIO = Scenario(
    "s",
    Region.rectangle(9000, 9000),
    np.array([[0.0, 0.0], [9000.0, 0.0]]),
    20.0,
    tasks=np.array([[3000.0, 4000.0], [6000.0, 4000.0]]),
    fleet=Fleet(speeds=np.array([20.0, 25.0]), service=30.0),
)

TASKS = np.array([[4500.0, 6000.0], [6000.0, 4000.0]])


def kept(scenario: Scenario, folder: Path) -> Path:
    write_scenario(scenario, folder / "s.toml")
    instance, paths = plan(scenario, "closed-form")
    write_plan(instance, paths, folder / "s.json", folder / "s.toml")
    return folder / "s.json"


def test_each_tour_is_told_at_its_own_speed(tmp_path: Path) -> None:
    instance, _ = plan(SCENARIO, "closed-form")
    first, second = planned_beside(kept(SCENARIO, tmp_path), instance).tours(instance, ((0,), (1,)))
    assert (first.length, second.length) == (pytest.approx(10_000), pytest.approx(10_000))
    assert (first.flight_time, second.flight_time) == (pytest.approx(500), pytest.approx(400))


def test_tours_that_end_elsewhere_are_not_told(tmp_path: Path) -> None:
    scenario = replace(SCENARIO, fleet=Fleet(returns=Return.NONE))
    instance, _ = plan(scenario, "closed-form")
    assert planned_beside(kept(scenario, tmp_path), instance).tours(instance, ((0,), (1,))) == []


ZONE = Polygon([(3000, 2000), (6000, 2000), (6000, 3000), (3000, 3000)])


def test_routes_are_drawn_along_planned_paths_over_the_zones_and_wind_of_their_scenario(tmp_path: Path) -> None:
    scenario = replace(SCENARIO, fleet=Fleet(), no_fly=(ZONE,), wind=Rotation(1e-3, (4500.0, 2500.0)), tasks=TASKS)
    write_scenario(scenario, tmp_path / "s.toml")
    instance, paths = plan(scenario, "dijkstra")
    write_plan(instance, paths, tmp_path / "s.json", tmp_path / "s.toml")
    found, given = planned_beside(tmp_path / "s.json", instance)
    plot = draw_routes(instance, ((0,), (1,)), found, given).axes[0]
    around = plot.lines[0].get_xydata()
    assert len(around) > 4  # not straight there and back: the zone lies between
    (region,) = plot.patches
    assert [6.0, 2.0] in region.get_path().vertices.tolist()  # a corner of the zone
    assert "wind, up to" in plot.get_title(loc="left")


def test_a_scenario_that_has_changed_is_not_drawn(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    instance, _ = plan(SCENARIO, "closed-form")
    file = kept(SCENARIO, tmp_path)
    assert planned_beside(file, instance)[1] is not None
    write_scenario(replace(SCENARIO, tasks=TASKS), tmp_path / "s.toml")
    paths, scenario = planned_beside(file, instance)
    assert paths is not None
    assert scenario is None
    assert caplog.messages == []
    (tmp_path / "s.toml").write_text("airspeed = -3\n")
    assert planned_beside(file, instance)[1] is None
    (warning,) = caplog.messages
    assert "s.toml" in warning
    assert "not told" in warning
    (tmp_path / "s.toml").unlink()
    assert planned_beside(file, instance)[1] is None
    assert planned_beside(tmp_path / "other.json", instance) == (None, None)


def test_a_tour_that_does_not_come_home_is_drawn_open(tmp_path: Path) -> None:
    scenario = replace(SCENARIO, fleet=Fleet(returns=Return.NONE))
    instance, paths = plan(scenario, "closed-form")
    line = draw_routes(instance, ((0,), (1,)), paths, scenario).axes[0].lines[0].get_xydata()
    assert line[-1].tolist() == [3.0, 4.0]
