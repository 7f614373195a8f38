"""Flights changed in the air: what was flown stays, the way on begins with the present pose and ends at home."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.mapping.clock import clocked
from formulations.mapping.flight_check import check_flight
from formulations.replanning.onward import flown_until, fly_on, joined, rest_after
from formulations.replanning.spending import track_cost
from instances.environment.wind import Rotation, Uniform
from instances.moving_cost import CostKind, CostMeasure
from tests.formulations.replanning.worlds import CALM, HOMES, SPEED, SQUARE, aloft

WIND = Rotation(2e-3, (4000.0, 4000.0))


@pytest.mark.parametrize("wind", [None, WIND])
@pytest.mark.parametrize("time", [0.0, 3.21, 77.7])
def test_the_flown_part_and_its_rest_are_the_flight(wind, time):
    flight = aloft(np.random.default_rng(0), 300.0).flights[0]
    flight = flight if wind is None else clocked(flight, wind)
    flown = flown_until(flight, time)
    rest = rest_after(flight, flown)
    whole = joined(flown, rest if wind is None else clocked(rest, wind))
    s = np.linspace(0.0, flight.length, 200)
    assert flown.duration == pytest.approx(time, abs=1e-9)
    assert whole.length == pytest.approx(flight.length)
    assert np.allclose(whole.poses(s)[:, :2], flight.poses(s)[:, :2], atol=1e-6)
    assert whole.duration == pytest.approx(flight.duration, rel=1e-6)


def test_the_way_on_turns_from_the_present_heading_and_keeps_the_radius():
    flight = aloft(np.random.default_rng(1), 300.0).flights[1]
    flown = flown_until(flight, 40.0)
    x, y, heading = flown.poses(flown.length)[0]
    behind = np.array([x, y]) - 1500.0 * np.array([np.cos(heading), np.sin(heading)])
    legs = [np.array([[x, y], behind]), np.array([behind, HOMES[1]])]
    whole, on = fly_on(flown, legs)
    assert np.allclose(on.poses(0.0)[0], [x, y, heading])
    assert np.allclose(whole.poses(whole.length)[0, :2], HOMES[1], atol=1e-6)
    judged = check_flight(whole, [np.array([[0.0, 0.0], [1.0, 1.0]])], [behind], SQUARE)
    assert judged.least_radius >= 50.0 - 0.1
    assert judged.task_distance < 0.05
    s = np.linspace(0.0, whole.length, 20_000)
    steps = np.hypot(*np.diff(whole.poses(s)[:, :2], axis=0).T)
    assert steps.max() <= s[1] * (1 + 1e-9)  # no jump where the two meet


@pytest.mark.parametrize("kind", list(CostKind))
def test_what_a_track_costs(kind):
    flight = aloft(np.random.default_rng(2), 300.0).flights[2]
    assert track_cost(flight, CostMeasure(kind, CALM, SPEED)) == pytest.approx(flight.length / SPEED)
    wind = Uniform((10.0, -5.0))
    cost = track_cost(flight, CostMeasure(kind, wind, SPEED))
    if kind is CostKind.ENERGY:  # a uniform wind does no work on a closed tour
        assert cost == pytest.approx(flight.length / SPEED, rel=3e-5)
    else:
        assert cost == pytest.approx(clocked(replace(flight, speed=SPEED), wind).duration, rel=3e-5)
