"""Kernels, the restricted likelihood and the choice by it: exact values, finite differences, laws."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from formulations.kernel import KERNELS, Kernel, Matern12, Matern32, SquaredExponential
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.likelihood import RestrictedLikelihood
from formulations.mapping.map_model import MapModel, Offered, choose_model
from formulations.mapping.trend import CONSTANT, Trend, path_loss

AT_ONE = {"se": 0.606530659713, "matern52": 0.523994108832, "matern32": 0.483357724597, "matern12": 0.367879441171}
"""Correlation at r = 1."""
OF_TWO = {"se": 6.574812833165, "matern52": 6.643429700319, "matern32": 6.670795155314, "matern12": 6.730972117611}
"""Information [nats] of two points a length scale apart, σ_f 30, σ_n 1."""
MASTS = path_loss(9000.0, 11000.0, 2000.0)


def drawn(kernel: Kernel, count: int, seed: int, level: float = -80.0) -> tuple[np.ndarray, np.ndarray]:
    """Return places in a square of 20 km and readings of noise 1 of a field of `kernel` there."""
    rng = np.random.default_rng(seed)
    X = rng.uniform(0, 20e3, (count, 2))
    return X, level + np.linalg.cholesky(kernel(X, X) + np.eye(count)) @ rng.normal(size=count)


@pytest.mark.parametrize("name", KERNELS)
def test_a_kernel_has_its_exact_values(name: str) -> None:
    kernel = KERNELS[name](30.0, (4000.0, 2000.0))
    places = np.array([[0.0, 0.0], [0.0, 2000.0]])
    assert kernel(places, places)[0] == pytest.approx(900.0 * np.array([1.0, AT_ONE[name]]), rel=1e-11)
    process = GaussianProcess(kernel, 1.0, places)
    process.extend(places, [0.0, 0.0])
    assert process.information() == pytest.approx(OF_TWO[name], rel=1e-11)


@pytest.mark.parametrize("trend", [CONSTANT, MASTS], ids=lambda trend: trend.name)
@pytest.mark.parametrize("name", KERNELS)
def test_the_gradient_is_that_of_finite_differences(name: str, trend: Trend) -> None:
    X, y = drawn(SquaredExponential(12.0, (3000.0, 5000.0)), 40, 3)
    X[1] = X[0]  # r = 0 off the diagonal
    likelihood, theta = RestrictedLikelihood(1.0, X, y, trend), np.log([9.0, 2500.0, 6000.0, 0.8])
    value, gradient = likelihood(KERNELS[name], theta)
    assert value == likelihood.value(KERNELS[name], theta)
    for k, step in enumerate(1e-5 * np.eye(4)):
        across = likelihood.value(KERNELS[name], theta + step) - likelihood.value(KERNELS[name], theta - step)
        assert gradient[k] == pytest.approx(across / 2e-5, rel=1e-5, abs=1e-5)


def test_the_restricted_likelihood_is_that_of_contrasts() -> None:
    """With H = 1 it is the density of the N − 1 contrasts Qᵀy that know no level, but for the constant ½ log N."""
    X, y = drawn(Matern12(12.0, (3000.0, 5000.0)), 30, 4)
    nugget = 0.7
    C = Matern12(12.0, (3000.0, 5000.0))(X, X) + (1.0 + nugget**2) * np.eye(30)
    Q = np.linalg.svd(np.ones((30, 1)))[0][:, 1:]
    contrasts = multivariate_normal(cov=Q.T @ C @ Q).logpdf(Q.T @ y)
    value = RestrictedLikelihood(1.0, X, y, CONSTANT).value(Matern12, np.log([12.0, 3000.0, 5000.0, nugget]))
    assert value == pytest.approx(contrasts - 0.5 * np.log(30), rel=1e-10)


def test_a_believed_coefficient_is_a_covariance_of_its_column() -> None:
    X, y = drawn(Matern12(12.0, (3000.0, 5000.0)), 30, 4)
    theta, phi = np.log([12.0, 3000.0, 5000.0, 0.7]), MASTS.columns(X)[:, 1]
    C = Matern12(12.0, (3000.0, 5000.0))(X, X) + (1.0 + 0.7**2) * np.eye(30) + np.outer(phi, phi)
    Q = np.linalg.svd(np.ones((30, 1)))[0][:, 1:]
    contrasts = multivariate_normal(cov=Q.T @ C @ Q).logpdf(Q.T @ (y - 3.0 * phi))
    value = RestrictedLikelihood(1.0, X, y, MASTS).value(Matern12, theta)
    assert value == pytest.approx(contrasts - 0.5 * np.log(30), rel=1e-10)


@pytest.mark.parametrize("name", ["se", "matern12"])
def test_the_kernel_that_made_the_data_is_chosen(name: str) -> None:
    chosen = []
    for seed in range(4):
        X, y = drawn(KERNELS[name](20.0, (5000.0, 5000.0)), 110, seed)
        chosen.append(choose_model(MapModel(), Offered(), 1.0, X, y).model.kernel.name)
    assert chosen.count(name) >= 3


@pytest.mark.parametrize("start", [150.0, 4000.0, 60_000.0])
def test_the_choice_does_not_depend_on_where_a_search_begins(start: float) -> None:
    """From 150 m a single search ends on a peak where readings do not know of one another."""
    X, y = drawn(SquaredExponential(8.0, (4000.0, 4000.0)), 30, 8, level=-70.0)
    found = choose_model(MapModel(SquaredExponential(8.0, (start, start))), Offered(), 1.0, X, y)
    assert max(found.evidence.values()) == pytest.approx(-78.7234, abs=1e-3)


def test_two_length_scales_are_taken_where_the_data_has_two() -> None:
    X, y = drawn(SquaredExponential(10.0, (3000.0, 9000.0)), 160, 5)
    found = choose_model(MapModel(), Offered((SquaredExponential,)), 1.0, X, y).model
    assert found.kernel.signal_sd == pytest.approx(10.0, rel=0.35)
    assert found.kernel.length_scales == pytest.approx((3000.0, 9000.0), rel=0.25)
    alike = choose_model(
        MapModel(), Offered((SquaredExponential,)), 1.0, *drawn(SquaredExponential(10.0), 160, 5)
    ).model
    assert alike.kernel.length_scales[0] == alike.kernel.length_scales[1]


def test_physics_is_the_mean_where_it_helps_and_only_there() -> None:
    X, rough = drawn(Matern12(4.0, (2000.0, 2000.0)), 80, 9)
    offered, wrong = Offered((Matern12,), (CONSTANT, MASTS)), path_loss(40_000.0, -60_000.0, 2000.0)
    there = choose_model(MapModel(), offered, 1.0, X, rough + 3.0 * MASTS.columns(X)[:, 1])
    assert there.model.trend is MASTS
    assert there.evidence["matern12", "path-loss"] > there.evidence["matern12", "constant"] + 3.0
    assert choose_model(MapModel(), offered, 1.0, X, rough).model.trend is CONSTANT
    offered = Offered((Matern12,), (CONSTANT, wrong))
    assert choose_model(MapModel(), offered, 1.0, X, rough).model.trend is CONSTANT


@pytest.mark.parametrize(
    ("X", "y"),
    [(np.zeros((9, 2)), np.arange(9.0)), (np.eye(9, 2), np.full(9, -70.0)), (np.eye(7, 2), np.arange(7.0))],
    ids=["one place", "one value", "seven samples"],
)
def test_samples_that_say_nothing_leave_the_model_as_it_is(X: np.ndarray, y: np.ndarray) -> None:
    given = MapModel(Matern12(7.0, (800.0, 900.0)))
    assert choose_model(given, Offered(), 1.0, X, y).model is given


def test_a_mean_whose_columns_are_alike_is_not_chosen() -> None:
    X, y = drawn(SquaredExponential(8.0, (4000.0, 4000.0)), 30, 8)
    flat = Trend("flat", lambda points: np.full(len(points), 3.0))
    assert choose_model(MapModel(), Offered(trends=(CONSTANT, flat)), 1.0, X, y).model.trend is CONSTANT


def test_a_field_stretched_along_a_diagonal_is_found_to_be() -> None:
    truth = Matern32(10.0, (9000.0, 3000.0), direction=math.radians(35.0))
    X, y = drawn(truth, 110, 5)
    found = choose_model(MapModel(), Offered((Matern32,), turned=True), 1.0, X, y).model.kernel
    assert math.degrees(found.direction) == pytest.approx(35.0, abs=8.0)
    assert 2.0 < found.length_scales[0] / found.length_scales[1] < 4.5
    alike = choose_model(MapModel(), Offered((Matern32,), turned=True), 1.0, *drawn(Matern32(10.0), 60, 5)).model.kernel
    assert alike.direction == 0.0
    assert alike.length_scales[0] == alike.length_scales[1]


def test_turning_the_plane_turns_the_map() -> None:
    """Which way is x must not matter: places turned by 35° have the same likelihood, 35° further on."""
    X, y = drawn(SquaredExponential(12.0, (3000.0, 5000.0)), 40, 3)
    turn = math.radians(35.0)
    back = X @ np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    kernel = Matern32(9.0, (2500.0, 6000.0))
    assert replace(kernel, direction=turn)(back, back) == pytest.approx(kernel(X, X), rel=1e-9)
    theta = np.log([9.0, 2500.0, 6000.0, 0.8])
    straight, slopes = RestrictedLikelihood(1.0, X, y, CONSTANT)(Matern32, theta)
    turned = RestrictedLikelihood(1.0, back, y, CONSTANT)
    value, gradient = turned(Matern32, theta, turn)
    assert (value, gradient[:-1]) == (pytest.approx(straight), pytest.approx(slopes, rel=1e-6))
    across = turned.value(Matern32, theta, turn + 1e-5) - turned.value(Matern32, theta, turn - 1e-5)
    assert gradient[-1] == pytest.approx(across / 2e-5, rel=1e-5)


def ridge(points: np.ndarray) -> np.ndarray:
    """Return a predicted loss of 20 dB behind the line x = 10 km."""
    return np.where(points[:, 0] > 10e3, 20.0, 0.0)


SHADING = Trend("propagation", lambda points: -ridge(points), loss=ridge)


def shadowed(seed: int, *, varies: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return places and readings about the predicted signal: off it behind the ridge alone, or alike everywhere."""
    X, y = drawn(Matern32(6.0, (5000.0, 5000.0)), 90, seed)
    clear = np.random.default_rng(seed).normal(size=90)
    return X, np.where((X[:, 0] <= 10e3) & varies, clear, y) - ridge(X)


