"""Maps of fields that drift, k_s(x, x′) exp(−|t − t′|/τ): exact values, Kalman's filter, laws, and τ by likelihood."""

from __future__ import annotations

import math

import numpy as np
import pytest

from formulations.kernel import Matern32, SquaredExponential
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.likelihood import RestrictedLikelihood
from formulations.mapping.map_model import MapModel, Offered, choose_model
from formulations.mapping.trend import CONSTANT, Trend, path_loss

KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
SITE = [[0.0, 0.0]]
AGES = {0.0: 0.998890122087, 0.5: 569.275974085607, 1.0: 778.333430164644, 2.0: 883.534220310905}
"""Age of the only reading, in τ → variance."""
VISITS = {
    0.1: (163.956089657475, 0.993937780642),
    0.5: (569.275737296407, 0.998246462308),
    1.0: (778.333406715105, 0.998716852131),
}
"""Period of visits, in τ → variance before and after one of many."""
RATES = {0.1: 2.552839657598, 1.0: 3.329219473762}
"""Period of visits, in τ → information of one of many [nats]."""


def drawn(model: MapModel, count: int, seed: int, lasts: float = 500.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return places in a square of 20 km, readings of noise 1 of a field of `model` there, and their times."""
    rng = np.random.default_rng(seed)
    X, t = rng.uniform(0, 20e3, (count, 2)), np.sort(rng.uniform(0, lasts, count))
    C = model.covariance(X, t, X, t) + np.eye(count)
    return X, -80.0 + np.linalg.cholesky(C) @ rng.normal(size=count), t


def process_of(tau: float, points: object = SITE, level: float | None = 0.0) -> GaussianProcess:
    return GaussianProcess(MapModel(KERNEL, tau=tau), 1.0, points, level)


@pytest.mark.parametrize("age", AGES)
def test_what_a_reading_tells_fades(age: float) -> None:
    process = process_of(300.0)
    process.extend(SITE, [5.0], 1000.0)
    now = process.posterior(1000.0 + age * 300.0)
    assert now.sd[0] ** 2 == pytest.approx(AGES[age], rel=1e-11)
    noise = math.exp(2 * age) * (1.0 + 900.0 * (1 - math.exp(-2 * age)))  # a reading of the field as it is now
    assert now.sd[0] ** 2 == pytest.approx(900.0 * noise / (900.0 + noise), rel=1e-11)
    assert now.mean[0] == pytest.approx(5.0 * 900.0 / 901.0 * math.exp(-age), rel=1e-12)


@pytest.mark.parametrize("period", VISITS)
def test_a_site_that_is_visited_again_and_again(period: float) -> None:
    process, visits = process_of(100.0), 100
    for k in range(visits):
        before = process.posterior(period * 100.0 * k).sd[0] ** 2
        known = process.information()
        process.extend(SITE, [0.0], period * 100.0 * k)
    assert (before, process.posterior().sd[0] ** 2) == pytest.approx(VISITS[period], rel=1e-11)
    if period in RATES:
        assert process.information() - known == pytest.approx(RATES[period], rel=1e-10)


def test_without_drift_time_says_nothing_and_with_fast_drift_readings_are_strangers() -> None:
    X, y, t = drawn(MapModel(KERNEL), 40, 1)
    timed, untimed, strangers = process_of(math.inf, X[:9]), process_of(math.inf, X[:9]), process_of(1e-6)
    for k in range(0, 40, 4):
        timed.extend(X[k : k + 4], y[k : k + 4], t[k : k + 4])
        untimed.extend(X[k : k + 4], y[k : k + 4])
    strangers.extend(X, y, t)
    np.testing.assert_array_equal(timed.posterior(1e9).mean, untimed.posterior().mean)
    np.testing.assert_array_equal(timed.posterior(1e9).sd, untimed.posterior().sd)
    assert strangers.information() == pytest.approx(40 * 0.5 * math.log(901.0))


@pytest.mark.parametrize("tau", [0.5, 60.0, 2000.0])
def test_ticks_and_batch_are_the_batch_formula(tau: float) -> None:
    """Also where V is brought to a later time on the way (τ = 0.5 s: more than LATEST apart), and with a mean."""
    model = MapModel(Matern32(20.0, (5000.0, 3000.0)), 1.5, path_loss(9000.0, 8000.0, 2500.0), tau)
    X, y, t = drawn(model, 90, 4)
    points, now = np.vstack([X[-5:], X[:35] + 100.0]), 520.0 if tau > 1.0 else 500.0
    ticks, batch = GaussianProcess(model, 1.0, points), GaussianProcess(model, 1.0, points)
    for k in range(0, 90, 3):
        ticks.extend(X[k : k + 3], y[k : k + 3], t[k : k + 3])
    batch.extend(X, y, t)
    inverse = np.linalg.inv(model.covariance(X, t, X, t) + (1.0 + 1.5**2) * np.eye(90))
    H, far = model.trend.columns(X), model.trend.columns(points)
    A = H.T @ inverse @ H + np.diag([0.0, 1.0])
    beta = np.linalg.solve(A, H.T @ inverse @ y + [0.0, 3.0])
    K = model.covariance(points, np.full(40, now), X, t)
    r = far - K @ inverse @ H
    variance = 400.0 + 1.5**2 - np.einsum("ij,jk,ik->i", K, inverse, K) + np.einsum("ij,ij->i", r, r @ np.linalg.inv(A))
    for posterior in (ticks.posterior(now), batch.posterior(now)):
        np.testing.assert_allclose(posterior.mean, far @ beta + K @ inverse @ (y - H @ beta), rtol=1e-9)
        np.testing.assert_allclose(posterior.sd**2, variance, rtol=1e-8)


def test_it_is_the_kalman_filter() -> None:
    """A state at 12 sites, x(t + d) = e^(−d/τ) x(t) + noise of covariance (1 − e^(−2d/τ)) K, is the same belief."""
    rng, tau = np.random.default_rng(6), 120.0
    sites = rng.uniform(0, 20e3, (12, 2))
    K = KERNEL(sites, sites)
    mean, P, process, last = np.zeros(12), K.copy(), process_of(tau, sites), 0.0
    for now in np.cumsum(rng.uniform(1.0, 40.0, 60)):
        seen = rng.choice(12, 3, replace=False)
        y = rng.normal(0, 30, 3)
        fade = math.exp(-(now - last) / tau)
        mean, P, last = fade * mean, fade**2 * P + (1 - fade**2) * K, now
        gain = np.linalg.solve(P[np.ix_(seen, seen)] + np.eye(3), P[seen]).T
        mean, P = mean + gain @ (y - mean[seen]), P - gain @ P[seen]
        process.extend(sites[seen], y, now)
    posterior = process.posterior()
    np.testing.assert_allclose(posterior.mean, mean, atol=1e-9)
    np.testing.assert_allclose(posterior.sd**2, np.diag(P), rtol=1e-9)


def test_refitting_keeps_the_times() -> None:
    X, y, t = drawn(MapModel(KERNEL, tau=200.0), 30, 2)
    process = process_of(math.inf, X)
    process.extend(X, y, t)
    again, afresh = process.refitted(MapModel(KERNEL, tau=200.0)), process_of(200.0, X)
    afresh.extend(X, y, t)
    np.testing.assert_array_equal(again.posterior(600.0).mean, afresh.posterior(600.0).mean)


@pytest.mark.parametrize("trend", [CONSTANT, path_loss(9000.0, 11000.0, 2000.0)], ids=lambda trend: trend.name)
def test_the_gradient_by_log_tau_is_that_of_finite_differences(trend: Trend) -> None:
    X, y, t = drawn(MapModel(KERNEL, tau=300.0), 40, 3)
    likelihood, theta = RestrictedLikelihood(1.0, X, y, trend, t), np.log([9.0, 2500.0, 6000.0, 0.8, 250.0])
    value, gradient = likelihood(Matern32, theta)
    assert value == likelihood.value(Matern32, theta)
    for k, step in enumerate(1e-5 * np.eye(5)):
        across = likelihood.value(Matern32, theta + step) - likelihood.value(Matern32, theta - step)
        assert gradient[k] == pytest.approx(across / 2e-5, rel=1e-5, abs=1e-5)


def test_drift_is_believed_where_the_likelihood_says_so_and_only_there() -> None:
    offered = Offered((SquaredExponential,), tau=None)
    drifting = [choose_model(MapModel(), offered, 1.0, *drawn(MapModel(KERNEL, tau=300.0), 120, k)) for k in range(4)]
    assert all(150.0 < found.model.tau < 600.0 for found in drifting)
    assert all(found.drift is not None and found.drift > 20.0 for found in drifting)
    still = [choose_model(MapModel(), offered, 1.0, *drawn(MapModel(KERNEL), 120, k)) for k in range(4)]
    assert [found.model.tau for found in still] == [math.inf] * 4


def test_a_tau_that_is_known_is_kept() -> None:
    X, y, t = drawn(MapModel(KERNEL, tau=300.0), 60, 5)
    assert choose_model(MapModel(), Offered(tau=123.0), 1.0, X, y, t).model.tau == pytest.approx(123.0, rel=1e-12)


@pytest.mark.parametrize("tau", [0.0, -1.0, math.nan])
def test_a_tau_that_is_none_is_refused(tau: float) -> None:
    with pytest.raises(ValueError, match="tau must be positive"):
        MapModel(KERNEL, tau=tau)
