"""Average variance: the values of surveys-that-learn, derivatives by differences, and a bound that nothing passes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.average_variance import AverageVariance
from formulations.kernel import KERNELS, SquaredExponential
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_model import MapModel
from formulations.task_location.placement import lattice
from instances.environment.region import Region
from instances.errors import InputError

SQUARE = Region.rectangle(20_000, 20_000)
GRID = SQUARE.cell_centres(20, 20)
KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
WEST = np.where(GRID[:, 0] < 20_000 / 3, 10.0, 1.0)


def test_one_reading_at_one_target_meets_its_bound():
    alone = AverageVariance(KERNEL, 1.0, np.array([[3.0, 4.0]]))
    assert alone.value([[3.0, 4.0]]) == pytest.approx(900 / 901, rel=1e-12)
    assert alone.lower_bound(1) == pytest.approx(900 / 901, rel=1e-10)
    assert alone.lower_bound(1) <= 900 / 901
    assert alone.lower_bound(0) == pytest.approx(900.0, rel=1e-12)


@pytest.mark.parametrize(
    ("weights", "expected"),
    [
        (None, {5: 18.532, 10: 11.839, 20: 5.102, 40: 1.289, 147: 0.390}),
        (WEST, {5: 14.904, 10: 9.318, 20: 4.012, 40: 1.049}),
    ],
)
def test_bounds_over_the_papers_square(weights, expected):
    judged = AverageVariance(KERNEL, 1.0, GRID, weights)
    assert {n: round(judged.lower_bound(n) ** 0.5, 3) for n in expected} == expected


def test_variances_are_those_of_the_map():
    rng = np.random.default_rng(1)
    readings = SQUARE.sample(30, rng)
    process = GaussianProcess(KERNEL, 1.0, GRID, level=0.0)
    process.extend(readings, np.zeros(30))
    left = AverageVariance(KERNEL, 1.0, GRID, known=readings[:12]).variances(readings[12:])
    assert np.sqrt(left) == pytest.approx(process.posterior().sd, abs=1e-9)


DRIFTING = {"tau": 300.0, "known_times": np.linspace(0.0, 200.0, 9)}


def test_variances_of_a_field_that_drifts_are_those_of_its_map():
    rng = np.random.default_rng(3)
    readings, times = SQUARE.sample(30, rng), np.append(DRIFTING["known_times"], rng.uniform(100.0, 490.0, 21))
    process = GaussianProcess(MapModel(KERNEL, tau=300.0), 1.0, GRID, level=0.0)
    process.extend(readings, np.zeros(30), times)
    judged = AverageVariance(KERNEL, 1.0, GRID, known=readings[:9], **DRIFTING)
    assert np.sqrt(judged.variances(readings[9:], times[9:])) == pytest.approx(process.posterior().sd, abs=1e-9)
    assert judged.value(readings[9:], times[9:] + 50.0) > judged.value(readings[9:], times[9:])
    alone = AverageVariance(KERNEL, 1.0, GRID[:1], tau=300.0)
    once = alone.value([GRID[0], [1e9, 0.0]], [0.0, 300.0])  # a reading of age τ, and one that tells nothing
    assert once == pytest.approx(778.333430164644, rel=1e-9)


@pytest.mark.parametrize("kernel", KERNELS.values(), ids=list(KERNELS))
@pytest.mark.parametrize("drift", [{}, DRIFTING], ids=["stays", "drifts"])
def test_gradient_agrees_with_differences(kernel, drift):
    rng = np.random.default_rng(2)
    kernel, weights = kernel(30.0, (3000.0, 5000.0)), rng.uniform(0, 1, 400)
    judged = AverageVariance(kernel, 1.0, GRID, weights, SQUARE.sample(9, rng), **drift)
    points, step, times = SQUARE.sample(6, rng), 0.5, np.linspace(210.0, 400.0, 6)
    value, gradient = judged(points, times)
    assert value == pytest.approx(judged.value(points, times), rel=1e-12)
    for i, d in itertools.product(range(6), range(2)):
        there, back = points.copy(), points.copy()
        there[i, d] += step
        back[i, d] -= step
        slope = (judged.value(there, times) - judged.value(back, times)) / (2 * step)
        assert gradient[i, d] == pytest.approx(slope, abs=1e-4 * np.abs(gradient).max())


def test_a_weight_of_two_is_a_target_listed_twice_and_a_common_factor_nothing():
    points = np.array([[6000.0, 5000.0], [8000.0, 7000.0]])
    twice = AverageVariance(KERNEL, 1.0, np.array([[5000.0, 5000.0], [5000.0, 5000.0], [9000.0, 5000.0]]))
    weighted = AverageVariance(KERNEL, 1.0, np.array([[5000.0, 5000.0], [9000.0, 5000.0]]), np.array([20.0, 10.0]))
    assert weighted.value(points) == pytest.approx(twice.value(points), rel=1e-12)
    assert weighted.lower_bound(1) == pytest.approx(twice.lower_bound(1), rel=1e-9)


@settings(deadline=None, max_examples=20)
@given(st.integers(1, 30), st.integers(0, 6), st.integers(0, 10**6), st.floats(0.1, 30.0), st.booleans(), st.booleans())
def test_no_readings_pass_the_bound(n, known, seed, noise_sd, clustered, drifts):
    rng = np.random.default_rng(seed)
    kernel, targets, weights = (
        SquaredExponential(30.0, (5000.0, 9000.0)),
        SQUARE.cell_centres(6, 6),
        rng.uniform(0, 1, 36),
    )
    drift = {"tau": 200.0, "known_times": rng.uniform(-300.0, 0.0, known)} if drifts else {}
    judged = AverageVariance(kernel, noise_sd, targets, weights, SQUARE.sample(known, rng), **drift)
    points = np.repeat(SQUARE.sample(1, rng), n, axis=0) if clustered else SQUARE.sample(n, rng)
    assert judged.lower_bound(n) <= judged.value(points, rng.uniform(0.0, 500.0, n))


def test_the_bound_holds_over_brute_force():
    judged = AverageVariance(SquaredExponential(30.0, (8000.0, 8000.0)), 1.0, SQUARE.cell_centres(5, 5))
    sites = lattice(SQUARE, 5)
    best = min(judged.value(sites[list(chosen)]) for chosen in itertools.combinations_with_replacement(range(25), 2))
    assert 0.7 * best <= judged.lower_bound(2) <= best


@pytest.mark.parametrize(
    ("given_", "sentence"),
    [
        ({"noise_sd": 0.0}, "noise_sd must be positive, got 0.0"),
        ({"targets": np.empty((0, 2))}, "there is no target"),
        ({"weights": np.ones(3)}, "there are 3 weights for 400 targets"),
        ({"weights": np.zeros(400)}, "not all 0"),
        ({"known": np.array([[np.nan, 0.0]])}, "known must be finite"),
        ({"tau": 0.0}, "tau must be positive, got 0.0"),
        ({"known": GRID[:2], "known_times": np.zeros(3)}, "2 readings need as many finite times"),
    ],
)
def test_what_makes_no_sense_is_refused(given_, sentence):
    with pytest.raises(InputError, match=sentence):
        AverageVariance(**{"kernel": KERNEL, "noise_sd": 1.0, "targets": GRID, **given_})
