"""Earliest arrivals by the clock: labels against all paths there are, the law of departures, and an oracle."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, box

from formulations.moving_cost.arrivals import Timetable, earliest_arrivals, timetable
from formulations.moving_cost.corridor import quickest_nearby
from formulations.moving_cost.costing import query_in
from formulations.moving_cost.free_space import free_space
from formulations.moving_cost.method import PlansByClock
from formulations.moving_cost.registry import make_method
from formulations.moving_cost.wind_frames import segment_times, wind_frames
from instances.arrays import Ints
from instances.environment.region import Region
from instances.environment.wind_changing import Drifting, Turning
from instances.moving_cost import CostKind
from instances.scenario import Scenario
from instances.wind_arrivals import quickest_times, track_times
from instances.wind_flights import polyline_times

SIDE, AIRSPEED = 20000.0, 20.0
WHIRLS = Drifting((2.0, 0.0), (6.0, 0.0), ((4000.0, 6000.0), (4000.0, 14000.0)), (2e5, -2e5), (2500.0, 2500.0))
TURNS = Turning((8.0, 2.0), np.pi / 3600)
WALL = box(9500.0, 3000.0, 10500.0, 17000.0)
NODES = np.array([[4000.0, 5000.0], [16000.0, 6000.0], [15000.0, 15000.0], [3000.0, 15000.0]])


def scenario_in(wind: Drifting | Turning) -> Scenario:
    region = Region.rectangle(SIDE, SIDE)
    return Scenario("whirls", region, NODES[3:], AIRSPEED, wind, NODES[:3], no_fly=[WALL], cost=CostKind.TIME)


def first_in_first_out(seed: int, n: int) -> tuple[Ints, Ints, Timetable]:
    """Return a random graph of `n` nodes and times of its edges that no later departure undercuts."""
    rng = np.random.default_rng(seed)
    linked = (rng.random((n, n)) < 0.6) & ~np.eye(n, dtype=bool)
    start = np.concatenate([[0], np.cumsum(linked.sum(axis=1))])
    step, costs = 10.0, rng.uniform(1.0, 60.0, (int(linked.sum()), 5))
    for frame in range(3, -1, -1):
        costs[:, frame] = np.minimum(costs[:, frame], costs[:, frame + 1] + step)
    return start, np.nonzero(linked)[1], Timetable(step, costs)


def walked(walk: tuple[int, ...], start: Ints, neighbour: Ints, table: Timetable, departure: float) -> float:
    """Return when a walk arrives, inf where an edge is missing: linear between frames by numpy."""
    time = departure
    for z, x in itertools.pairwise(walk):
        edge = [e for e in range(start[z], start[z + 1]) if neighbour[e] == x]
        if not edge:
            return np.inf
        time += float(np.interp(time, table.step * np.arange(5), table.costs[edge[0]]))
    return time


@given(st.integers(0, 10**6), st.floats(0.0, 80.0))
@settings(max_examples=30, deadline=None)
def test_labels_are_the_earliest_of_all_paths_and_no_later_departure_is_earlier(seed: int, departure: float) -> None:
    n = 5
    start, neighbour, table = first_in_first_out(seed, n)
    arrival, parent = earliest_arrivals(start, neighbour, table, 0, departure)
    for x in range(1, n):
        ways = ((0, *middle, x) for k in range(n - 1) for middle in itertools.permutations(set(range(1, n)) - {x}, k))
        assert arrival[x] == pytest.approx(min(walked(way, start, neighbour, table, departure) for way in ways))
        assert (parent[x] < 0) == np.isinf(arrival[x])
    later, _ = earliest_arrivals(start, neighbour, table, 0, departure + 7.0)
    assert (later >= arrival - 1e-9).all()


def test_edges_are_integrated_as_tracks_are_and_first_in_first_out() -> None:
    rng = np.random.default_rng(0)
    a = rng.uniform(3000, 17000, (40, 2))
    b = a + rng.uniform(-1200, 1200, (40, 2))
    wind = wind_frames(WHIRLS, Region.rectangle(SIDE, SIDE), AIRSPEED, 2000.0)
    raw, table = segment_times(a, b, wind), timetable(a, b, wind)
    for frame in (0, 31, 50):
        true = track_times(a, b, np.full(40, frame * wind.step), WHIRLS, AIRSPEED)
        assert raw[:, frame] == pytest.approx(true, rel=2e-3)
    assert (np.diff(table.costs, axis=1) >= -wind.step * (1 + 1e-12)).all()
    assert table.costs == pytest.approx(raw, rel=1e-4)
    assert np.isinf(segment_times(a, b, wind._replace(airspeed=1.0))).any(), (
        "no time is made up where it cannot be flown"
    )


@pytest.mark.parametrize(
    ("method", "coarse", "fine", "within"),
    [
        ("dijkstra", {"samples": 60}, {"samples": 250, "radius_factor": 2.0}, 0.03),
        ("fmt-star", {"samples": 60}, {"samples": 250, "radius_factor": 2.0}, 0.03),
        pytest.param("refined", {"samples": 30}, {"samples": 250}, 5e-4, marks=pytest.mark.slow),
    ],
)
def test_graphs_come_down_to_the_closed_form_of_a_turning_wind(
    method: str, coarse: dict[str, float], fine: dict[str, float], within: float
) -> None:
    query, begun = query_in(replace(scenario_in(TURNS), no_fly=()), TURNS.at(0.0)), np.full(16, 900.0)
    wind, (i, j) = wind_frames(TURNS, query.region, AIRSPEED, 3000.0), np.nonzero(~np.eye(4, dtype=bool))
    least = quickest_times(NODES[j] - NODES[i], begun[:12], TURNS, AIRSPEED)
    excess = []
    for options in (coarse, fine):
        made = make_method(method, options)
        assert isinstance(made, PlansByClock)
        (plan,) = made.by_clock(query, wind, begun[:1])
        took = polyline_times(plan.points, plan.offsets, np.arange(16), begun, TURNS, AIRSPEED)[4 * i + j]
        excess.append(took / least - 1)
        assert excess[-1].min() >= -1e-4
    assert excess[1].mean() < 0.8 * excess[0].mean()
    assert excess[1].mean() < within


def test_a_wind_that_does_not_turn_gives_the_trees_of_one_that_stays() -> None:
    still = Turning((6.0, -4.0), 0.0)
    query = query_in(scenario_in(still), still.at(0.0))
    wind = wind_frames(still, query.region, AIRSPEED, 3000.0)
    for name in ("dijkstra", "fmt-star"):
        method = make_method(name, {"samples": 150})
        assert isinstance(method, PlansByClock)
        once, (by_clock,) = method.solve(query), method.by_clock(query, wind, np.array([700.0]))
        cost = query.measure.polylines(by_clock.points, by_clock.offsets).reshape(4, 4)
        assert cost == pytest.approx(once.cost, rel=1e-6)


def test_a_corridor_makes_paths_quicker_and_keeps_them_off_walls() -> None:
    query = query_in(scenario_in(WHIRLS), WHIRLS.at(0.0))
    wind, space = wind_frames(WHIRLS, query.region, AIRSPEED, 3000.0), free_space(query.region)
    around = np.array([[4000.0, 5000.0], [9400.0, 17300.0], [10600.0, 17300.0], [16000.0, 6000.0]])
    line, ends = quickest_nearby(around, np.array([0, 4]), 600.0, 500.0, wind, space)
    before, after = (
        polyline_times(p, np.array([0, len(p)]), np.zeros(1, dtype=int), np.array([600.0]), WHIRLS, AIRSPEED)[0]
        for p in (around, line)
    )
    assert list(ends) == [0, len(line)]
    assert after < 0.99 * before
    assert query.region.polygon.buffer(1e-3).contains(LineString(line))
