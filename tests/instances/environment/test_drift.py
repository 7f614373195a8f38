"""Fields that drift: the law of Ornstein and Uhlenbeck, the same frames whatever is asked, bad values."""

from __future__ import annotations

import numpy as np
import pytest

from instances import InputError
from instances.environment.drift import DriftingField
from instances.environment.radio import RadioMap

X = np.linspace(0.0, 3900.0, 40)
STILL = RadioMap(X, X, np.full((40, 40), -80.0))


def drawn(number: int) -> np.ndarray:
    return 3.0 * np.random.default_rng([5, number]).standard_normal((40, 40))


def test_it_forgets_itself_at_the_rate_of_tau_and_stays_as_strong() -> None:
    field = DriftingField(STILL, drawn, tau=50.0, step=10.0)
    start, early, later = (field.at(time).values + 80.0 for time in (0.0, 30.0, 80.0))
    assert np.corrcoef(start.ravel(), early.ravel())[0, 1] == pytest.approx(np.exp(-30.0 / 50.0), abs=0.05)
    assert np.corrcoef(start.ravel(), later.ravel())[0, 1] == pytest.approx(np.exp(-80.0 / 50.0), abs=0.08)
    assert later.std() == pytest.approx(3.0, rel=0.06)
    np.testing.assert_allclose(start, drawn(0), atol=1e-12)


def test_a_frame_does_not_depend_on_what_was_asked_before() -> None:
    one, other = (DriftingField(STILL, drawn, tau=50.0, step=10.0) for _ in range(2))
    for time in (70.0, 20.0, 0.0, 40.0):
        one.at(time)
    np.testing.assert_array_equal(one.at(60.0).values, other.at(60.0).values)
    np.testing.assert_array_equal(one.at(69.9).values, other.at(60.0).values)
    np.testing.assert_array_equal(one.at(3 * 10.0 - 1e-12).values, other.at(30.0).values)


@pytest.mark.parametrize(("tau", "step"), [(0.0, 1.0), (1.0, -1.0), (np.nan, 1.0)])
def test_times_that_are_none_are_refused(tau: float, step: float) -> None:
    with pytest.raises(InputError, match="tau and step positive"):
        DriftingField(STILL, drawn, tau, step)