def test_the_gradient_by_the_shadows_is_that_of_finite_differences() -> None:
    X, y = shadowed(1, varies=True)
    likelihood = RestrictedLikelihood(1.0, X, y, SHADING, 10.0 * np.arange(90), shadowed=True)
    theta = np.log([9.0, 2500.0, 6000.0, 0.8, 400.0, 15.0, 0.4])
    _, gradient = likelihood(Matern32, theta)
    for k, step in enumerate(1e-5 * np.eye(7)):
        across = likelihood.value(Matern32, theta + step) - likelihood.value(Matern32, theta - step)
        assert gradient[k] == pytest.approx(across / 2e-5, rel=1e-5, abs=1e-5)


def test_a_field_varies_with_predicted_shadows_where_it_does_and_only_there() -> None:
    offered = Offered((SquaredExponential, Matern32), (CONSTANT, SHADING))
    X, y = shadowed(1, varies=True)
    model = choose_model(MapModel(), offered, 1.0, X, y).model
    assert model.trend is SHADING
    assert model.shadows is not None
    assert model.shadows.in_sight < 0.3
    process = GaussianProcess(model, 1.0, X)
    process.extend(X[:50], y[:50])
    process.extend(X[50:], y[50:])
    H, B = SHADING.columns(X), SHADING.prior_precision
    m = np.where(X[:, 0] > 10e3, 1 - (1 - model.shadows.in_sight) * np.exp(-20 / 6), model.shadows.in_sight)
    apart = np.abs(np.subtract.outer(ridge(X), ridge(X))) / model.shadows.contrast
    K = model.kernel(X, X) * np.outer(m, m) * np.exp(-apart)
    inverse = np.linalg.inv(K + (1.0 + model.nugget_sd**2) * np.eye(90))
    beta = np.linalg.solve(H.T @ inverse @ H + B, H.T @ inverse @ y + B @ SHADING.prior_mean)
    assert process.posterior().mean == pytest.approx(H @ beta + K @ inverse @ (y - H @ beta), rel=1e-6)
    assert model.variance(X) == pytest.approx(np.diagonal(K), rel=1e-12)
    assert choose_model(MapModel(), offered, 1.0, *shadowed(1, varies=False)).model.shadows is None


def test_rough_ground_is_believed_rough_where_that_is_nearly_as_likely() -> None:
    """Smooth between jumps, 3/2 is likelier by a nat, and ½ is taken; a draw of 3/2 is told from ½ by 20 nats."""
    X, y = drawn(Matern32(4.0, (5000.0, 5000.0)), 100, 2)
    found = choose_model(MapModel(), Offered(), 1.0, X, y + 12.0 * (np.sin(X[:, 0] / 2500.0) > 0.3))
    assert max(found.evidence, key=lambda names: found.evidence[names]) == ("matern32", "constant")
    assert found.model.kernel.name == "matern12"
    found = choose_model(MapModel(), Offered(), 1.0, *drawn(Matern32(20.0, (6000.0, 6000.0)), 110, 3))
    assert found.model.kernel.name == "matern32"
