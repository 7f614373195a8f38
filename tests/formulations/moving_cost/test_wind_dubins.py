"""Dubins paths in a steady wind: flown step by step, against calm ones, closed forms and a scan over arrival times."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from formulations.mapping.dubins import TURNS, _word_segments, advance, dubins_length
from formulations.mapping.flight import Flight
from formulations.mapping.planned import planned_flight
from formulations.moving_cost.turns.headings import headings
from formulations.moving_cost.turns.refinement import flown_headings, refined_routes
from formulations.moving_cost.turns.tracks import FINE, flown_legs, kept_inside, stay_inside, tracks
from formulations.moving_cost.turns.travel import Turns, steady_turns_of, turning_instance, turns_of
from formulations.moving_cost.turns.wind import wind_path, wind_path_free
from instances import InputError, tour_costs
from instances.arrays import Floats

Leg = tuple[float, float, float, float, float, float]
"""Place (dx, dy) of the goal, headings there and here, wind; in turning radii and airspeeds."""


def legs(count: int, seed: int, *, strongest: float = 0.9) -> list[Leg]:
    rng = np.random.default_rng(seed)
    far, blows = rng.choice([1.0, 4.0, 20.0], count), rng.choice([0.0, 0.3, strongest / math.sqrt(2)], count)
    dx, dy = rng.uniform(-1, 1, (2, count)) * far
    h0, h1 = rng.uniform(-4, 7, (2, count))
    wx, wy = rng.uniform(-1, 1, (2, count)) * blows
    h1[::5], wx[::7] = h0[::5], 0.0
    return list(zip(*(each.tolist() for each in (dx, dy, h0, h1, wx, wy)), strict=True))


def flown(word: int, segments: tuple[float, ...], heading: float, wind: tuple[float, float]) -> Floats:
    """Return the pose over ground at the end of three segments begun at the origin."""
    x, y, h = 0.0, 0.0, heading
    for turn, length in zip(TURNS[word], segments, strict=True):
        x, y, h = advance(x, y, h, int(turn), length, 1.0)
    return np.array([x + wind[0] * sum(segments), y + wind[1] * sum(segments), h])


def miss(pose: Floats, x: float, y: float, heading: float) -> float:
    return max(abs(pose[0] - x), abs(pose[1] - y), abs(math.remainder(pose[2] - heading, 2 * math.pi)))


def straight(dx: float, dy: float, wx: float, wy: float) -> float:
    room, along = 1 - wx * wx - wy * wy, wx * dx + wy * dy
    return (math.sqrt(along * along + room * (dx * dx + dy * dy)) - along) / room


@pytest.mark.parametrize("count", [5000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_flown_paths_end_where_they_should_and_no_sooner_than_straight_lines(count: int) -> None:
    for dx, dy, h0, h1, wx, wy in legs(count, 1):
        word, *segments = wind_path(dx, dy, h0, h1, 1.0, wx, wy)
        assert min(segments) >= 0
        assert miss(flown(word, tuple(segments), h0, (wx, wy)), dx, dy, h1) < 1e-6
        assert sum(segments) >= straight(dx, dy, wx, wy) * (1 - 1e-12) - 1e-9
        if wx == wy == 0.0:
            assert sum(segments) == pytest.approx(dubins_length(0.0, 0.0, h0, dx, dy, h1, 1.0), abs=1e-9)


def scanned(leg: Leg, until: float, steps: int) -> float:
    """Return the least length at whose time a word, or it and full turns, arrives, by steps of the arrival; or inf."""
    dx, dy, h0, h1, wx, wy = leg
    lengths, best = np.linspace(0.0, until, steps), math.inf
    for word in range(6):
        over = np.empty(steps)
        for i, s in enumerate(lengths):
            x, y = dx - wx * s, dy - wy * s
            line = math.atan2(y, x)
            angles = (h0 - line) % (2 * math.pi), (h1 - line) % (2 * math.pi)
            over[i] = (s - sum(_word_segments(word, math.hypot(x, y), *angles))) / (2 * math.pi)
        with np.errstate(invalid="ignore"):
            low, high = np.minimum(over[:-1], over[1:]), np.maximum(over[:-1], over[1:])
            crossed = np.isfinite(low) & np.isfinite(high) & (high - low < 0.3)  # more is a jump
            crossed &= np.maximum(np.ceil(low), 0.0) <= high
        if crossed.any():
            best = min(best, float(lengths[int(np.argmax(crossed)) + 1]))
    return best


def test_no_arrival_is_overlooked() -> None:
    found = 0
    for leg in legs(40, 2):
        path = wind_path(*leg[:4], 1.0, *leg[4:])
        oracle = scanned(leg, 1.02 * sum(path[1:]) + 0.1, 400)
        assert sum(path[1:]) <= oracle + 1e-6
        found += oracle < math.inf
    assert found > 25


@pytest.mark.slow
def test_no_arrival_is_overlooked_in_two_thousand_legs() -> None:
    for leg in legs(2000, 3):
        path = wind_path(*leg[:4], 1.0, *leg[4:])
        assert sum(path[1:]) <= scanned(leg, 1.02 * sum(path[1:]) + 0.1, 2000) + 1e-6


CRAB = -math.asin(0.25)


@pytest.mark.parametrize(
    ("goal", "first", "last", "wind", "seconds"),
    [
        ((1000.0, 0.0), 0.0, 0.0, (5.0, 0.0), 40.0),
        ((1000.0, 0.0), 0.0, 0.0, (-5.0, 0.0), 200.0 / 3),
        ((1000.0, 0.0), CRAB, CRAB, (0.0, 5.0), 1000 / math.sqrt(375)),
        ((500.0, 300.0), 0.0, math.pi / 2, (5.0, -3.0), 27.156566),
        ((500.0, 300.0), 0.0, math.pi / 2, (0.0, 0.0), 30.214661),
    ],
)
def test_known_times(
    goal: tuple[float, float], first: float, last: float, wind: tuple[float, float], seconds: float
) -> None:
    path = wind_path(*goal, first, last, 100.0, wind[0] / 20, wind[1] / 20)
    assert sum(path[1:]) / 20 == pytest.approx(seconds, abs=1e-6)


def test_where_the_shortest_path_is_there_too_early_another_word_arrives() -> None:
    dx, dy, h0, h1, wx, wy = leg = 14.99 / 35, 3.618 / 35, -2.7745, 1.5179, 6 / 12, -1.5 / 12
    word, *segments = wind_path(dx, dy, h0, h1, 1.0, wx, wy)
    s = sum(segments)
    assert miss(flown(word, tuple(segments), h0, (wx, wy)), dx, dy, h1) < 1e-6
    assert dubins_length(0.0, 0.0, h0, dx - wx * s, dy - wy * s, h1, 1.0) < s - 0.1  # that one would have to wait
    assert s == pytest.approx(scanned(leg, 1.1 * s, 20_000), abs=1e-3)


def test_free_headings_are_flown_and_no_heading_tried_is_better() -> None:
    for n, (dx, dy, heading, _, wx, wy) in enumerate(legs(200, 4)):
        first = bool(n % 2)
        word, a, b, c, free = wind_path_free(dx, dy, first, heading, 1.0, wx, wy)
        h0, h1 = (free, heading) if first else (heading, free)
        assert miss(flown(word, (a, b, c), h0, (wx, wy)), dx, dy, h1) < 1e-6
        for other in np.linspace(0.0, 2 * np.pi, 24 if math.hypot(dx, dy) > 4 else 9):
            ends = (other, heading) if first else (heading, other)
            assert a + b + c <= sum(wind_path(dx, dy, *ends, 1.0, wx, wy)[1:]) + 1e-8


def test_an_instance_in_wind_costs_flight_times_and_has_no_calm_bounds() -> None:
    places = np.array([[0.0, 0.0], [1000.0, 0.0], [0.0, 700.0], [900.0, 800.0], [-300.0, -200.0]])
    turns = Turns(100.0, 20.0, (5.0, 0.0))
    states = headings(places, 4, uniform=4, sights=1, drift=turns.drift)
    made = turning_instance("wind", places, 4, turns, states)
    assert made.travel is not None
    assert made.travel.cost.min(initial=math.inf, where=made.travel.cost > 0) >= 300.0 / 25
    assert made.cost[0, 1] == pytest.approx(40.0)
    assert made.cost[1, 0] == pytest.approx(200.0 / 3)
    assert made.provenance["turns"]["wind"] == [5.0, 0.0]
    assert turns.straight_times(places)[:2, :2] == pytest.approx(np.array([[0.0, 40.0], [200.0 / 3, 0.0]]))
    assert (turns.straight_times(places) <= made.cost * (1 + 1e-12)).all()
    assert turns_of(made) is None
    known = steady_turns_of(made)
    assert known is not None
    assert known[0] == turns
    assert known[1].lows.tolist() == states.lows.tolist()
    with pytest.raises(InputError, match="not less than the airspeed"):
        Turns(100.0, 5.0, (5.0, 0.0))


def test_headings_of_routes_are_refined_in_wind_and_flown_as_claimed() -> None:
    turns, points = Turns(100.0, 20.0, (6.0, 4.0)), np.random.default_rng(3).uniform(0, 1500, (7, 2))
    for free in (True, False):
        states = headings(points, 5, uniform=6, free_depots=free, drift=turns.drift)
        instance = turning_instance("wind", points, 5, turns, states, closed=not free)
        routes = ((0, 1, 2), (4, 3))
        chains, costs = refined_routes(instance, routes), tour_costs(instance, routes)
        for k, chain in enumerate(chains):
            assert chain is not None
            assert chain.cost < costs[k]
            stops = points[[5 + k, *routes[k], 5 + k]]
            flight, legs = planned_flight(stops, flown_headings(chain, stops, turns), turns)
            assert flight.duration == pytest.approx(chain.cost, rel=1e-9)
            assert [leg[-1] for leg in legs] == [pytest.approx(place, abs=1e-6) for place in stops[1:]]
            poses = flight.poses(np.linspace(0.0, flight.length, 5))
            assert poses[-1, :2] == pytest.approx(stops[-1], abs=1e-6)
            again = Flight.from_json(json.loads(json.dumps(flight.to_json())))
            assert again.poses(np.linspace(0.0, flight.length, 5)) == pytest.approx(poses)


@pytest.mark.parametrize("wind", [(0.0, 0.0), (4.0, -3.0)])
def test_tracks_are_flown_legs_and_those_that_leave_are_forbidden(wind: tuple[float, float]) -> None:
    turns, rng = Turns(50.0, 20.0, wind), np.random.default_rng(5)
    room = box(0, 0, 600, 500).difference(box(280, 200, 320, 300))
    assert isinstance(room, Polygon)
    places = np.array([[60.0, 60.0], [500.0, 80.0], [150.0, 400.0], [450.0, 250.0]])
    states = headings(places, 3, uniform=12, free_depots=False, drift=turns.drift)
    kept = kept_inside(turns.lengths(places, states), places, states, turns, room)
    first, second = (rng.integers(0, len(states.nodes), 300) for _ in range(2))
    apart = states.nodes[first] != states.nodes[second]
    first, second = first[apart], second[apart]
    poses = np.column_stack([places[states.nodes], states.lows])
    words, segments = flown_legs(poses[first], poses[second], turns)
    lines = tracks(poses[first], words, segments, turns, FINE / 4)
    outside = [not room.buffer(0.02).covers(line) for line in lines]
    assert 0 < sum(outside) < len(outside)
    assert np.isinf(kept[first, second]).tolist() == outside
    assert [line.coords[-1] for line in lines] == [pytest.approx(places[states.nodes[s]], abs=1e-6) for s in second]
    assert stay_inside(poses[:1], poses[:1], turns, room).all()
