"""Take-off within a window: waiting pays for endurance and not for makespan; take-offs against bisection."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instances import InputError, Instance, Travel, check_routes, makespan, objective, take_offs, tour_costs
from instances.formats.native import document_text, instance_of
from instances.frozen import in_better_directions


def calming(window: float, endurance: float | None = 170.0) -> Instance:
    """One task; both legs take 100 s at first, 0.2 s less each second later, 60 s from 200 s on."""
    cost = np.array([[100.0, 60.0]])[..., None, None] * (1 - np.eye(2))
    travel = Travel(cost, np.array([0]), np.array([0.0, 200.0]), window=window)
    return Instance.of_travel("calming", travel, 1, endurance=None if endurance is None else [endurance])


def wild(seed: int) -> Travel:
    """Return legs between six nodes at uneven knots; they rise steeply or fall nearly as fast as they may."""
    rng = np.random.default_rng(seed)
    gaps = rng.uniform(20, 300, int(rng.integers(1, 6)))
    cost = [rng.uniform(20, 400, (6, 6)) * (1 - np.eye(6))]
    for gap in gaps:
        cost.append(np.maximum(cost[-1] * rng.uniform(0.3, 1.7, (6, 6)), cost[-1] - 0.97 * gap))
    if seed % 4 == 0:
        cost[-1][0, 1] = np.inf
    window = float(rng.uniform(50, 900))
    return Travel(np.array(cost)[None], np.zeros(3, int), np.append(0.0, np.cumsum(gaps)), window=window)


def test_waiting_makes_a_route_flyable_and_lands_it_no_earlier() -> None:
    """A(t) = 0.64 t + 180: at once 180 s; 170 s of endurance are kept from t = 10/0.36 on."""
    wait, routes = 10 / 0.36, ((0,),)
    assert check_routes(calming(0.0), routes) == ["UAV 0 takes 180 s, more than its endurance of 170 s."]
    assert objective(calming(0.0), routes) == np.inf
    assert check_routes(calming(60.0), routes) == []
    assert take_offs(calming(60.0), routes) == pytest.approx([wait], rel=1e-12)
    assert objective(calming(60.0), routes) == pytest.approx(170 + wait, rel=1e-12)
    assert objective(calming(60.0), routes) > makespan(calming(60.0, None), routes) == pytest.approx(180)
    assert take_offs(calming(60.0, 181.0), routes) == [0.0]
    assert take_offs(calming(60.0), ((),)) == [0.0]


def test_a_window_too_short_is_said_with_the_least_flight() -> None:
    fault = ["UAV 0 takes 176.4 s, more than its endurance of 170 s however long it waits."]
    assert check_routes(calming(10.0), ((0,),)) == fault
    assert objective(calming(10.0), ((0,),)) == np.inf


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.permutations(range(3)), st.floats(0, 1000), st.floats(0, 1000))
def test_who_waits_never_lands_earlier(seed: int, order: list[int], early: float, late: float) -> None:
    travel, stops = wild(seed), np.array([3, *order, 3])
    early, late = sorted((early, late))
    landing = travel.tour_cost(0, stops, late)
    assert travel.tour_cost(0, stops, early) <= landing * (1 + 1e-12)


def bent(travel: Travel, stops: list[int], limit: float) -> float | None:
    """Return the earliest take-off within `limit`: A bends where a leg begins at a knot, found by bisection on A."""

    def arrival(time: float, legs: int) -> float:
        return travel.tour_cost(0, np.array(stops[: legs + 1]), time)

    bends = {0.0, travel.window}
    for legs in range(len(stops) - 1):
        for knot in travel.departures:
            low, high = 0.0, travel.window
            if arrival(low, legs) < knot < arrival(high, legs):
                for _ in range(80):
                    middle = (low + high) / 2
                    if middle in (low, high):  # nothing lies between them
                        break
                    low, high = (middle, high) if arrival(middle, legs) < knot else (low, middle)
                bends |= {low, high}
    all_legs = len(stops) - 1
    for a, b in pairwise(sorted(bends)):
        first, last = arrival(a, all_legs) - a, arrival(b, all_legs) - b
        if first <= limit:
            return a
        if last <= limit:
            return a + (b - a) * (first - limit) / (first - last) if np.isfinite(first) else b
    return None


def test_the_earliest_take_off_is_that_of_bends_by_bisection() -> None:
    seen = {"at once": 0, "later": 0, "never": 0}
    for seed in range(120):
        travel, rng = wild(seed), np.random.default_rng(seed)
        order = rng.permutation(3).tolist()
        at_once = travel.tour_cost(0, np.array([3, *order, 3]))
        if np.isinf(at_once):
            continue
        limit = float(at_once * rng.uniform(0.6, 1.01))
        instance = Instance.of_travel("wild", travel, 3, endurance=[limit] * 3)
        routes, wanted = (tuple(order), (), ()), bent(travel, [3, *order, 3], limit)
        assert (check_routes(instance, routes, all_tasks=False) == []) == (wanted is not None)
        found = take_offs(instance, routes)[0]
        assert 0 <= found <= travel.window
        if wanted is not None:
            assert found == pytest.approx(wanted, rel=1e-6, abs=1e-6)
            assert tour_costs(instance, routes)[0] - found <= limit * (1 + 1e-9)
        seen["never" if wanted is None else "later" if wanted > 0 else "at once"] += 1
    assert min(seen.values()) >= 3, seen


def test_a_tour_is_turned_round_only_where_that_is_within_endurance() -> None:
    """Flown one way it lands at 400 s and is past endurance; the other way waiting keeps it, and lands at 430 s."""
    legs = np.full((2, 3, 3), 100.0) * (1 - np.eye(3))
    legs[0, 2, 0], legs[1, 2, 0] = 230.0, 150.0  # depot to task 0: less from 100 s on
    legs[:, 2, 1] = 200.0
    travel = Travel(legs[None], np.array([0]), np.array([0.0, 100.0]), window=100.0)
    instance = Instance.of_travel("ways", travel, 2, endurance=[360.0])
    assert in_better_directions(instance, ((1, 0),)) == ((0, 1),) == in_better_directions(instance, ((0, 1),))


def test_it_is_an_axis_where_it_counts_and_changes_no_other_digest() -> None:
    assert calming(60.0).axes == {"time", "endurance", "window"}
    assert calming(60.0, None).axes == {"time"}
    assert calming(0.0).axes == {"time", "endurance"}
    assert len({calming(0.0).digest, calming(30.0).digest, calming(60.0).digest}) == 3
    assert instance_of(json.loads(document_text(calming(60.0)))).digest == calming(60.0).digest
    assert "window" not in json.loads(document_text(calming(0.0)))["travel"]


def test_a_wrong_window_is_named() -> None:
    for wrong in (-1.0, np.inf, np.nan, True, "soon"):
        with pytest.raises(InputError, match=r"travel\.window must be a time"):
            calming(wrong)  # type: ignore[arg-type]
    states = Travel(np.ones((1, 1, 3, 3)), np.array([0]), nodes=np.array([0, 0, 1]))
    with pytest.raises(InputError, match=r"travel\.window is 5\.0, which wants one state a node"):
        replace(states, window=5.0)
