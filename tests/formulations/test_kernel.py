"""Covariances with a map of the prior standard deviation: closed forms and laws."""

from __future__ import annotations

import numpy as np
import pytest

from formulations.kernel import KERNELS, SquaredExponential
from instances.environment.value_map import ValueMap
from instances.errors import InputError

AXIS = np.linspace(0.0, 20_000.0, 11)
ROUGH = ValueMap(AXIS, AXIS, np.random.default_rng(1).uniform(2.0, 60.0, (11, 11)))
SCALES = (4000.0, 2500.0)


def points(seed: int, count: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.0, 20_000.0, (count, 2))


@pytest.mark.parametrize("name", KERNELS)
def test_the_variance_is_the_diagonal_and_the_map_s_square(name):
    kernel, p = KERNELS[name].of_prior(ROUGH, SCALES), points(4, 9)
    assert kernel.variance(p) == pytest.approx(ROUGH(p) ** 2, rel=1e-12)
    assert kernel.variance(p) == pytest.approx(np.diagonal(kernel(p, p)), rel=1e-12)
    assert (kernel.stationary.variance(p) == kernel.signal_sd**2).all()
    assert np.linalg.eigvalsh(kernel(p, p)).min() > 0


def test_a_map_that_is_the_same_everywhere_is_no_map():
    flat = SquaredExponential.of_prior(ValueMap(AXIS, AXIS, np.full((11, 11), 30.0)), SCALES)
    a, b = points(5, 6), points(6, 4)
    assert (flat(a, b) == SquaredExponential(30.0, SCALES)(a, b)).all()


def test_a_share_of_more_than_one_is_refused():
    with pytest.raises(InputError, match=r"relative_sd must be from 0 to 1, got 60"):
        SquaredExponential(30.0, SCALES, ValueMap(AXIS, AXIS, np.full((11, 11), 60.0)))
