"""Path polish: less stays unknown, no UAV flies further than it may or where it must not, and what is known counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon

from formulations.average_variance import AverageVariance
from formulations.kernel import SquaredExponential
from formulations.mapping.flight import plan_flight
from formulations.polish.path_polish import PolishProblem, polish, split
from formulations.polish.straight_legs import StraightLegs
from instances.environment.region import Region
from instances.environment.wind import Rotation
from instances.errors import InputError
from instances.moving_cost import CostKind, CostMeasure

SQUARE = Region.rectangle(20_000, 20_000)
HOLED = Region(Polygon(SQUARE.polygon.exterior, [[(6000, 4000), (14_000, 4000), (14_000, 9000), (6000, 9000)]]))
KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
CALM = StraightLegs(100.0, 100.0)
DEPOTS = np.array([[1000.0, 1000.0], [19_000.0, 1000.0]])
TOURS = [
    np.array([DEPOTS[0], [3000, 8000], [8000, 12_000], [4000, 3000], DEPOTS[0]]),
    np.array([DEPOTS[1], [16_000, 12_000], [12_000, 16_000], [17_000, 3000], DEPOTS[1]]),
]


def problem(region=SQUARE, known=(), **changed):
    judged = AverageVariance(KERNEL, 1.0, region.cell_centres(6, 6), known=np.reshape(known, (-1, 2)))
    given = {"legs": CALM, "period": 20.0, "paths": TOURS, "budgets": np.array([330.0, 400.0]), "room": region}
    return PolishProblem(judged, **{**given, **changed})


def test_less_stays_unknown_within_every_budget():
    asked = problem()
    found = polish(asked)
    assert found.moved.all()
    assert found.after < 0.6 * found.before
    assert (found.costs <= asked.budgets).all()
    assert (found.costs > 0.98 * asked.budgets).all()  # endurance is used
    assert found.after == pytest.approx(asked.value(found.paths), rel=1e-12)
    for path, tour in zip(found.paths, TOURS, strict=True):
        assert (path[[0, -1]] == tour[[0, -1]]).all()
        assert SQUARE.contains(path).all()


def test_a_flight_with_turns_fits_too():
    def flown(uav, path):
        return plan_flight([path], speed=100.0, radius=300.0).length / 100.0, True

    asked = problem(flown=flown, period=10.0)
    found = polish(asked)
    assert found.moved.all()
    assert (np.array([flown(k, path)[0] for k, path in enumerate(found.paths)]) <= asked.budgets).all()


def test_zones_are_not_entered_and_what_cannot_be_flown_is_not():
    asked = problem(HOLED)
    found = polish(asked)
    assert found.after < found.before
    room = HOLED.polygon.buffer(0.01)
    assert all(room.covers(shapely.linestrings(path)) for path in found.paths)
    kept = polish(problem(flown=lambda uav, path: (0.0, len(path) == len(TOURS[0]))))
    assert not kept.moved.any()
    assert kept.after == kept.before


@pytest.mark.parametrize("kind", CostKind)
def test_in_a_wind_the_cost_is_what_is_kept(kind):
    measure = CostMeasure(kind, Rotation(2e-3, (10_000.0, 10_000.0)), 100.0)
    legs = StraightLegs.of(measure, SQUARE, 100.0, 100.0)
    found = polish(problem(legs=legs), spacing=5000.0, warm=True)
    exact = [measure.segments(path[:-1], path[1:]).sum() for path in found.paths]
    assert found.after < found.before
    assert exact == pytest.approx(found.costs, rel=1e-6)
    assert (np.array(exact) <= [330.0, 400.0]).all()


def test_from_where_the_uavs_are_what_is_known_is_not_sensed_again():
    home = np.array([1000.0, 1000.0])
    aloft = np.array([[4000.0, 9000.0], [10_000.0, 2000.0], home])
    known = SQUARE.cell_centres(6, 6)
    west = known[known[:, 0] < 10_000]
    found = polish(problem(known=west, paths=[aloft, np.empty((0, 2))], budgets=np.array([400.0, 0.0])), warm=True)
    assert (found.paths[0][[0, -1]] == aloft[[0, -1]]).all()
    assert len(found.paths[1]) == 0
    assert found.costs[0] <= 400.0
    assert found.costs[1] == 0.0
    assert (found.paths[0][:, 0] > 10_000).sum() > (aloft[:, 0] > 10_000).sum()


def test_where_the_field_drifts_late_readings_are_worth_more():
    judged = AverageVariance(KERNEL, 1.0, SQUARE.cell_centres(6, 6), tau=200.0)
    drifting, stays = (replace(problem(), judged=replace(judged, tau=tau)) for tau in (200.0, np.inf))
    found, other = polish(drifting), polish(stays)
    assert found.after < found.before
    assert found.after == pytest.approx(drifting.value(found.paths), rel=1e-12)
    assert found.after < 0.999 * drifting.value(other.paths)
    later = polish(replace(drifting, start=500.0))  # nothing is known before, so that the clock may start anywhere
    assert later.after == pytest.approx(found.after, rel=1e-9)


def test_who_has_no_endurance_left_keeps_the_way():
    found = polish(problem(budgets=np.array([330.0, 0.0])))
    assert found.moved.tolist() == [True, False]
    assert (found.paths[1] == TOURS[1]).all()


def test_legs_are_split_evenly():
    path = split(np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 3.0]]), 4.0)
    assert path == pytest.approx(np.array([[0, 0], [10 / 3, 0], [20 / 3, 0], [10, 0], [10, 3]]))


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [({"period": 0.0}, "period must be positive"), ({"budgets": np.ones(3)}, "2 paths need as many finite budgets")],
)
def test_what_makes_no_sense_is_refused(changed, sentence):
    with pytest.raises(InputError, match=sentence):
        problem(**changed)
    with pytest.raises(InputError, match="spacing of waypoints must be positive, got -1"):
        polish(problem(), spacing=-1.0)
