"""Costs that change with time: knots, their stated error, service, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely.geometry import box

from formulations.moving_cost.clocked import ANGLE, LegClock, clocked_instance
from formulations.moving_cost.costing import query_of
from formulations.moving_cost.families import generate
from instances import InputError, tour_costs
from instances.environment.wind_changing import Turning
from instances.families import make_scenario
from instances.fleet import Fleet
from instances.wind_arrivals import quickest_times

CHANGING = ("wind-turning", "wind-valley", "wind-front", "wind-drifting")


@pytest.mark.parametrize("name", CHANGING)
def test_between_knots_legs_are_off_by_no_more_than_is_stated(name: str) -> None:
    scenario, instance = make_scenario(name, 5, 2, 3), generate(name, 5, 2, 3)
    assert instance.travel is not None
    knots, costs = instance.travel.departures, instance.travel.cost[0]
    times = np.random.default_rng(0).uniform(0, knots[-1], 40)
    true = LegClock(scenario).at(times)[0]
    rows = np.searchsorted(knots, times, side="right") - 1
    share = ((times - knots[rows]) / np.diff(knots)[rows])[:, None, None]
    off = np.abs(costs[rows] + share * (costs[rows + 1] - costs[rows]) - true).max()
    assert off <= 1.2 * instance.provenance["clock"]["error"], "halfway it is greatest, nearly"
    assert off > 0.0
    assert instance.axes == {"time"}


def test_knots_are_as_near_as_the_wind_turns() -> None:
    instance = generate("wind-turning", 12, 3, 0, turning=180)
    assert np.pi / 3600 * instance.provenance["clock"]["step"] <= ANGLE * (1 + 1e-12)


def test_whole_tours_are_off_by_seconds_at_most() -> None:
    """A tour of interpolated legs against the same legs by Newton's method, one after the other."""
    instance, scenario = generate("wind-turning", 8, 2, 1), make_scenario("wind-turning", 8, 2, 1)
    assert isinstance(scenario.wind, Turning)
    routes, time = ((0, 3, 5, 1), (2, 4, 6, 7)), 0.0
    for i, j in zip((8, 0, 3, 5, 1), (0, 3, 5, 1, 8), strict=True):
        way = scenario.points[j] - scenario.points[i]
        time += float(quickest_times(way[None], np.array([time]), scenario.wind, 20.0)[0])
    assert tour_costs(instance, routes)[0] == pytest.approx(time, rel=2e-4)


def test_a_window_reaches_the_instance_and_its_knots_reach_as_far() -> None:
    scenario = make_scenario("wind-turning", 4, 2, 0)
    at_once, waiting = (
        clocked_instance(replace(scenario, fleet=Fleet(endurance=np.full(2, 900.0), window=window)))
        for window in (0.0, 1200.0)
    )
    assert at_once.travel is not None
    assert waiting.travel is not None
    assert (at_once.axes, waiting.axes) == ({"time", "endurance"}, {"time", "endurance", "window"})
    assert waiting.travel.window == 1200.0
    assert waiting.travel.departures[-1] >= at_once.travel.departures[-1] + 1200.0


def test_a_wind_that_turns_too_fast_for_knots_is_refused() -> None:
    scenario = replace(make_scenario("wind-turning", 4, 2, 0), wind=Turning((5.0, 0.0), 90.0))
    with pytest.raises(InputError, match=r"the wind turns by 90 rad/s, which asks for \d+ knots of departure"):
        clocked_instance(scenario)


def test_service_is_spent_before_and_after_the_leg() -> None:
    scenario = make_scenario("wind-turning", 2, 1, 0)
    serving = replace(scenario, fleet=Fleet(service=np.array([600.0, 60.0])))
    later = LegClock(scenario).at(np.array([300.0]))[0, 0, 0, 1]
    assert LegClock(serving).at(np.zeros(1))[0, 0, 0, 1] == pytest.approx(later + 300 + 30, rel=1e-12)
    assert clocked_instance(serving).axes == {"time"}


def test_fleets_have_a_clock_for_each_speed() -> None:
    scenario = make_scenario("wind-turning", 4, 2, 0)
    fleet = replace(scenario, fleet=Fleet(np.array([20.0, 30.0]), np.array([3000.0, np.inf])))
    instance = clocked_instance(fleet)
    assert instance.axes == {"fleet", "time", "endurance"}


def test_what_is_refused() -> None:
    scenario = make_scenario("wind-turning", 4, 2, 0)
    x, y = scenario.region.sample(1, np.random.default_rng(1))[0]
    with pytest.raises(InputError, match="no legs around no-fly zones"):
        clocked_instance(replace(scenario, no_fly=[box(x, y, x + 1, y + 1)]))
    with pytest.raises(InputError, match="its wind changes with time"):
        query_of(scenario)
    with pytest.raises(InputError, match="energy is no clock"):
        replace(scenario, cost="energy")
    with pytest.raises(InputError, match="not less than the airspeed of 9 m/s"):
        generate("wind-turning", 4, 2, 0, airspeed=9)
    with pytest.raises(InputError, match="family wind-turning: depots: the paper's are 3, not 2"):
        generate("wind-turning", 4, 2, 0, depots="paper")
