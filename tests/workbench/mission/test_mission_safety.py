"""Missions that could hurt someone are refused in a sentence that says who, where, by how much and why."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from formulations.mapping.flight import plan_flight
from instances import Instance
from instances.environment.region import Region
from instances.errors import InputError
from instances.scenario import Scenario
from workbench.mission import place
from workbench.mission.file import mission_of
from workbench.mission.safety import refuse_beyond_borders
from workbench.mission.settings import Mission

TABLE: dict[str, Any] = {
    "airspeed": 50.0,
    "size": [4000, 3000],
    "depots": [[500, 500]],
    "tasks": [[2000, 2500], [3000, 1000]],
    "radio": {"position": [2000, 1500]},
}


def mission_with(**changes: Any) -> Mission:
    return mission_of(TABLE | changes, Path(), "m")


def refuse(mission: Mission, scenario: Scenario | None = None) -> None:
    """Fly straight legs from task to task, and refuse."""
    scenario = scenario or mission.scenario
    points = scenario.points
    corners = [points[-1], *points[:-1], points[-1]]
    flight = plan_flight([np.array(corners[k : k + 2]) for k in range(len(corners) - 1)], speed=50.0, radius=50.0)
    n = len(points)
    instance = Instance("m", np.ones((n, n)) - np.eye(n), n - 1, 1, coordinates=points)
    refuse_beyond_borders(mission, scenario, instance, [list(range(n - 1))], [flight])


def test_a_flight_with_room_is_not_refused() -> None:
    refuse(mission_with())
    refuse(mission_with(flight={"border_clearance": 350.0}))


def test_a_task_near_the_border_is_named() -> None:
    sentence = (
        r"^UAV 0 would fly up to [\d.]+ m beyond the region's border or into a no-fly zone at \[[\d.]+, 30\d\d\.\d\]: "
        r"tasks\[0\] at \[2000\.0, 2999\.9\] stands 0\.1 m from it, and a turn of flight\.turning_radius = 50 m takes "
        r"up to 100 m$"
    )
    with pytest.raises(InputError, match=sentence):
        refuse(mission_with(tasks=[[2000, 2999.9], [3000, 1000]]))


def test_a_depot_near_the_border_is_named() -> None:
    with pytest.raises(InputError, match=r"depots\[0\] at \[3\.0, 500\.0\] stands 3\.0 m from it"):
        refuse(mission_with(depots=[[3, 500]]))


def test_a_border_clearance_that_is_not_kept_is_said() -> None:
    sentence = r"UAV 0 would come within 4\d\d\.\d m of .* \(flight\.border_clearance = 600 m\): depots\[0\]"
    with pytest.raises(InputError, match=sentence):
        refuse(mission_with(flight={"border_clearance": 600.0}))


def test_a_zone_at_the_border_is_not_entered() -> None:
    zone = box(2900, 1800, 4000, 3000)  # in the corner; the leg between the tasks cuts it
    region = Region(box(0, 0, 4000, 3000))
    scenario = Scenario("s", region, [[500, 500]], 50.0, tasks=[[2000, 2500], [3500, 1000]], no_fly=[zone])
    refuse(mission_with(), scenario)
    across = Scenario("s", region, [[500, 500]], 50.0, tasks=[[2500, 2500], [3500, 1500]], no_fly=[zone])
    with pytest.raises(InputError, match=r"UAV 0 would fly up to [\d.]+ m beyond the region's border or into a no-fly"):
        refuse(mission_with(), across)


def test_planning_keeps_room_for_turns_beside_the_clearance() -> None:
    assert mission_with().clearance == 100.0
    assert mission_with(flight={"border_clearance": 30.0}).clearance == 130.0
    assert mission_with(flight={"border_clearance": 30.0}, costs={"clearance": 20.0}).clearance == 50.0


def test_tasks_are_kept_off_the_border_but_not_off_zones_inside() -> None:
    hole = [[1000, 1000], [1100, 1000], [1100, 1100], [1000, 1100]]
    whole = Region(Polygon([(0, 0), (2000, 0), (2000, 2000), (0, 2000)], [hole]))
    inner = place.kept_off(whole, whole, 100.0)
    assert inner is not None
    assert inner.bounds == (100.0, 100.0, 1900.0, 1900.0)
    assert inner.contains([[999.0, 1050.0]])[0]
    assert place.kept_off(whole, whole, 1000.0) is None


@pytest.mark.parametrize("criterion", ["b", "ig"])
def test_placed_tasks_leave_room_for_turns(tmp_path: Path, monkeypatch, criterion: str) -> None:
    mission = mission_with(
        tasks=6,
        place={"method": "greedy", "criterion": criterion, "tests": [6, 6], "length_scale": 800, "certificate": False},
    )
    monkeypatch.setattr(place, "kept_scenario", lambda folder: mission.scenario)
    told: list[str] = []
    place.make(mission, {"environment": tmp_path}, tmp_path, told.append)
    room = mission.scenario.region.signed_distance(place.kept_tasks(tmp_path))
    assert room.min() >= 100.0 - 1e-6
    assert any("leave no room for turns" in words for words in told) == (criterion == "ig")
