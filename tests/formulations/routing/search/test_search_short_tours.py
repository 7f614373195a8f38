"""Short tours from several depots: ruins as large as a tour, no mean, cool perturbations; elsewhere all is as set."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.search.costs import search_costs
from formulations.routing.search.lineage import Family, Lineage
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.strategy import ONE_SITE, SEVERAL_DEPOTS
from formulations.routing.subset_dp import SubsetDp
from instances import Instance

USUAL = SearchParameters()
SHORT = SEVERAL_DEPOTS.short
LONGER = replace(SEVERAL_DEPOTS, short=None)


def lineage(n, m, parameters=USUAL, *, together=False):
    """Return a lineage of an instance in the plane, its depots at one place if asked."""
    points = np.random.default_rng(7).random((n + m, 2))
    if together:
        points[n:] = points[n]
    cost = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    data = problem_data(search_costs(Instance("plane", cost, n, m)), n, parameters.neighbourhood)
    return Lineage(data, parameters, seeded(1), Family())


@pytest.mark.parametrize(
    ("n", "m", "together", "strategy"),
    [
        (SHORT.tasks * 5, 5, False, SEVERAL_DEPOTS),
        (SHORT.tasks * 5 + 1, 5, False, LONGER),
        (SHORT.tasks * 5, 5, True, replace(ONE_SITE, packing=None)),
    ],
    ids=["short", "longer", "one site"],
)
def test_the_strategy_follows_from_depots_and_the_length_of_tours(n, m, together, strategy):
    assert lineage(n, m, together=together).strategy == strategy


def test_members_with_short_tours_differ_in_more():
    assert SEVERAL_DEPOTS.distinct() > LONGER.distinct() == SEVERAL_DEPOTS.apart


def test_ruins_of_short_tours_are_larger_and_the_mean_weighs_nearly_nothing():
    short, longer = lineage(30, 3), lineage(90, 3)
    assert short.annealing.removals > longer.annealing.removals == USUAL.annealing.removals
    assert longer.parameters.schedule == USUAL.schedule
    weights = zip(short.parameters.schedule.mean_weight, USUAL.schedule.mean_weight, strict=True)
    assert all(0 < short < 0.05 * usual for short, usual in weights)


def test_perturbations_of_short_tours_are_cooler_and_not_bounded():
    short, longer = lineage(30, 3).parameters, lineage(90, 3).parameters
    assert short.schedule.perturbed < longer.schedule.perturbed == USUAL.schedule.perturbed
    assert (short.perturbation.bounded, longer.perturbation) == (False, USUAL.perturbation)


@pytest.mark.parametrize("asked", [1, 6, 20])
def test_ruins_follow_the_option_but_see_no_more_than_the_neighbourhood(asked):
    parameters = Memetic(removals=asked)._with_options()
    removals = lineage(30, 3, parameters).annealing.removals
    assert asked <= removals <= min(2 * asked, USUAL.neighbourhood.tasks)


@pytest.mark.parametrize(("n", "m", "seed"), [(6, 5, 0), (12, 3, 1), (14, 4, 2), (15, 2, 3)])
def test_optima_of_short_tours_are_found(n, m, seed):
    instance = generate("square-wind", n, m, seed)
    best = SubsetDp().solve(instance, limits=Limits(time=60.0))
    found = Memetic().solve(instance, limits=Limits(time=60.0, iterations=60_000), seed=1)
    assert found.objective == pytest.approx(best.objective, rel=1e-9)
