"""Paths by departure: around walls in a wind that changes, flown, checked independently, against closed forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import box

from formulations.moving_cost.clocked import LegClock
from formulations.moving_cost.costing import instance_of
from formulations.moving_cost.departures import PLANS, PathClock
from instances import InputError, Instance, Travel, tour_costs, wind_flights
from instances.environment.region import Region
from instances.environment.wind_changing import ChangingWind, Drifting, Front, Turning
from instances.environment.wind_forecast import sampled
from instances.families import make_scenario
from instances.files import read_instance
from instances.fleet import Fleet
from instances.moving_cost import CostKind
from instances.paths import Paths, read_paths
from instances.paths_clocked import at_their_times, flown_from, tour_by_clock
from instances.scenario import Scenario
from instances.tour_figures import tour_figures
from instances.wind_arrivals import quickest_times, track_times
from instances.wind_flights import polyline_times
from workbench.planning import refute, write_plan

QUARTER = np.pi / 2 / 3600
SIDE = 20000.0
FRONT = Front((8.0, 3.0), (-6.0, -4.0), 8.0, 30.0, -3000.0, 2000.0)
WALL = box(9500.0, 3000.0, 10500.0, 17000.0)
TASKS = np.array([[4000.0, 5000.0], [16000.0, 6000.0], [15000.0, 15000.0]])
DEPOTS = np.array([[3000.0, 15000.0], [18000.0, 10000.0]])


def walled(wind: ChangingWind = FRONT, **more: object) -> Scenario:
    given = {"no_fly": [WALL], "cost": CostKind.TIME} | more
    return Scenario("walled", Region.rectangle(SIDE, SIDE), DEPOTS, 20.0, wind, TASKS, **given)


@pytest.fixture(scope="module")
def planned() -> tuple[Scenario, Instance, Paths]:
    scenario = walled()
    return scenario, *instance_of(scenario, options={"samples": 120})


def test_a_polyline_of_one_segment_is_a_track_and_bends_add_up() -> None:
    rng = np.random.default_rng(0)
    a, m, b = rng.uniform(0, SIDE, (3, 5, 2))
    begun = rng.uniform(0, 4000, 5)
    for wind in (FRONT, sampled(FRONT, Region.rectangle(SIDE, SIDE), np.arange(0.0, 3000.0, 250.0), 20)):
        points, offsets = np.stack([a, b], axis=1).reshape(-1, 2), np.arange(0, 11, 2)
        straight = polyline_times(points, offsets, np.arange(5), begun, wind, 20.0)
        assert straight == pytest.approx(track_times(a, b, begun, wind, 20.0), rel=2e-5)
        first = track_times(a, m, begun, wind, 20.0)
        both = first + track_times(m, b, begun + first, wind, 20.0)
        bent = np.stack([a, m, b, b], axis=1).reshape(-1, 2)
        assert polyline_times(bent, np.arange(0, 21, 4), np.arange(5), begun, wind, 20.0) == pytest.approx(
            both, rel=2e-5
        )
    with pytest.raises(InputError, match="not less than the airspeed of 5 m/s"):
        polyline_times(points, offsets, np.arange(5), begun, FRONT, 5.0)


def test_paths_around_a_wall_are_confirmed_and_what_is_wrong_is_refuted(
    planned: tuple[Scenario, Instance, Paths],
) -> None:
    scenario, instance, paths = planned
    assert instance.axes == {"time"}
    assert instance.travel is not None
    assert refute(instance, paths, scenario) == []
    for change in (0.98, 1.1):
        cost = instance.travel.cost.copy()
        cost[0, :, 1, 2] *= change
        wrong = Instance.of_travel("wrong", Travel(cost, instance.travel.classes, instance.travel.departures), 3,
                                   provenance=instance.provenance)  # fmt: skip
        assert "The path from 1 to 2 takes" in refute(wrong, paths, scenario)[0]
    assert "no-fly" in refute(instance, paths, replace(scenario, no_fly=[WALL.buffer(200.0)]))[0]


def test_whoever_departs_is_there_when_the_clock_says(planned: tuple[Scenario, Instance, Paths]) -> None:
    """Between knots too, and tours: never later than planned but for what is stated; and not much earlier."""
    scenario, instance, paths = planned
    travel, error = instance.travel, instance.provenance["clock"]["error"]
    assert travel is not None
    assert isinstance(scenario.wind, Front)
    for begun in np.random.default_rng(3).uniform(0, travel.departures[-1], 6):
        line = flown_from(paths, 2, 0, float(begun), scenario.wind, 20.0)
        one = np.zeros(1, dtype=np.int64)
        took = polyline_times(line, np.array([0, len(line)]), one, np.array([begun]), scenario.wind, 20.0)[0]
        knot = int(np.searchsorted(travel.departures, begun, side="right")) - 1
        share = (begun - travel.departures[knot]) / np.diff(travel.departures)[knot]
        said = (1 - share) * travel.cost[0, knot, 2, 0] + share * travel.cost[0, knot + 1, 2, 0]
        assert said * 0.985 <= took <= said + error
    figures = tour_figures(paths, ((0, 2), (1,)), 3, scenario.wind, 20.0)
    assert [each.flight_time for each in figures] == pytest.approx(tour_costs(instance, ((0, 2), (1,))), rel=0.01)
    flown = at_their_times(paths, [(3, 0, 2, 3), (4, 1, 4)], scenario.wind, 20.0)
    legs, _ = tour_by_clock(paths, (3, 0, 2, 3), scenario.wind, 20.0)
    np.testing.assert_array_equal(flown.between(0, 2), legs[1])
    np.testing.assert_array_equal(flown.between(1, 0), paths.between(1, 0))


def test_flights_of_many_departures_are_those_of_each(
    planned: tuple[Scenario, Instance, Paths], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In any order, and in groups of any size: which plans lie beside a departure does not change with the others."""
    scenario, _, paths = planned
    clock, times = PathClock(scenario, [paths]), np.array([900.0, 0.0, 5000.0, 1700.0])
    each = np.concatenate([clock.at(times[k : k + 1]) for k in range(4)], axis=1)
    monkeypatch.setattr(wind_flights, "TOGETHER", 7)
    np.testing.assert_allclose(clock.at(times), each, rtol=wind_flights.TOLERANCE)


