"""Costs of straight legs and places of samples: the exact ones, and slopes as by differences."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import Polygon

from formulations.average_variance import AverageVariance
from formulations.kernel import SquaredExponential
from formulations.polish.objective import Objective
from formulations.polish.sampling import Samples, count_of
from formulations.polish.straight_legs import StraightLegs
from instances.environment.region import Region
from instances.environment.wind import Rotation, Shear, Uniform
from instances.moving_cost import CostKind, CostMeasure

SQUARE = Region.rectangle(20_000, 20_000)
WINDS = {
    "uniform": Uniform((9.0, -4.0)),
    "shear": Shear(1e-3, (0.0, 10_000.0)),
    "rotation": Rotation(1e-3, (9000.0, 11_000.0)),
}
PATH = np.array([[1000.0, 1000.0], [4200.0, 1800.0], [5000.0, 6000.0], [3000.0, 7000.0], [9000.0, 9000.0]])
FREE = Polygon([(0, 0), (20_000, 0), (20_000, 20_000), (0, 20_000)], [[(2000, 4000), (6000, 4000), (4000, 6500)]])


def differences(function, places, step=0.01):
    """Return the central differences of a function of `places` (k, 2), shape (…, k, 2)."""
    slopes = []
    for at in np.ndindex(places.shape):
        there, back = places.copy(), places.copy()
        there[at] += step
        back[at] -= step
        slopes.append((np.asarray(function(there)) - function(back)) / (2 * step))
    return np.moveaxis(np.array(slopes), 0, -1).reshape(*np.shape(slopes[0]), *places.shape)


@pytest.mark.parametrize("kind", CostKind)
@pytest.mark.parametrize("wind", WINDS.values(), ids=list(WINDS))
def test_costs_are_those_of_the_wind_and_slopes_those_of_the_costs(kind, wind):
    measure = CostMeasure(kind, wind, 40.0)
    legs = StraightLegs.of(measure, SQUARE, 40.0, 30.0)
    costed = legs(PATH)
    assert costed.cost == pytest.approx(measure.segments(PATH[:-1], PATH[1:]), rel=1e-6)
    flown = costed.cost if kind is CostKind.TIME else np.hypot(*np.diff(PATH, axis=0).T) / 30.0
    assert costed.duration == pytest.approx(flown, rel=1e-12)
    for name in ("cost", "duration"):
        slopes = differences(lambda path, name=name: getattr(legs(path), name).sum(), PATH)
        found = np.zeros_like(PATH)
        found[:-1] += getattr(costed, f"{name}_slopes")[:, 0]
        found[1:] += getattr(costed, f"{name}_slopes")[:, 1]
        assert found == pytest.approx(slopes, abs=1e-8)


def test_legs_without_length_cost_nothing_and_slope_nowhere():
    costed = StraightLegs(100.0, 100.0)(np.array([[5.0, 5.0], [5.0, 5.0]]))
    assert costed.cost == pytest.approx(0.0, abs=1e-9)
    assert not costed.cost_slopes.any()


def test_samples_are_a_period_apart_along_the_path_and_end_with_it():
    legs = StraightLegs(100.0, 100.0)
    durations = legs(PATH).duration
    count = count_of(durations.sum(), 10.0)
    places = Samples.along(PATH, durations, 10.0, count + 2).places
    ends = np.concatenate([[0.0], np.cumsum(durations)])
    along = 10.0 * np.arange(1, count + 1)
    exact = np.column_stack([np.interp(along, ends, PATH[:, d]) for d in (0, 1)])
    assert places[:count] == pytest.approx(exact, abs=1e-8)
    assert (places[count:] == PATH[-1]).all()
    assert count * 10.0 <= durations.sum() < (count + 1) * 10.0


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("wind", [None, *WINDS.values()], ids=["calm", *WINDS])
def test_slopes_of_the_objective(wind, held):
    measure = None if wind is None else CostMeasure(CostKind.TIME, wind, 40.0)
    legs = StraightLegs.of(measure, SQUARE, 40.0, 40.0)
    judged = AverageVariance(SquaredExponential(30.0, (3000.0, 4000.0)), 1.0, SQUARE.cell_centres(8, 8))
    paths = [PATH, PATH[::-1] + np.array([8000.0, 9000.0])]
    budgets = np.array([0.8, 1.2]) * [legs(path).cost.sum() for path in paths]
    objective = Objective(judged, legs, 11.0, paths, budgets, 50.0, FREE, FREE.buffer(-2500), held)
    begin = objective.begin + 0.01
    value, gradient = objective(begin)
    alone = Objective(judged, legs, 11.0, paths, 10 * budgets, 50.0, held=held)
    assert value > alone(begin)[0]  # one path costs too much and runs through the hole
    found = differences(lambda places: objective(places.ravel())[0], begin.reshape(-1, 2), 1e-6).ravel()
    assert gradient == pytest.approx(found, abs=1e-5 * np.abs(gradient).max())
