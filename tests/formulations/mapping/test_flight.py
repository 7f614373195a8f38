"""Flights: closed, within the turning radius, over every task, measured on time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.mapping.flight import Flight, plan_flight, reference_waypoints
from instances import InputError


def straight_legs(stops: np.ndarray) -> list[np.ndarray]:
    return [np.array([stops[k], stops[(k + 1) % len(stops)]]) for k in range(len(stops))]


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10_000), st.integers(1, 8), st.floats(200.0, 20_000.0))
def test_a_flight_is_closed_keeps_the_radius_and_passes_over_every_task(seed: int, count: int, size: float) -> None:
    stops = np.random.default_rng(seed).uniform(0, size, (count, 2))
    flight = plan_flight(straight_legs(stops), radius=50.0)
    step = 1.0
    poses = flight.poses(np.arange(0.0, flight.length, step))
    turns = np.abs((np.diff(poses[:, 2]) + math.pi) % (2 * math.pi) - math.pi)
    assert (turns <= step / 50.0 + 1e-9).all()
    moves = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert (moves <= step + 1e-9).all()
    end = flight.poses([flight.length])[0]
    np.testing.assert_allclose(end[:2], flight.starts[0, :2], atol=1e-6)
    assert math.cos(end[2] - flight.starts[0, 2]) == pytest.approx(1.0, abs=1e-9)
    if len(flight.starts) > 1:
        for stop in stops:
            assert np.hypot(*(poses[:, :2] - stop).T).min() <= step


def test_a_wide_square_is_flown_at_hardly_more_than_its_length() -> None:
    corners = np.array([[0.0, 0.0], [10e3, 0.0], [10e3, 10e3], [0.0, 10e3]])
    flight = plan_flight(straight_legs(corners), radius=50.0)
    assert 40e3 - 4 * (2 - math.pi / 2) * 50.0 <= flight.length <= 40e3 * 1.005


def test_waypoints_follow_a_bent_reference_path() -> None:
    angle = np.linspace(0, math.pi, 400)
    arc = 5000.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    flight = plan_flight([arc, arc[::-1][[0, -1]]], radius=50.0)
    poses = flight.poses(np.linspace(0.0, flight.length, 5000))
    upper = poses[poses[:, 1] > 500.0]
    np.testing.assert_allclose(np.hypot(upper[:, 0], upper[:, 1]), 5000.0, atol=15.0)


def test_measurements_come_every_period() -> None:
    corners = np.array([[0.0, 0.0], [10e3, 0.0], [10e3, 10e3], [0.0, 10e3]])
    flight = plan_flight(straight_legs(corners), speed=100.0)
    times, positions = flight.measurements(10.0)
    assert len(times) == int(flight.duration // 10.0)
    np.testing.assert_allclose(np.diff(times), 10.0)
    np.testing.assert_allclose(positions, flight.poses(1000.0 * np.arange(1, len(times) + 1))[:, :2])
    assert flight.measurements(1e6)[0].size == 0


def test_a_uav_that_stays_home_flies_nothing() -> None:
    flight = plan_flight([])
    assert flight.length == 0.0
    assert flight.measurements(1.0)[1].shape == (0, 2)


def test_a_task_on_the_depot_is_no_leg() -> None:
    legs = [np.array([[1.0, 2.0], [1.0, 2.0]])] * 2
    waypoints, _ = reference_waypoints(legs, 600.0)
    assert waypoints.tolist() == [[1.0, 2.0]]


def test_json_round_trip() -> None:
    flight = plan_flight(straight_legs(np.array([[0.0, 0.0], [3e3, 1e3], [2e3, 5e3]])))
    again = Flight.from_json(flight.to_json())
    np.testing.assert_array_equal(again.poses([0.0, 777.0]), flight.poses([0.0, 777.0]))


@pytest.mark.parametrize(("speed", "radius"), [(0.0, 50.0), (100.0, -1.0)])
def test_bad_speed_or_radius(speed: float, radius: float) -> None:
    with pytest.raises(InputError, match="positive"):
        plan_flight([], speed=speed, radius=radius)


@pytest.mark.parametrize("clock", [None, np.array([0.0, 30.0, 100.0])])
def test_laps_are_the_same_tour_again(clock: np.ndarray | None) -> None:
    once = replace(plan_flight(straight_legs(np.array([[0.0, 0.0], [3000.0, 0.0], [1000.0, 2000.0]]))), clock=clock)
    thrice, within = once.repeated(3), np.linspace(0.0, once.duration, 7)
    assert (thrice.length, thrice.duration) == pytest.approx((3 * once.length, 3 * once.duration))
    for lap in range(3):
        later = thrice.poses(thrice.travelled(lap * once.duration + within))
        np.testing.assert_allclose(later[:, :2], once.poses(once.travelled(within))[:, :2], atol=1e-6)