def test_paths_by_the_clock_are_never_later_than_those_for_winds_that_stay(
    planned: tuple[Scenario, Instance, Paths],
) -> None:
    scenario, instance, paths = planned
    assert instance.travel is not None
    assert len(paths.later) == 2 * PLANS - 1
    staying = replace(paths, later=paths.later[: PLANS - 1], departures=paths.departures[: PLANS - 1])
    both, alone = (PathClock(scenario, [each]).at(instance.travel.departures) for each in (paths, staying))
    assert (both <= alone * (1 + wind_flights.TOLERANCE)).all()
    assert (both < 0.99 * alone).any()


@pytest.mark.slow
def test_later_plans_are_of_use() -> None:
    """When vortices have drifted by, the ways of before take longer than those planned for then."""
    whirls = Drifting((2.0, 0.0), (6.0, 0.0), ((4000.0, 6000.0), (4000.0, 14000.0)), (2e5, -2e5), (2500.0, 2500.0))
    scenario = walled(whirls, no_fly=())
    instance, paths = instance_of(scenario, options={"samples": 300})
    assert instance.travel is not None
    late = np.full(25, float(instance.travel.departures[-1]))
    first, last = (
        polyline_times(plan.points, plan.offsets, np.arange(25), late, whirls, 20.0)
        for plan in (paths, paths.later[-1])
    )
    assert (first / np.maximum(last, 1.0)).max() > 1.05


def test_files_keep_them(planned: tuple[Scenario, Instance, Paths], tmp_path: Path) -> None:
    scenario, instance, paths = planned
    write_plan(instance, paths, tmp_path / "a.json", tmp_path / "a.toml")
    again = read_instance(tmp_path / "a.json")
    assert again.digest == instance.digest
    kept = read_paths(tmp_path / "a.paths.json.gz", again)
    assert kept.departures == paths.departures
    assert refute(again, kept, scenario) == []


def test_a_turning_wind_is_an_oracle() -> None:
    """Straight tracks, which is what is planned in a uniform wind, take little longer than the quickest ways."""
    scenario = make_scenario("wind-turning", 5, 2, 1)
    instance, paths = instance_of(scenario, "closed-form")
    assert instance.travel is not None
    assert isinstance(scenario.wind, Turning)
    assert refute(instance, paths, scenario) == []
    i, j = np.nonzero(~np.eye(7, dtype=bool))
    for knot, begun in list(enumerate(instance.travel.departures))[::7]:
        least = quickest_times(scenario.points[j] - scenario.points[i], np.full(42, begun), scenario.wind, 20.0)
        share = instance.travel.cost[0, knot, i, j] / least
        assert (share.min() >= 1 - 1e-5, share.max() <= 1.02) == (True, True)


def test_a_wind_that_does_not_turn_gives_the_costs_of_one_that_stays() -> None:
    still = walled(Turning((6.0, -4.0), 0.0), fleet=Fleet(service=60.0))
    instance, _ = instance_of(still, options={"samples": 200})
    once, _ = instance_of(replace(still, wind=still.wind.at(0.0)), options={"samples": 200})
    assert instance.travel is not None
    assert instance.travel.cost[0, -1] == pytest.approx(once.cost, rel=3e-4)
    assert LegClock(replace(still, no_fly=())).at(np.zeros(1))[0, 0] == pytest.approx(
        instance_of(replace(still, no_fly=(), wind=still.wind.at(0.0)), "closed-form")[0].cost
    )
