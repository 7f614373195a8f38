"""Maps of importance and of prior standard deviation: values between nodes, slopes, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from instances.environment.value_map import ValueMap
from instances.errors import InputError

X, Y = np.linspace(0.0, 400.0, 5), np.linspace(0.0, 200.0, 3)


def test_a_bilinear_function_is_itself_with_its_slopes():
    def f(p: np.ndarray) -> np.ndarray:
        return 3.0 + 0.02 * p[:, 0] + 0.01 * p[:, 1] + 1e-4 * p[:, 0] * p[:, 1]

    nodes = np.stack(np.meshgrid(X, Y), axis=-1)
    given = ValueMap(X, Y, f(nodes.reshape(-1, 2)).reshape(3, 5))
    p = np.random.default_rng(0).uniform((0, 0), (400, 200), (50, 2))
    slope, twist = given.slope(p)
    assert given(p) == pytest.approx(f(p))
    assert slope == pytest.approx(np.column_stack([0.02 + 1e-4 * p[:, 1], 0.01 + 1e-4 * p[:, 0]]))
    assert twist == pytest.approx(1e-4)


def test_outside_it_is_constant_across_its_border():
    given = ValueMap(X, Y, np.random.default_rng(1).uniform(1, 9, (3, 5)))
    outside = np.array([[-50.0, 130.0], [450.0, 70.0], [130.0, 250.0], [500.0, -3.0]])
    slope, twist = given.slope(outside)
    for d in (0, 1):
        move = 0.01 * np.eye(2)[d]
        assert slope[:, d] == pytest.approx((given(outside + move) - given(outside - move)) / 0.02, abs=1e-9)
    assert (twist == 0).all()


@pytest.mark.parametrize(
    ("value", "words"),
    [(-1.0, r"value at \(300, 100\) m is negative: -1"), (np.nan, "1 of 15 values are missing"), (np.inf, "missing")],
)
def test_a_value_that_is_none_is_refused(value, words):
    values = np.ones((3, 5))
    values[1, 3] = value
    with pytest.raises(InputError, match=words):
        ValueMap(X, Y, values)


def test_a_map_of_zeros_is_refused():
    with pytest.raises(InputError, match="all values are 0"):
        ValueMap(X, Y, np.zeros((3, 5)))
