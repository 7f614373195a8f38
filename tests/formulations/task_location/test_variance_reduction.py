"""Criterion "j": the table of surveys-that-learn, derivatives, greedy choices, and weights that tell."""

from __future__ import annotations

import math

import numpy as np
import pytest

from formulations.kernel import SquaredExponential
from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.nelder_mead import NelderMead
from formulations.task_location.placement import PlacementProblem, PlacementStatus, lattice, place
from formulations.task_location.registry import METHODS, make_method
from formulations.task_location.uncertainty import posterior_sd
from formulations.task_location.variance_reduction import VarianceChoice, VarianceReduction
from instances.environment.region import Region
from instances.errors import InputError

KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
SQUARE = Region.rectangle(20_000, 20_000)
GRID = SQUARE.cell_centres(20, 20)
WEST = np.where(GRID[:, 0] < 20_000 / 3, 10.0, 1.0)


def goal(cells: int = 6, weights: np.ndarray | None = None) -> VarianceReduction:
    return VarianceReduction(Criterion(KERNEL, SQUARE.cell_centres(cells, cells), weights))


@pytest.mark.parametrize(
    ("n", "weights", "least", "best"),
    [
        (5, None, 18.532, 20.434),
        (10, None, 11.839, 13.430),
        (20, None, 5.102, 5.962),
        (40, None, 1.289, 1.625),
        (20, WEST, 4.012, 4.800),
        (40, WEST, 1.049, 1.390),
    ],
)
def test_the_best_placements_known_and_what_none_leaves_less_than(n, weights, least, best):
    problem = PlacementProblem(SQUARE, VarianceReduction(Criterion(KERNEL, GRID, weights)), n)
    found = place(problem, make_method("nlp"), "nlp")
    assert found.maximised == "j"
    assert found.status is PlacementStatus.LOCALLY_SOLVED
    assert found.average_variance is not None
    assert found.average_variance_bound is not None
    left, bound = math.sqrt(found.average_variance), math.sqrt(found.average_variance_bound)
    assert left <= 1.01 * best
    assert bound == pytest.approx(least, abs=6e-4)
    if weights is None:
        assert 0.79 <= bound / left <= 1
    sd = posterior_sd(KERNEL, 1.0, found.points, GRID)
    assert left == pytest.approx(math.sqrt(np.average(sd**2, weights=weights)), rel=1e-9)


def test_weights_tell_under_j_and_hardly_under_b():
    west = GRID[:, 0] < 20_000 / 3

    def rms_west(maximised: Criterion | VarianceReduction) -> float:
        found = place(PlacementProblem(SQUARE, maximised, 20), make_method("l-bfgs-b", {"starts": 2}), "l-bfgs-b")
        return float(np.sqrt(np.mean(posterior_sd(KERNEL, 1.0, found.points, GRID[west]) ** 2)))

    weighted = Criterion(KERNEL, GRID, WEST)
    assert rms_west(VarianceReduction(weighted)) < 4.0 < 4.5 < rms_west(weighted)


@pytest.mark.parametrize(
    ("weight", "nats"),
    [(0.25, 2.598806724090), (1.0, 3.055456585020), (4.0, 3.290208623982), (100.0, 3.396777518382)],
)
def test_a_weight_under_b_is_so_many_readings(weight, nats):
    assert Criterion(KERNEL, np.zeros((1, 2)), np.array([weight])).value([[0, 0]]) == pytest.approx(nats, abs=1e-11)


def test_a_weight_of_two_under_b_is_the_point_listed_twice():
    tasks = np.array([[6000.0, 5000.0], [8000.0, 7000.0]])
    twice = Criterion(KERNEL, np.array([[5000.0, 5000.0], [5000.0, 5000.0], [9000.0, 5000.0]]))
    weighted = Criterion(KERNEL, np.array([[5000.0, 5000.0], [9000.0, 5000.0]]), np.array([2.0, 1.0]))
    assert weighted.value(tasks) == pytest.approx(2.2911574911286, abs=1e-12)
    assert twice.value(tasks) == pytest.approx(weighted.value(tasks), abs=1e-11)


def test_the_gradient_is_that_of_differences():
    about = goal(weights=np.random.default_rng(0).uniform(0, 1, 36))
    points, step = SQUARE.sample(5, np.random.default_rng(1)), 0.5
    here = about.slopes(points)
    assert here.value == pytest.approx(about.value(points), rel=1e-12)
    for j in range(10):
        move = (step * np.eye(1, 10, j)).reshape(5, 2)
        slope = (about.value(points + move) - about.value(points - move)) / (2 * step)
        assert here.gradient.ravel()[j] == pytest.approx(slope, rel=1e-5, abs=1e-10)


def test_greedy_and_exchanges_are_the_naive_ones():
    about, sites = goal(weights=np.linspace(0.1, 3.0, 36)), lattice(SQUARE, 7)
    chosen: list[int] = []
    choice = VarianceChoice(about, sites)
    for _ in range(5):
        worth = [about.value(sites[[*chosen, j]]) if j not in chosen else -1 for j in range(len(sites))]
        chosen.append(int(np.argmax(worth)))
        choice.add()
    assert choice.chosen == chosen
    exchange = VarianceChoice(about, sites, [0, 1, 2])
    assert exchange.improve(1)
    assert exchange.chosen[1] == max(set(range(49)) - {0, 2}, key=lambda j: about.value(sites[[0, j, 2]]))
    assert not exchange.improve(1)


@pytest.mark.parametrize("name", METHODS.targets())
def test_every_method_takes_it(name):
    found = place(PlacementProblem(SQUARE, goal(4), 3), make_method(name), name, seed=2)
    about = goal(4)
    assert found.average_variance == pytest.approx(about.judged.value(found.points), rel=1e-12)
    assert found.trace[-1][1] == pytest.approx(about.value(found.points), abs=1e-9)
    assert found.information["b"] == pytest.approx(about.under(Convention.BOTH_NOISY).value(found.points), abs=1e-9)
    assert {"average_variance", "average_variance_bound"} <= found.as_dict().keys()


def test_without_it_nothing_is_said_of_variances():
    found = place(PlacementProblem(SQUARE, goal(4).information, 3), make_method("grid"), "grid")
    assert "average_variance" not in found.as_dict()


def test_the_literal_form_is_refused():
    with pytest.raises(InputError, match="criterion j needs form=reduced"):
        place(PlacementProblem(SQUARE, goal(4), 3), NelderMead("literal"), "nelder-mead")
