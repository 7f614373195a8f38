"""I(y_T; y_o | y_S): the chain rule, its gradient, and what placing by it gains."""

import numpy as np
import pytest

from formulations.average_variance import AverageVariance
from formulations.kernel import SquaredExponential
from formulations.replanning.conditional import ConditionalInformation, place_remaining
from formulations.replanning.remaining import RemainingVariance
from formulations.task_location.criterion import Criterion
from formulations.task_location.derivatives import Expansion
from formulations.task_location.placement import lattice
from instances.environment.region import Region
from instances.environment.value_map import ValueMap

SQUARE = Region.rectangle(20e3, 20e3)
TESTS = SQUARE.cell_centres(10, 10)


@pytest.mark.parametrize(("seed", "scales"), [(0, (4000.0, 4000.0)), (1, (10e3, 10e3)), (2, (3000.0, 6000.0))])
def test_the_conditional_form_is_the_difference_of_the_criterion(seed, scales):
    rng = np.random.default_rng(seed)
    tasks, known = rng.uniform(0, 20e3, (5, 2)), rng.uniform(0, 20e3, (30, 2))
    kernel = SquaredExponential(30.0, scales)
    criterion, both = Criterion(kernel, TESTS), np.concatenate([tasks, known])
    value, gradient = ConditionalInformation(kernel, TESTS, known, 1.0)(tasks)
    assert value == pytest.approx(criterion.value(both) - criterion.value(known), abs=5e-11)
    assert np.allclose(gradient, Expansion(criterion, both).gradient[:5], rtol=1e-6, atol=1e-11)


def test_a_weight_is_a_number_of_readings_of_a_test_point_as_in_the_criterion():
    rng = np.random.default_rng(6)
    tasks, known, weights = rng.uniform(0, 20e3, (4, 2)), rng.uniform(0, 20e3, (9, 2)), rng.uniform(0, 9, len(TESTS))
    weights[::7] = 0.0
    criterion = Criterion(SquaredExponential(), TESTS, weights)
    value = ConditionalInformation(SquaredExponential(), TESTS, known, 1.0, weights=weights)(tasks)[0]
    both = np.concatenate([tasks, known])
    assert value == pytest.approx(criterion.value(both) - criterion.value(known), rel=1e-9)


@pytest.mark.parametrize("tau", [np.inf, 100.0])
def test_what_remains_is_placed_for_targets_that_count(tau):
    rng = np.random.default_rng(7)
    known, times, weights = (
        rng.uniform(0, 20e3, (12, 2)),
        rng.uniform(0, 90, 12),
        np.where(TESTS[:, 0] < 8e3, 50.0, 1.0),
    )
    judged = AverageVariance(SquaredExponential(), 1.0, TESTS, weights, known, tau, times)
    worth, sites = RemainingVariance(judged, 120.0), lattice(SQUARE, 6)
    chosen = worth.greedy(sites, 3)
    best = max(sites, key=lambda site: worth(np.vstack([chosen[:2], site]))[0])
    assert (chosen[2] == best).all()
    placed = place_remaining(worth, SQUARE, chosen)
    assert worth(placed)[0] > worth(chosen)[0]
    assert (placed[:, 0] < 10e3).all()
    gradient = worth(chosen)[1]
    for i, d in np.ndindex(chosen.shape):
        moved = [worth(chosen + sign * np.eye(6)[2 * i + d].reshape(3, 2))[0] for sign in (1, -1)]
        assert gradient[i, d] == pytest.approx((moved[0] - moved[1]) / 2.0, rel=1e-4, abs=1e-9)


def test_with_nothing_known_it_is_the_criterion_itself_and_what_is_known_is_worth_no_second_look():
    rng = np.random.default_rng(3)
    tasks, kernel = rng.uniform(0, 20e3, (6, 2)), SquaredExponential()
    nothing = ConditionalInformation(kernel, TESTS, np.empty((0, 2)), 1.0)(tasks)[0]
    assert nothing == pytest.approx(Criterion(kernel, TESTS).value(tasks), rel=1e-12)
    assert ConditionalInformation(kernel, TESTS, np.repeat(tasks, 5, axis=0), 1.0)(tasks)[0] < 0.1 * nothing


def test_placing_ascends_from_the_greedy_choice_and_stays_inside():
    known = np.random.default_rng(4).uniform(0, 20e3, (40, 2))
    worth = ConditionalInformation(SquaredExponential(), TESTS, known, 1.0)
    sites = Region(SQUARE.polygon.buffer(-500.0))
    begin = worth.greedy(lattice(sites, 15), 8)
    placed = place_remaining(worth, sites, begin)
    assert len(np.unique(begin, axis=0)) == 8
    assert sites.signed_distance(placed).min() > -1e-6
    assert worth(placed)[0] > worth(begin)[0] + 0.1


def test_the_gradient_holds_for_a_map_of_the_prior_sd_and_for_old_readings():
    rng = np.random.default_rng(5)
    x = np.linspace(0.0, 20e3, 5)
    prior = ValueMap(x, x, rng.uniform(10.0, 30.0, (5, 5)))
    kernel = SquaredExponential.of_prior(prior, (4000.0, 5000.0))
    tasks, known = rng.uniform(1e3, 19e3, (4, 2)), rng.uniform(0, 20e3, (12, 2))
    worth = ConditionalInformation(kernel, TESTS, known, 1.0, rng.uniform(0.0, 2.0, 12))
    gradient, step = worth(tasks)[1], 1.0
    for i, d in np.ndindex(tasks.shape):
        moved = [tasks + sign * step * np.eye(8)[2 * i + d].reshape(4, 2) for sign in (1, -1)]
        assert gradient[i, d] == pytest.approx((worth(moved[0])[0] - worth(moved[1])[0]) / 2.0, rel=1e-3, abs=1e-8)
    ancient = ConditionalInformation(kernel, TESTS, known, 1.0, np.full(12, 50.0))
    nothing = ConditionalInformation(kernel, TESTS, np.empty((0, 2)), 1.0)
    assert ancient(tasks)[0] == pytest.approx(nothing(tasks)[0], rel=1e-9)
