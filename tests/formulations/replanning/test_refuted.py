"""Readings against the belief that is planned by: the ratio of likelihoods, and the re-plan that follows at once."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from formulations.kernel import SquaredExponential
from formulations.mapping.map_model import MapModel, Offered, choose_model
from formulations.replanning.in_flight import drawn, fly_replanned
from formulations.replanning.refuted import REFUTED, ahead
from formulations.surveying.gaussian_field import gaussian_field
from tests.formulations.replanning.worlds import SQUARE, aloft, planner, world

TRUE = MapModel(SquaredExponential(10.0, (3000.0, 3000.0)))


def readings(seed, count=18):
    """Return places, readings of a draw of TRUE with unit noise, and times."""
    rng = np.random.default_rng(seed)
    X = rng.uniform(0.0, 10e3, (count, 2))
    covariance = TRUE.kernel(X, X) + np.eye(count)
    return X, rng.multivariate_normal(np.zeros(count), covariance), np.arange(count) * 5.0


def test_the_ratio_is_that_of_the_densities_of_what_no_level_changes():
    X, y, t = readings(0)
    other = MapModel(SquaredExponential(7.0, (8000.0, 5000.0)), nugget_sd=0.5, tau=60.0)
    D = np.diff(np.eye(len(y)), axis=0)

    def density(model):
        noise = 1.0 + model.nugget_sd**2
        return multivariate_normal(cov=D @ (model.covariance(X, t, X, t) + noise * np.eye(len(y))) @ D.T).logpdf(D @ y)

    assert ahead(other, TRUE, 1.0, X, y, t) == pytest.approx(density(other) - density(TRUE), abs=1e-6)
    assert ahead(TRUE, other, 1.0, X, y, t) == -ahead(other, TRUE, 1.0, X, y, t)


@pytest.mark.slow
def test_a_true_belief_is_seldom_refuted_and_one_of_three_times_the_length_scale_often():
    wide = MapModel(SquaredExponential(10.0, (9000.0, 9000.0)))
    refuted = []
    for seed in range(12):
        X, y, t = readings(seed)
        fitted = choose_model(TRUE, Offered((SquaredExponential,)), 1.0, X, y).model
        refuted.append([ahead(fitted, belief, 1.0, X, y, t) > REFUTED for belief in (TRUE, wide)])
    often = np.mean(refuted, axis=0)
    assert often[0] <= 0.2
    assert often[1] >= 0.8


@pytest.mark.parametrize(("believed", "early"), [(6000.0, True), (2000.0, False)])
def test_the_first_re_plan_waits_for_no_round_where_the_belief_is_refuted(believed, early):
    truth = gaussian_field(SquaredExponential(30.0, (2000.0, 2000.0)), SQUARE.bounds, 100, 2)
    fleet = aloft(np.random.default_rng(2), 330.0)
    asked = planner(believed)
    made = fly_replanned(fleet, drawn(truth, 1.0, 5.0, 2), asked, world(), every=20)[1]
    assert (made[0].reason == "readings refute what was believed") == early
    assert (made[0].time < 100.0) == early
    assert 100.0 in [one.time for one in made if one.reason == "20 rounds of measurements"]
    assert (made[0].model is asked.model) == (not early)  # a belief that is not refuted is kept
