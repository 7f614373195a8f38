"""Exported tours: their waypoints keep an autopilot that climbs evenly on the track."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import LineString

from formulations.mapping.flight import plan_flight
from formulations.mapping.heights import Altitude, Frame, Heights, heights_of
from formulations.mapping.planned import planned_flight
from formulations.moving_cost.turns.travel import Turns
from instances.environment.terrain import Terrain
from workbench.mission.export import STRAY, tour_of

STOPS = np.array([[0.0, 0.0], [4000.0, 0.0], [4000.0, 3000.0]])
FLIGHT = plan_flight([np.array([STOPS[k], STOPS[(k + 1) % 3]]) for k in range(3)], radius=50.0)
TASKS = {7: STOPS[1], 2: STOPS[2]}
LEVEL = Altitude(900.0, Frame.AMSL, 0.1, 0.1)


def test_a_level_tour_has_a_waypoint_a_leg_and_the_ground_below() -> None:
    slope = Terrain((-1000.0, -1000.0), (6000.0, 6000.0), np.array([[0.0, 600.0], [0.0, 600.0]]))
    tour = tour_of("a", FLIGHT, heights_of(FLIGHT, LEVEL, slope), TASKS, known=True)
    np.testing.assert_allclose(tour.points, FLIGHT.starts[:, :2], atol=1e-6)
    assert set(tour.heights) == {900.0}
    assert tour.ground is not None
    np.testing.assert_allclose(tour.ground, 100.0 + 0.1 * tour.points[:, 0], atol=0.5)
    for task, place in TASKS.items():
        np.testing.assert_allclose(tour.points[tour.tasks.index(task)], place, atol=0.2)


def test_ground_that_is_not_known_stays_so() -> None:
    assert tour_of("a", FLIGHT, heights_of(FLIGHT, LEVEL, None), TASKS, known=False).ground is None


def test_waypoints_follow_a_track_over_a_hill() -> None:
    s = np.arange(0.0, FLIGHT.length, 1.0)
    track = 300.0 + 200.0 * np.exp(-(((s - 2000.0) / 500.0) ** 2))
    tour = tour_of("a", FLIGHT, Heights(s, track, 0 * s), TASKS, known=True)
    assert len(FLIGHT.starts) < len(tour.points) < 60
    poses = FLIGHT.poses(s)[:, :2]
    travelled = s[[int(np.argmin(np.hypot(*(poses - point).T))) for point in tour.points[1:]]]
    evenly = np.interp(s, [0.0, *travelled, FLIGHT.length], [*tour.heights, tour.heights[0]])
    off = evenly - track
    assert off.max() < STRAY + 0.2  # places are found on the track to 0.5 m, where it rises by 0.35 a metre
    assert off.min() > -0.2
    assert sorted(task for task in tour.tasks if task is not None) == [2, 7]


def test_a_tour_comes_home_as_high_as_its_track() -> None:
    s = np.array([0.0, 1000.0, FLIGHT.length])
    tour = tour_of("a", FLIGHT, Heights(s, np.array([300.0, 300.0, 420.0]), 0 * s), TASKS, known=True)
    assert tour.heights[0] == pytest.approx(420.0, abs=STRAY)
    assert tour.heights[1:].max() < 420.0


def test_waypoints_along_turns_keep_lines_between_them_near_the_track() -> None:
    turns = Turns(100.0, 20.0, (5.0, -3.0))
    places = np.array([[0.0, 0.0], [350.0, 0.0], [300.0, 250.0], [0.0, 0.0]])
    flight, _ = planned_flight(places, np.array([0.0, 2.0, 4.0, 1.0]), turns)
    tasks = {0: places[1], 1: places[2]}
    tour = tour_of("a", flight, heights_of(flight, LEVEL, None), tasks, known=False, turns=True)
    track = LineString(flight.poses(np.linspace(0.0, flight.length, 2000))[:, :2])
    off = LineString([*tour.points, places[-1]]).hausdorff_distance(track)
    assert off < 100.0 * (1 - np.cos(np.pi / 8)) + 0.1
    assert len(tour.points) > 2 * len(flight.starts)
    for task, place in tasks.items():
        np.testing.assert_allclose(tour.points[tour.tasks.index(task)], place, atol=1e-3)
