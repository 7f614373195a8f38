"""The incremental Gaussian process against batch formulas, scikit-learn and laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from formulations.kernel import Matern32, SquaredExponential
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_model import MapModel
from formulations.mapping.trend import path_loss

KERNEL = SquaredExponential(30.0, (4000.0, 2500.0))


def field(seed: int, count: int, pixels: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    X = rng.uniform(0, 20000, (count, 2))
    y = -90 + 20 * np.sin(X[:, 0] / 3000) * np.cos(X[:, 1] / 4000) + rng.normal(0, 1, count)
    return X, y, rng.uniform(0, 20000, (pixels, 2))


def in_blocks(X: np.ndarray, y: np.ndarray, points: np.ndarray, size: int, level: float | None) -> GaussianProcess:
    process = GaussianProcess(KERNEL, 1.0, points, level)
    for k in range(0, len(y), size):
        process.extend(X[k : k + size], y[k : k + size])
    return process


@pytest.mark.parametrize("size", [1, 3, 7, 200])
def test_incremental_is_the_batch_formula_of_eq_gpr1(size: int) -> None:
    X, y, points = field(1, 200, 50)
    C = KERNEL(X, X) + np.eye(200)
    K = KERNEL(points, X)
    ones = np.ones(200)
    weight = ones @ np.linalg.solve(C, ones)
    level = (ones @ np.linalg.solve(C, y)) / weight
    mean = level + K @ np.linalg.solve(C, y - level)
    unknown = (1 - K @ np.linalg.solve(C, ones)) ** 2 / weight
    variance = 900.0 - np.einsum("ij,ji->i", K, np.linalg.solve(C, K.T)) + unknown
    posterior = in_blocks(X, y, points, size, None).posterior()
    assert posterior.coefficients == pytest.approx([level], rel=1e-10)
    np.testing.assert_allclose(posterior.mean, mean, rtol=1e-8)
    np.testing.assert_allclose(posterior.sd**2, variance, rtol=1e-8, atol=1e-8)


def test_agrees_with_scikit_learn() -> None:
    sklearn = pytest.importorskip("sklearn.gaussian_process")
    X, y, points = field(2, 150, 60)
    reference = sklearn.GaussianProcessRegressor(
        sklearn.kernels.ConstantKernel(900.0) * sklearn.kernels.RBF([4000.0, 2500.0]), alpha=1.0, optimizer=None
    ).fit(X, y + 90.0)
    mean, sd = reference.predict(points, return_std=True)
    posterior = in_blocks(X, y, points, 3, -90.0).posterior()
    np.testing.assert_allclose(posterior.mean, mean - 90.0, rtol=1e-8)
    np.testing.assert_allclose(posterior.sd, sd, rtol=1e-8)


@pytest.mark.parametrize("size", [5, 90])
def test_universal_kriging_is_the_batch_formula(size: int) -> None:
    """Notes: r = h_* − HᵀC⁻¹k_*, mean h_*ᵀβ̂ + k_*ᵀC⁻¹(y − Hβ̂), variance + rᵀ(HᵀC⁻¹H)⁻¹r; a nugget is in C and in f."""
    X, y, points = field(4, 90, 40)
    model = MapModel(Matern32(20.0, (5000.0, 3000.0)), 1.5, path_loss(9000.0, 8000.0, 2500.0))
    process = GaussianProcess(model, 1.0, points)
    for k in range(0, 90, size):
        process.extend(X[k : k + size], y[k : k + size])
    H, far = model.trend.columns(X), model.trend.columns(points)
    inverse = np.linalg.inv(model.kernel(X, X) + (1.0 + 1.5**2) * np.eye(90))
    A = H.T @ inverse @ H + np.diag([0.0, 1.0])  # the exponent is believed to be 3 ± 1
    beta = np.linalg.solve(A, H.T @ inverse @ y + [0.0, 3.0])
    K = model.kernel(points, X)
    r = far - K @ inverse @ H
    variance = 400.0 + 1.5**2 - np.einsum("ij,jk,ik->i", K, inverse, K) + np.einsum("ij,ij->i", r, r @ np.linalg.inv(A))
    posterior = process.posterior()
    np.testing.assert_allclose(posterior.coefficients, beta, rtol=1e-8)
    np.testing.assert_allclose(posterior.mean, far @ beta + K @ inverse @ (y - H @ beta), rtol=1e-9)
    np.testing.assert_allclose(posterior.sd**2, variance, rtol=1e-8)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.integers(1, 60))
def test_variance_never_grows_nor_falls_below_zero_with_a_known_mean(seed: int, count: int) -> None:
    X, y, points = field(seed, count, 30)
    X[1::2] = X[::2][: len(X[1::2])]  # half of them measured twice
    points[: min(count, 30)] = X[:30]
    process = GaussianProcess(KERNEL, 1e-3, points, -90.0)
    last = process.posterior().sd
    for k in range(0, count, 4):
        process.extend(X[k : k + 4], y[k : k + 4])
        sd = process.posterior().sd
        assert (sd >= 0).all()
        assert (sd <= last + 1e-6).all()
        last = sd


def test_information_of_replicates_and_of_two_far_points() -> None:
    # notes' closed forms: five replicates ½ ln 4501; far apart each adds ½ ln 901
    process = GaussianProcess(SquaredExponential(30.0, (4000.0, 4000.0)), 1.0, [[0.0, 0.0]])
    process.extend(np.zeros((5, 2)), np.zeros(5))
    assert process.information() == pytest.approx(4.206027, abs=1e-6)
    process.extend([[1e7, 0.0]], [0.0])
    assert process.information() == pytest.approx(4.206027 + 3.401197 + 0.5 * np.log(901 / 900), abs=1e-5)


def test_entropy_of_the_samples_is_that_of_their_covariance() -> None:
    X, y, points = field(8, 40, 5)
    expected = multivariate_normal(cov=KERNEL(X, X) + np.eye(40)).entropy()
    assert in_blocks(X, y, points, 3, None).entropy() == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_samples_that_are_not_finite_are_refused(bad: float) -> None:
    with pytest.raises(ValueError, match="finite"):
        GaussianProcess(KERNEL, 1.0, [[0.0, 0.0]]).extend([[0.0, 0.0]], [bad])
