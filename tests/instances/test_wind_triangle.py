"""Flight times along given tracks: the closed form, and an integrator of differential equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from instances import InputError
from instances.environment.wind import Rotation, Shear, Uniform
from instances.environment.wind_grid import Grid
from instances.wind_triangle import GAUSS, KRONROD, NODES, flight_times, ground_speeds

AIRSPEED = 20.0
RNG = np.random.default_rng(0)
A, B = RNG.uniform(0, 20_000, (2, 8, 2))
LENGTH = np.hypot(*(B - A).T)
TANGENTS = (B - A) / LENGTH[:, None]


def test_the_rules_integrate_polynomials_of_their_degree():
    for degree in range(11 + 1):
        assert NODES**degree @ KRONROD == pytest.approx(1 / (degree + 1), rel=1e-14)
    for degree in range(5 + 1):
        assert NODES**degree @ GAUSS == pytest.approx(1 / (degree + 1), rel=1e-14)


@given(st.floats(0, 0.99), st.floats(0, 6.3))
def test_a_uniform_wind_has_a_closed_form(ratio, direction):
    u, v = ratio * AIRSPEED * np.array([np.cos(direction), np.sin(direction)])
    along = TANGENTS @ [u, v]
    across = TANGENTS @ [v, -u]
    expected = LENGTH / (np.sqrt(AIRSPEED**2 - across**2) + along)
    np.testing.assert_allclose(flight_times(A, B, Uniform((u, v)), AIRSPEED), expected, rtol=1e-9)
    np.testing.assert_allclose(LENGTH / ground_speeds(np.tile([u, v], (8, 1)), TANGENTS, AIRSPEED), expected, rtol=1e-9)


ROWS = np.random.default_rng(1).uniform(-8, 8, (9, 9))


@pytest.mark.parametrize(
    "wind",
    [
        Rotation(1e-3, (10_000.0, 9000.0)),
        Shear(1.4e-3, (0.0, 10_000.0)),
        Grid((0.0, 0.0), (2500.0, 2500.0), ROWS, ROWS.T),
    ],
)
def test_other_winds_agree_with_an_integrator(wind):
    for a, tangent, length, time in zip(A, TANGENTS, LENGTH, flight_times(A, B, wind, AIRSPEED), strict=True):

        def slowness(s, _, a=a, e=tangent):
            return 1 / ground_speeds(wind([a + s * e]), e[None], AIRSPEED)

        # short steps: over kinks of the grid those of length / 40 err by up to 1.3e-6
        flown = solve_ivp(slowness, (0, length), [0.0], rtol=1e-8, atol=1e-8, max_step=length / 200)
        assert time == pytest.approx(flown.y[0, -1], rel=1e-6)


def test_nothing_to_fly_takes_no_time():
    assert flight_times(A[:1], A[:1], Rotation(1e-3), AIRSPEED).tolist() == [0.0]
    assert flight_times(A[:0], B[:0], Rotation(1e-3), AIRSPEED).shape == (0,)


def test_a_wind_as_strong_as_the_airspeed_is_refused_with_its_place():
    a, b = np.array([[0.0, 0.0]]), np.array([[20_000.0, 0.0]])
    with pytest.raises(
        InputError, match=r"wind: at \(\d+, 0\) m it blows with .* not less than the airspeed of 20 m/s"
    ):
        flight_times(a, b, Rotation(1.2e-3), AIRSPEED)
