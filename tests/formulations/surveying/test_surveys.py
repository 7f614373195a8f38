"""Tours, readings, noise and drawn fields: closed forms, laws, and every planner inside its limits."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from shapely import Polygon

from formulations.kernel import Matern12, SquaredExponential
from formulations.limits import Limits
from formulations.surveying.gaussian_field import gaussian_field
from formulations.surveying.problem import Sensor, SurveyProblem, length_of, noise, readings
from formulations.surveying.registry import PLANNERS
from formulations.surveying.verification import measured, reading_faults, tour_faults, worth_of
from instances.environment.region import Region
from instances.environment.wind import Shear
from instances.moving_cost import CostKind, CostMeasure

KERNEL = SquaredExponential(30.0, (2500.0, 2500.0))


def problem(length: float = 14_000.0, region: Region | None = None) -> SurveyProblem:
    """Return two UAVs over 6 by 5 km."""
    depots = np.array([[500.0, 500.0], [5500.0, 4500.0]])
    return SurveyProblem(region or Region.rectangle(6000.0, 5000.0), depots, length, 500.0, KERNEL, 1.0)


def flat(points: np.ndarray) -> np.ndarray:
    return points[:, 0] / 1000.0


def test_readings_lie_at_equal_steps_of_the_way():
    around = np.array([[0.0, 0.0], [3000.0, 0.0], [3000.0, 4000.0], [0.0, 0.0]])
    assert length_of(around) == 12_000.0
    at = readings(around, 2500.0)
    assert at == pytest.approx(np.array([[2500, 0], [3000, 2000], [2700, 3600], [1200, 1600]]), abs=1e-9)
    assert len(readings(around, 4000.0)) == 3  # the last on landing
    assert len(readings(np.empty((0, 2)), 1.0)) == 0


def test_whoever_measures_draws_the_same_noise():
    whole = noise(2.0, 7, 1, range(1, 6))
    sensor = Sensor(flat, 2.0, 7)
    first, rest = sensor.read(1, 1, np.zeros((2, 2))), sensor.read(1, 3, np.zeros((3, 2)))
    assert np.concatenate([first, rest]).tolist() == whole.tolist()
    assert [row[:2] for row in sensor.log] == [(1, tick) for tick in range(1, 6)]
    for other in (noise(2.0, 8, 1, range(1, 6)), noise(2.0, 7, 0, range(1, 6))):
        assert not np.isin(other, whole).any()


def test_the_judge_measures_what_the_sensor_read():
    given = problem()
    tours = [np.stack([depot, given.region.polygon.centroid.coords[0], depot]) for depot in given.depots]
    sensor = Sensor(flat, 1.0, 3)
    read = [sensor.read(uav, 1, readings(tour, given.spacing)) for uav, tour in enumerate(tours)]
    positions, values = measured(given, tours, flat, 3)
    assert sorted(values) == pytest.approx(sorted(np.concatenate(read)), abs=1e-12)
    assert positions[:2].tolist() == [readings(tour, given.spacing)[0].tolist() for tour in tours]


@pytest.mark.parametrize("kernel", [SquaredExponential, Matern12])
def test_a_drawn_field_has_the_covariance_of_its_kernel(kernel):
    made = [gaussian_field(kernel(3.0, (2000.0, 1000.0)), (0.0, 0.0, 4000.0, 2000.0), 8, seed) for seed in range(1500)]
    values = np.array([field.values for field in made])  # nodes every 500 m
    assert values.shape == (1500, 5, 9)
    model = kernel(3.0, (2000.0, 1000.0))
    for here, there in (((0, 0), (0, 0)), ((0, 0), (0, 4)), ((1, 2), (3, 2))):
        estimate = np.mean(values[:, *here] * values[:, *there])
        exact = model(*(500.0 * np.array([at[::-1]]) for at in (here, there)))[0, 0]
        assert estimate == pytest.approx(exact, abs=5 * 9.0 * np.sqrt(2 / 1500))


def square(depot: np.ndarray, side: float) -> np.ndarray:
    return depot + side * np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])


def honest(given: SurveyProblem) -> tuple[list[np.ndarray], list[np.ndarray]]:
    tours = [square(given.depots[0], 2000.0), square(given.depots[1], -2000.0)]
    return tours, [readings(tour, given.spacing) for tour in tours]


def test_honest_tours_have_no_fault():
    given = problem()
    assert tour_faults(given, *honest(given)) == []
    home = [np.empty((0, 2))] * 2
    assert tour_faults(given, home, home) == []


LIES = {
    "too long": (lambda tours, samples: tours.__setitem__(0, square(tours[0][0], 3600.0)), "more than the 14000 m"),
    "outside": (lambda tours, samples: tours.__setitem__(0, square(tours[0][0], -600.0)), "up to 141.421 m outside"),
    "no way home": (lambda tours, samples: tours.__setitem__(0, tours[0][:-1]), "ends 2000 m from its depot"),
    "from elsewhere": (lambda tours, samples: tours.__setitem__(0, tours[0] + 5.0), "starts 7.07"),
    "another's depot": (lambda tours, samples: tours.reverse(), "from its depot"),
    "one sample left out": (lambda tours, samples: samples.__setitem__(0, samples[0][1:]), "15 samples where 16"),
    "samples elsewhere": (lambda tours, samples: samples[0].__setitem__(3, [9.0, 9.0]), "m from where it was"),
    "a UAV missing": (lambda tours, samples: tours.pop(), "of 1 and samples of 2 UAVs for 2 depots"),
    "no number": (lambda tours, samples: samples[1].__setitem__(0, np.nan), "not finite"),
}


@pytest.mark.parametrize("name", LIES)
def test_a_lie_about_tours_is_told(name):
    given = problem()
    tours, samples = honest(given)
    edit, sentence = LIES[name]
    edit(tours, samples)
    assert sentence in "; ".join(tour_faults(given, tours, samples))


def test_readings_in_flight_are_where_and_when_the_uav_was():
    given = problem()
    tours, samples = honest(given)
    rows = [(uav, tick, *samples[uav][tick - 1]) for tick in (1, 2) for uav in (0, 1)]
    assert reading_faults(given, tours, rows) == []
    assert "not in the order of time" in reading_faults(given, tours, rows[::-1])[0]
    assert "was elsewhere" in reading_faults(given, tours, [(0, 1, *samples[0][1])])[0]
    assert "never measured" in reading_faults(given, tours, [(0, 99, 0.0, 0.0)])[0]
    assert "never measured" in reading_faults(given, tours, [(2, 1, 0.0, 0.0)])[0]


def test_in_a_wind_energy_is_what_may_not_be_exceeded():
    measure = CostMeasure(CostKind.ENERGY, Shear(4e-3, (3000.0, 2500.0)), 40.0)  # 8 m/s west below, east above
    given = replace(problem(), depots=np.array([[500.0, 500.0]]), measure=measure)
    against = np.array([[500, 500], [3500, 500], [3500, 4500], [500, 4500], [500, 500]], dtype=float)
    assert given.cost_of(against) == pytest.approx(14_000.0 + 6000.0 * 8.0 / 40.0)
    at = readings(against, given.spacing)
    assert "spends 15200 m of calm air in the wind" in tour_faults(given, [against], [at])[0]
    assert tour_faults(given, [against[::-1]], [readings(against[::-1], given.spacing)]) == []


@pytest.mark.parametrize("name", PLANNERS.built_in)
class TestEveryPlanner:
    """What holds for every planner that comes along."""

    def test_it_keeps_the_rules_and_repeats_itself(self, name):
        given, planner = problem(length=7500.0), PLANNERS.make(name)
        if name in ("sgptools", "pypolo") and (missing := planner.accepts(given)):
            pytest.skip(missing)
        assert planner.accepts(given) is None
        planner.prepare(given)
        field = gaussian_field(KERNEL, given.region.bounds, 40, 1)
        made = []
        for _ in range(2):
            sensor = Sensor(field, 1.0, 5)
            tours = planner.plan(given, sensor, limits=Limits(), seed=3)
            assert tour_faults(given, tours, [readings(tour, given.spacing) for tour in tours]) == []
            assert reading_faults(given, tours, sensor.log) == []
            made.append([tour.tolist() for tour in tours])
        assert made[0] == made[1]
        worth = worth_of(given, [np.array(tour) for tour in made[0]], field, given.targets, 5)
        assert worth.longest <= given.length
        assert worth.samples >= 10  # of 30: endurance is used

    def test_wind_and_a_zone_are_kept_to_or_declined(self, name):
        around = Polygon([(0, 0), (6000, 0), (6000, 5000), (0, 5000)], [[(2500, 1500), (3500, 1500), (3500, 3500)]])
        measure = CostMeasure(CostKind.ENERGY, Shear(4e-3, (3000.0, 2500.0)), 30.0)  # 10 m/s at the borders
        given = replace(problem(length=7500.0, region=Region(around)), measure=measure)
        planner = PLANNERS.make(name, {"steps": 200} if "steps" in PLANNERS.defaults(name) else {})
        if why := planner.accepts(given):
            assert re.search("convex|wind|installed|numpy", why)
            return
        tours = planner.plan(given, Sensor(flat, 1.0, 0), limits=Limits(), seed=0)
        assert tour_faults(given, tours, [readings(tour, given.spacing) for tour in tours]) == []
        spent = [given.cost_of(tour) for tour in tours]
        assert 0.0 < max(spent) <= given.length

    def test_what_cannot_be_flown_at_all_is_declined_or_nobody_flies(self, name):
        given, planner = problem(length=550.0), PLANNERS.make(name)
        if planner.accepts(given) is None:
            tours = planner.plan(given, Sensor(flat, 1.0, 0), limits=Limits(), seed=0)
            assert tour_faults(given, tours, [readings(tour, given.spacing) for tour in tours]) == []
