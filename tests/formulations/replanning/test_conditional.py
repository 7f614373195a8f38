"""I(y_T; y_o | y_S): the chain rule, its gradient, and what placing by it gains."""

import numpy as np
import pytest

from formulations.kernel import SquaredExponential
from formulations.replanning.conditional import ConditionalInformation, place_remaining
from formulations.task_location.criterion import Criterion
from formulations.task_location.derivatives import Expansion
from formulations.task_location.placement import lattice
from instances.environment.region import Region

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
