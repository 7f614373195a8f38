"""Heights of tracks: level ones over a peak, and those that follow the ground as low as the rates allow."""

from __future__ import annotations

import numpy as np
import pytest

from formulations.mapping.flight import Flight, plan_flight
from formulations.mapping.heights import Altitude, Frame, following, heights_of
from instances.environment.terrain import Terrain

OUT_AND_BACK = [np.array([[0.0, 0.0], [4000.0, 0.0]]), np.array([[4000.0, 0.0], [0.0, 0.0]])]


@pytest.fixture(scope="module")
def flight() -> Flight:
    return plan_flight(OUT_AND_BACK, speed=50.0, radius=50.0)


def hills(depot: float, peak: float) -> Terrain:
    """Return flat ground with the depot (0, 0) on a hill, and a ridge half way to (4000, 0)."""
    height = np.zeros((41, 61))  # nodes every 100 m from (-1000, -2000)
    height[20, 10], height[:, 30] = depot, peak
    return Terrain((-1000.0, -2000.0), (100.0, 100.0), height)


def flown(frame: Frame, above: float = 300.0) -> Altitude:
    return Altitude(above, frame, climb=0.1, descent=0.06)


def test_a_peak_between_two_tasks_is_found_with_its_place(flight: Flight) -> None:
    heights = heights_of(flight, flown(Frame.AMSL), hills(0.0, 2000.0))
    assert heights.clearance == pytest.approx(-1700.0, abs=20.0)
    assert flight.poses(heights.travelled[heights.nearest])[0, :2] == pytest.approx([2000.0, 0.0], abs=51.0)


def test_above_home_is_above_the_hill_the_depot_stands_on(flight: Flight) -> None:
    heights = heights_of(flight, flown(Frame.ABOVE_HOME), hills(250.0, 0.0))
    assert (heights.ground[0], heights.track[0], heights.track[-1]) == pytest.approx((250.0, 550.0, 550.0))
    assert heights.clearance == pytest.approx(300.0)
    assert heights_of(flight, flown(Frame.AMSL), hills(350.0, 0.0)).clearance == pytest.approx(-50.0)


def test_tracks_above_the_ground_climb_in_time_and_sink_no_faster_than_they_may(flight: Flight) -> None:
    heights = heights_of(flight, flown(Frame.ABOVE_GROUND, 120.0), hills(30.0, 150.0))
    slope = np.diff(heights.track) / np.diff(heights.travelled)
    assert heights.clearance == pytest.approx(120.0)
    assert (slope.min(), slope.max()) == pytest.approx((-0.06, 0.1))
    assert heights.track.max() == pytest.approx(270.0, abs=5.0)


def test_without_terrain_the_ground_is_flat_at_sea_level(flight: Flight) -> None:
    for frame in Frame:
        heights = heights_of(flight, flown(frame, 80.0), None)
        np.testing.assert_allclose(heights.track, 80.0)
        assert heights.clearance == pytest.approx(80.0)


def test_the_profile_is_the_least_there_is() -> None:
    rng = np.random.default_rng(0)
    s = np.cumsum(rng.uniform(0.5, 2.0, 200))
    floor = rng.uniform(0.0, 30.0, 200)
    ahead = s[None, :] - s[:, None]  # the definition, every pair of places
    least = (floor[None, :] - np.where(ahead >= 0, 0.1 * ahead, -0.06 * ahead)).max(axis=1)
    np.testing.assert_allclose(following(s, floor, 0.1, 0.06), least, rtol=1e-12)
