"""Legs in winds that change, against quadrature and the published optima of small instances with such legs."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.arrays import Floats
from instances.environment.wind import Uniform
from instances.environment.wind_changing import ChangingWind, Drifting, Front, Turning, Valley
from instances.environment.wind_table import Sum, wind_from_toml
from instances.wind_arrivals import leg_times, quickest_times, track_times
from instances.wind_triangle import flight_times

QUARTER = np.pi / 2 / 3600
TURNING = Turning((10.0, 0.0), QUARTER)
VALLEY = Valley((3.0, 1.0), (6.0, -2.0), 5000.0, 0.2)
FRONT = Front((5.0, 5.0), (-5.0, 3.0), 8.0, 30.0, -5000.0, 1500.0)
DRIFTING = Drifting((5.0, 0.0), (3.0, 1.0), ((5000.0, 5000.0), (9000.0, 3000.0)), (8e4, -8e4), (1500.0, 1500.0))
WINDS: list[ChangingWind] = [TURNING, VALLEY, FRONT, DRIFTING]


def legs(count: int, seed: int = 0) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0, 20000, (2, count, 2))
    return a, b, rng.uniform(0, 5000, count)


@pytest.mark.parametrize("wind", [TURNING, VALLEY])
def test_displacements_are_integrals_of_the_wind(wind: Turning | Valley) -> None:
    shares = (np.arange(20000) + 0.5) / 20000
    for t in (1.0, 700.0, 9000.0):
        means = wind.velocity_at(t * shares).mean(axis=0)
        assert wind.displacement(np.array([t]))[0] == pytest.approx(t * means, rel=1e-7)


@pytest.mark.parametrize("wind", WINDS)
def test_line_integrals_at_take_off_are_those_of_the_field(wind: ChangingWind) -> None:
    a, b, _ = legs(5)
    shares = (np.arange(4000) + 0.5) / 4000
    sampled = [((wind(p + shares[:, None] * (q - p)) * (q - p)).sum(axis=1)).mean() for p, q in zip(a, b, strict=True)]
    assert wind.line_integral(a, b) == pytest.approx(sampled, rel=1e-6)
    assert wind(a) == pytest.approx(wind.velocities(a, np.zeros(5)))


@pytest.mark.parametrize("wind", [TURNING, VALLEY])
def test_the_quickest_way_ends_where_the_air_has_carried_the_goal(wind: Turning | Valley) -> None:
    a, b, departures = legs(500)
    times = quickest_times(b - a, departures, wind, 20.0)
    carried = wind.displacement(departures + times) - wind.displacement(departures)
    assert np.hypot(*(b - a - carried).T) == pytest.approx(20.0 * times, rel=1e-12)
    assert (times <= track_times(a, b, departures, wind, 20.0) * (1 + 1e-9)).all(), "a straight track is no quicker"


@pytest.mark.parametrize("wind", [FRONT, DRIFTING])
def test_a_track_is_flown_at_the_ground_speeds_of_its_moments(wind: ChangingWind) -> None:
    """Flown in small steps by the wind triangle, the goal is reached at the time that is said."""
    a, b, departures = legs(6)
    times = track_times(a, b, departures, wind, 20.0)
    d = b - a
    for p, way, start, time in zip(a, d, departures, times, strict=True):
        tangent, at, steps = way / np.hypot(*way), 0.0, 4000
        for k in range(steps):
            w = wind.velocities((p + at * tangent)[None], np.array([start + (k + 0.5) * time / steps]))[0]
            across = w[1] * tangent[0] - w[0] * tangent[1]
            at += (w @ tangent + np.sqrt(400 - across**2)) * time / steps
        assert at == pytest.approx(np.hypot(*way), rel=2e-4)


def test_winds_that_do_not_change_take_the_times_of_the_wind_triangle() -> None:
    a, b, departures = legs(50)
    still = flight_times(a, b, Uniform((10.0, 0.0)), 20.0)
    for wind in (Turning((10.0, 0.0), 0.0), Front((10.0, 0.0), (10.0, 0.0), 5.0)):
        assert leg_times(a, b, departures, wind, 20.0) == pytest.approx(still, rel=1e-9)


@pytest.mark.parametrize("wind", WINDS)
def test_who_departs_later_arrives_later(wind: ChangingWind) -> None:
    a, b, departures = legs(200)
    first, later = leg_times(a, b, departures, wind, 20.0), leg_times(a, b, departures + 1.0, wind, 20.0)
    assert (later + 1.0 > first).all()


@pytest.mark.parametrize("wind", WINDS)
def test_a_wind_as_strong_as_the_uav_is_refused(wind: ChangingWind) -> None:
    with pytest.raises(InputError, match="not less than the airspeed of 5 m/s"):
        leg_times(*legs(20), wind, 5.0)


@pytest.mark.parametrize("wind", WINDS)
def test_tables_come_back(wind: ChangingWind, tmp_path: Path) -> None:
    assert wind_from_toml(wind.to_toml(tmp_path)) == wind


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({"kind": "valley", "velocity": [0, 0], "amplitude": [1, 1], "period": 0}, "period"),
        ({"kind": "front", "before": [0, 0], "after": [1, 1], "speed": 5, "width": -1}, "width"),
        ({"kind": "turning", "velocity": [0, 0]}, "turning"),
        (
            {"kind": "drifting", "velocity": [0, 0], "drift": [1, 0], "centres": [[0, 0]], "circulation": [1, 2]},
            "as many",
        ),
    ],
)
def test_what_a_table_cannot_say(table: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        wind_from_toml(table)


def test_a_sum_takes_no_wind_that_changes() -> None:
    with pytest.raises(InputError, match="a sum cannot hold a wind that changes with time"):
        Sum((Uniform((1.0, 0.0)), TURNING))


@pytest.mark.parametrize(("seed", "best"), [*enumerate([1806.518096, 1057.600555, 1959.063116, 1755.771491])])
def test_energies_of_the_paper_in_a_turning_wind(seed: int, best: float) -> None:
    """Its clock is |σ|/v0 whatever the wind: ∫ w·dσ of a leg is v0 e·(W(t₁) − W(t₀)). Every order of every set."""
    points = np.random.default_rng(1000 * 5 + 100 * 2 + seed).uniform(0, 20000, (7, 2))

    def energy(depot: int, order: tuple[int, ...]) -> float:
        way = np.diff(points[[depot, *order, depot]], axis=0)
        far = np.hypot(*way.T)
        clock = np.concatenate([[0.0], np.cumsum(far)]) / 20.0
        carried = np.diff(TURNING.displacement(clock), axis=0)
        return float(clock[-1] - ((way / far[:, None]) * carried).sum() / 20.0)

    tours: list[dict[frozenset[int], float]] = [{frozenset(): 0.0}, {frozenset(): 0.0}]
    for k, size in ((k, size) for k in (0, 1) for size in range(1, 6)):
        for order in permutations(range(5), size):
            tasks = frozenset(order)
            tours[k][tasks] = min(energy(5 + k, order), tours[k].get(tasks, np.inf))
    everything = frozenset(range(5))
    assert min(max(cost, tours[1][everything - part]) for part, cost in tours[0].items()) == pytest.approx(
        best, abs=1e-6
    )
