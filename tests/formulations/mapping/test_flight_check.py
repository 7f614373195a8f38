"""The flight check finds what is wrong, and flights round a corner stay as near to it as is said."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from shapely.geometry import box

from formulations.mapping.flight import STRAY_RADII, plan_flight
from formulations.mapping.flight_check import check_flight, length_outside, margin
from instances.environment.region import Region

SQUARE = np.array([[0.0, 0.0], [8e3, 0.0], [8e3, 8e3], [0.0, 8e3], [0.0, 0.0]])
LEGS = [SQUARE[k : k + 2] for k in range(4)]
AROUND = Region(box(-500.0, -500.0, 8500.0, 8500.0))


def test_a_good_flight() -> None:
    check = check_flight(plan_flight(LEGS, radius=100.0), LEGS, SQUARE[:4], AROUND, step=0.5)
    assert check.reference_length == pytest.approx(32e3)
    assert check.task_distance <= 1e-3
    assert check.least_radius == pytest.approx(100.0, rel=1e-6)
    assert check.closure <= 1e-6
    assert check.deviation < 200.0
    assert (check.in_no_fly, check.outside) == (0.0, 0.0)
    assert 300.0 < check.margin < 500.0  # turns swing out by less than twice the radius


def test_a_task_off_the_tour_a_zone_on_it_and_a_lie_about_the_radius_are_found() -> None:
    flight = plan_flight(LEGS, radius=100.0)
    check = check_flight(flight, LEGS, [[4e3, 3e3]], AROUND, [box(3e3, -500.0, 4e3, 500.0)])
    assert check.task_distance == pytest.approx(3e3, abs=60.0)  # it swings out after the corner
    assert check.in_no_fly == pytest.approx(1e3, abs=3.0)
    # the same words and lengths flown with half the radius: turns are twice as tight and it ends elsewhere
    tight = check_flight(dataclasses.replace(flight, radius=50.0), LEGS, SQUARE[:4], AROUND)
    assert tight.least_radius <= 50.5
    assert tight.closure > 1000.0


def test_a_uav_that_stays_home_has_nothing_wrong() -> None:
    check = check_flight(plan_flight([]), [], np.empty((0, 2)), AROUND)
    assert (check.length, check.task_distance, check.in_no_fly) == (0.0, 0.0, 0.0)


def test_a_reference_path_round_an_obstacle_is_followed() -> None:
    angle = np.linspace(np.pi, 0.0, 60)
    arc = np.column_stack([1500.0 * np.cos(angle), 1500.0 * np.sin(angle)])
    legs = [np.concatenate([[[-6e3, 0.0]], arc, [[6e3, 0.0]]]), np.array([[6e3, 0.0], [0.0, -5e3]])]
    legs.append(np.array([[0.0, -5e3], [-6e3, 0.0]]))
    flight = plan_flight(legs, radius=50.0)
    poses = flight.poses(np.arange(0.0, flight.length, 5.0))
    upper = (poses[:, 1] > 100.0) & (np.abs(poses[:, 0]) < 1400.0)
    assert upper.any()
    # Douglas & Peucker's tolerance, and what turning onto the next chord takes
    assert np.abs(np.hypot(*poses[upper, :2].T) - 1500.0).max() <= 2 * STRAY_RADII * 50.0


def test_the_length_outside_a_region_is_that_of_all_flights() -> None:
    flight = plan_flight(LEGS, radius=100.0)
    assert length_outside([flight, plan_flight([])], Region(box(-500, -500, 9e3, 9e3))) == 0.0
    western_half = Region(box(-500, -500, 4e3, 9e3))
    assert length_outside([flight, flight], western_half) == pytest.approx(2 * 16e3, rel=0.01)


def test_turns_that_bulge_out_of_the_region_are_found_with_depth_and_place() -> None:
    flight = plan_flight(LEGS, radius=100.0)
    check = check_flight(flight, LEGS, SQUARE[:4], Region(box(-10.0, -10.0, 8010.0, 8010.0)))
    assert check.outside > 50.0
    found = margin(flight, Region(box(-10.0, -10.0, 8010.0, 8010.0)))
    assert found.distance == check.margin < -5.0
    assert min(np.abs(np.array(found.place) - corner).max() for corner in SQUARE) < 1000.0


def test_the_margin_is_to_zones_too() -> None:
    flight = plan_flight(LEGS, radius=100.0)
    near, across = box(3e3, 40.0, 4e3, 500.0), box(3e3, -500.0, 4e3, 500.0)
    assert margin(flight, AROUND, [near]).distance == pytest.approx(40.0, abs=60.0)  # it swings out
    found = margin(flight, AROUND, [across])
    assert found.distance == pytest.approx(-500.0, abs=60.0)
    assert 3e3 <= found.place[0] <= 4e3
