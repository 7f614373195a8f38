"""Missions that could hurt someone are refused in a sentence that says who, where, by how much and why."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon, box

from formulations.mapping.flight import Flight, plan_flight
from formulations.mapping.heights import Frame, heights_of
from instances import Instance
from instances.environment.region import Region
from instances.environment.terrain import Terrain, read_terrain
from instances.errors import InputError
from instances.scenario import Scenario
from workbench.mission import environment, place
from workbench.mission.file import mission_of
from workbench.mission.safety import refuse_beyond_borders, refuse_near_ground
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


def test_planning_keeps_room_for_turns_off_the_inlets_of_a_region() -> None:
    angle = np.linspace(0.0, -np.pi, 60)
    arc = np.column_stack([2000.0 + 1000.0 * np.cos(angle), 4000.0 + 1000.0 * np.sin(angle)])
    region = Region(Polygon([(0, 0), (4000, 0), (4000, 4000), *arc, (0, 4000)]))
    free = place.widened(Scenario("s", region, [[500, 500]], 50.0, n_tasks=3), 100.0).free
    assert free.polygon.exterior.distance(shapely.Point(2000.0, 4000.0)) == pytest.approx(1100.0, rel=0.01)
    assert free.contains([[2000.0, 5.0], [5.0, 2000.0]]).all()  # straight borders are left as they are
    shallow = Region(Polygon([(0, 0), (4000, 0), (4000, 3000), (2000, 2995), (0, 3000)]))
    assert place.inlets(shallow, 100.0) == []


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


def level_over(altitude: float, ridge: float, **flight: Any) -> None:
    """Fly out 3 km and back over a ridge half way, and refuse what is too near to it."""
    mission = mission_with(flight={"altitude": altitude, **flight})
    height = np.zeros((4, 5))
    height[:, 2] = ridge
    ground = Terrain((0.0, 0.0), (1000.0, 1000.0), height)
    ends = np.array([[500.0, 1500.0], [3500.0, 1500.0]])
    flown: Flight = plan_flight([ends, ends[::-1]], speed=50.0, radius=50.0)
    refuse_near_ground(mission, [flown], {0: heights_of(flown, mission.altitude, ground)})


@pytest.mark.parametrize(
    ("altitude", "ridge", "words"),
    [
        (
            300.0,
            2000.0,
            r"^UAV 0 would fly (1699|1700)\.\d m below the ground at \[(19|20)\d\d\.\d, 1[45]\d\d\.\d\], where the gr",
        ),
        (300.0, 280.0, r"^UAV 0 would come within 20\.\d m of the ground at .* \(flight\.clearance = 50 m\)"),
        (
            10.0,
            0.0,
            r"within 10\.0 m of the ground .*, where the ground is 0\.0 m and the track 10\.0 m above mean sea",
        ),
    ],
)
def test_tracks_too_near_to_the_ground_are_refused(altitude: float, ridge: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        level_over(altitude, ridge)


def test_tracks_with_the_clearance_are_flown() -> None:
    level_over(300.0, 240.0)
    level_over(300.0, 280.0, clearance=15.0)
    level_over(120.0, 2000.0, frame="above-ground")


def test_frames_and_clearances_that_do_not_fit() -> None:
    with pytest.raises(InputError, match=r"\[flight\] frame must be one of 'amsl', 'above-ground', 'above-home'"):
        mission_with(flight={"frame": "agl"})
    with pytest.raises(
        InputError, match=r"flight\.altitude = 30 m above the ground is less than flight\.clearance = 50"
    ):
        mission_with(flight={"frame": "above-ground", "altitude": 30.0})
    with pytest.raises(InputError, match=r'flight\.frame = "above-ground" without terrain: plans for ground control'):
        mission_with(flight={"frame": "above-ground"}, origin=[47.0, 8.0])
    assert mission_with(flight={"frame": "above-home"}, origin=[47.0, 8.0]).altitude.frame is Frame.ABOVE_HOME


def ground_of(cells: tuple[int, int], size: float) -> Terrain:
    return Terrain((0.0, 0.0), (size, size), np.zeros(cells), "dem.tif")


def test_an_elevation_model_smaller_than_the_region() -> None:
    region = (0.0, 0.0, 4000.0, 3000.0)
    environment.refuse_part_of_region(ground_of((31, 41), 100.0), region)
    environment.refuse_part_of_region(Terrain((50.0, 50.0), (100.0, 100.0), np.zeros((30, 40))), region)  # cell centres
    with pytest.raises(
        InputError, match=r"^terrain dem\.tif covers \(0, 0\) to \(3900, 3000\) m and not all of the reg"
    ):
        environment.refuse_part_of_region(ground_of((31, 40), 100.0), region)


def test_an_elevation_model_with_a_hole_in_the_region(tmp_path: Path) -> None:
    rows = "\n".join(["0 0 0 0", "0 -9999 0 0", "0 0 0 0"])
    (tmp_path / "dem.asc").write_text(f"ncols 4\nnrows 3\nxllcenter 0\nyllcenter 0\ncellsize 1000\n{rows}\n")
    with pytest.raises(InputError, match=r"dem\.asc: 1 of 12 values are missing .*, first at \(1000, 1000\) m"):
        read_terrain(tmp_path / "dem.asc")


def test_what_holds_at_another_height_than_the_flight_is_said() -> None:
    wind = {"kind": "terrain", "mountains": {"seed": 0}, "velocity": [1.0, 2.0], "altitude": 3000.0}
    said = environment.differing_heights(mission_with(wind=wind, flight={"frame": "above-ground", "altitude": 120.0}))
    assert said[0] == "the wind is that at 3000 m above mean sea level, the flight at 120 m above the ground"
    assert said[1].startswith("the signal is that at 120 m above the ground; tracks rise above it")
    assert environment.differing_heights(mission_with(wind=wind, flight={"altitude": 3000.0})) == []


def test_the_signal_above_the_ground_is_that_at_the_height_flown() -> None:
    field = {"model": "free-space", "shadowing_sd": 0, "cells": 20}
    plateau = Terrain((0.0, 0.0), (4000.0, 3000.0), np.full((2, 2), 700.0))
    above = mission_with(field=field, flight={"frame": "above-ground", "altitude": 120.0})
    home = mission_with(field=field, flight={"frame": "above-home", "altitude": 120.0})
    level = mission_with(field=field, flight={"altitude": 820.0})
    values = [environment.field_of(each, plateau).values for each in (above, home, level)]
    np.testing.assert_allclose(values[0], values[2])
    np.testing.assert_array_equal(values[1], values[2])
