"""A flight at constant airspeed: its duration, where it is when, and its file."""

import json

import numpy as np
import pytest
from scipy.integrate import quad

from formulations.mapping.clock import clocked
from formulations.mapping.flight import Flight, plan_flight
from instances import InputError
from instances.environment.wind import Rotation, Uniform
from instances.environment.wind_changing import Front, Turning
from instances.wind_flights import polyline_times
from instances.wind_triangle import ground_speeds

CORNERS = np.array([[0.0, 0.0], [4000.0, 0.0], [4000.0, 3000.0]])
FLIGHT = plan_flight([CORNERS[[k, (k + 1) % 3]] for k in range(3)], speed=30.0, radius=200.0)


def test_without_wind_nothing_changes():
    calm = clocked(FLIGHT, Uniform((0.0, 0.0)))
    assert calm.duration == pytest.approx(FLIGHT.duration, rel=1e-12)
    times, positions = FLIGHT.measurements(10.0)
    again, same = calm.measurements(10.0)
    np.testing.assert_array_equal(again, times)
    np.testing.assert_allclose(same, positions, atol=1e-6)


@pytest.mark.parametrize("wind", [Uniform((9.0, -6.0)), Rotation(3e-3, (2000.0, 1000.0))])
def test_the_clock_is_that_of_the_wind_triangle(wind):
    flown = clocked(FLIGHT, wind)

    def slowness(s):
        pose = FLIGHT.poses([s])[0]
        tangent = np.array([[np.cos(pose[2]), np.sin(pose[2])]])
        return 1 / ground_speeds(wind(pose[None, :2]), tangent, 30.0)[0]

    for end in (2500.0, 7000.0, FLIGHT.length):
        time = quad(slowness, 0, end, limit=200, epsrel=1e-7)[0]
        assert flown.travelled([time])[0] == pytest.approx(end, abs=0.1)
    times, poses = flown.track(0.5)
    over_ground = np.hypot(*np.diff(poses[:-1, :2], axis=0).T) / 0.5
    through_air = np.hypot(*(np.diff(poses[:-1, :2], axis=0) / 0.5 - wind(poses[:-2, :2])).T)
    straight = np.abs(np.diff(poses[:-1, 2])) < 1e-9
    np.testing.assert_allclose(through_air[straight], 30.0, rtol=2e-2)
    assert over_ground.max() <= flown.fastest * (1 + 1e-6)
    assert times[-1] == flown.duration


def test_the_clock_is_kept_in_the_file_and_others_are_read_as_before():
    flown = clocked(FLIGHT, Uniform((9.0, -6.0)))
    again = Flight.from_json(json.loads(json.dumps(flown.to_json())))
    assert (again.duration, again.fastest) == (flown.duration, flown.fastest)
    assert "clock" not in FLIGHT.to_json()
    with pytest.raises(InputError, match="clock of a flight must be times from 0"):
        Flight.from_json({**FLIGHT.to_json(), "clock": [0.0, 2.0, 1.0]})


def test_a_wind_that_the_airspeed_cannot_beat_is_refused_with_its_place():
    with pytest.raises(InputError, match=r"wind: at \(\d+, \d+\) m it blows with 31 m/s"):
        clocked(FLIGHT, Uniform((31.0, 0.0)))


def test_in_a_wind_that_changes_the_clock_is_that_of_the_moments_of_passing():
    wind = Front((9.0, -6.0), (-8.0, 5.0), 15.0, position=-1000.0, width=500.0)
    flown = clocked(FLIGHT, wind)
    track = FLIGHT.poses(np.linspace(0, FLIGHT.length, 4001))[:, :2]
    again = polyline_times(track, np.array([0, 4001]), np.zeros(1, dtype=np.int64), np.zeros(1), wind, 30.0)
    assert flown.duration == pytest.approx(again[0], rel=1e-4)
    still = clocked(FLIGHT, Turning((9.0, -6.0), 0.0))
    assert still.duration == pytest.approx(clocked(FLIGHT, Uniform((9.0, -6.0))).duration, rel=1e-12)
