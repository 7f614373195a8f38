"""Closed-form moving costs against what they claim to be: the minimum over paths."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from instances import InputError
from instances.environment.wind import Rotation, Shear, Uniform, WindField
from instances.environment.wind_table import Sum
from instances.wind_metric import cost_matrix, pair_costs

V0 = 20.0
WINDS = [
    None,
    Uniform((5.0, -3.0)),
    Shear(8e-4, (0.0, 10_000.0)),
    Shear(-8e-4, (0.0, 9_000.0)),
    Rotation(5e-4, (10_000.0, 10_000.0)),
    Rotation(-5e-4, (9_000.0, 11_000.0)),
    Sum((Uniform((3.0, 1.0)), Rotation(3e-4, (10_000.0, 10_000.0)))),
]
winds = pytest.mark.parametrize("wind", WINDS, ids=lambda w: "calm" if w is None else f"{type(w).__name__}")


def polyline_cost(points, wind):
    a, b = points[:-1], points[1:]
    along = 0.0 if wind is None else wind.line_integral(a, b).sum()
    return np.linalg.norm(b - a, axis=1).sum() / V0 - along / V0**2


@winds
def test_no_path_is_cheaper_and_the_best_polyline_comes_close(wind):
    rng = np.random.default_rng(1)
    t = np.linspace(0, 1, 22)[1:-1, None]
    for _ in range(3):
        a, b = rng.uniform(0, 20_000, (2, 2))
        sideways = np.array([a[1] - b[1], b[0] - a[0]])

        def cost(offsets, a=a, b=b, sideways=sideways):
            return polyline_cost(np.vstack([a, a + t * (b - a) + offsets[:, None] * sideways, b]), wind)

        exact = pair_costs(a, b, V0, wind)[0]
        best = minimize(cost, np.zeros(20), method="L-BFGS-B").fun
        assert exact <= best * (1 + 1e-12)
        assert exact == pytest.approx(best, rel=3e-4)
        assert exact <= cost(np.zeros(20)) * (1 + 1e-12)


@pytest.mark.parametrize(
    ("wind", "term"),
    [
        (Rotation(4e-4, (10_000.0, 9_000.0)), "rotation"),
        (Shear(6e-4, (0.0, 8_000.0)), "shear"),
        (Uniform((4.0, 2.0)), "uniform"),
    ],
)
def test_the_formulas_as_they_stand(wind, term):
    a, b = np.array([2_000.0, 3_000.0]), np.array([15_000.0, 11_000.0])
    d = np.linalg.norm(b - a)
    if term == "uniform":
        expected = d / V0 - np.dot(wind.velocity, b - a) / V0**2
    else:
        curl = 2 * wind.rate if term == "rotation" else wind.rate
        radius = V0 / curl
        phi = np.arcsin(d / (2 * radius))
        area = radius**2 * (phi - np.sin(phi) * np.cos(phi))
        if term == "rotation":
            p, q = a - wind.centre, b - wind.centre
            gain = wind.rate * (p[0] * q[1] - p[1] * q[0]) + 2 * wind.rate * area
        else:
            gain = wind.rate * ((a[1] + b[1]) / 2 - wind.centre[1]) * (b[0] - a[0]) + wind.rate * area
        expected = 2 * phi * radius / V0 - gain / V0**2
    assert pair_costs(a, b, V0, wind)[0] == pytest.approx(expected, rel=1e-12)


@winds
def test_laws_of_a_randers_metric(wind):
    p = np.random.default_rng(2).uniform(0, 20_000, (12, 2))
    cost = cost_matrix(p, V0, wind)
    assert (np.diagonal(cost) == 0).all()
    assert (cost[~np.eye(12, dtype=bool)] > 0).all()
    assert (cost[:, None, :] <= (cost[:, :, None] + cost[None, :, :]) * (1 + 1e-9)).all()  # triangle inequality
    if isinstance(wind, (Rotation, Shear)):  # the same leg backwards is the leg in the opposite wind
        opposite = type(wind)(-wind.rate, wind.centre)
        assert pytest.approx(cost_matrix(p, V0, opposite), rel=1e-9, abs=1e-9) == cost.T


@settings(deadline=None)
@given(st.integers(0, 10**6), st.floats(-5, 5), st.floats(-5, 5))
def test_uniform_wind_never_changes_a_closed_tour(seed, u, v):
    p = np.random.default_rng(seed).uniform(0, 20_000, (6, 2))
    calm, windy = cost_matrix(p, V0, None), cost_matrix(p, V0, Uniform((u, v)))
    tour = [0, 3, 1, 5, 2, 4, 0]
    assert windy[tour[:-1], tour[1:]].sum() == pytest.approx(calm[tour[:-1], tour[1:]].sum(), rel=1e-9)


def test_short_legs_lose_no_digits():
    wind = Rotation(5e-4, (0.0, 0.0))
    for d in (1e-6, 1e-3, 1.0):
        assert pair_costs([0.0, 0.0], [d, 0.0], V0, wind)[0] == pytest.approx(d / V0, rel=1e-9)
    assert pair_costs([5.0, 5.0], [5.0, 5.0], V0, wind)[0] == 0


class Gusts:
    """A wind without closed form."""

    def __call__(self, points):
        return np.zeros((len(points), 2))

    def line_integral(self, a, b):
        return np.zeros(len(a))

    def to_toml(self, folder=None):
        return {}

    @classmethod
    def from_toml(cls, table, folder):
        return cls()


@pytest.mark.parametrize(
    ("wind", "sentence"),
    [
        (Uniform((20.0, 0.0)), "it reaches 20 m/s where legs may lead, but must stay below the ground speed"),
        (Rotation(2e-3, (10_000.0, 10_000.0)), "it reaches"),
        (Shear(3e-3, (0.0, 10_000.0)), "it reaches"),
        (Gusts(), "there is no closed form for a Gusts"),
    ],
)
def test_where_there_is_no_closed_form(wind, sentence):
    assert isinstance(wind, WindField)
    with pytest.raises(InputError, match=sentence):
        cost_matrix([[0.0, 0.0], [20_000.0, 20_000.0]], V0, wind)


def test_points_too_far_apart_for_their_arc():
    with pytest.raises(InputError, match=r"too strong for points 1000 m apart .* at most 400 m"):
        pair_costs([0.0, 0.0], [1000.0, 0.0], 20.0, Rotation(0.05, (500.0, 0.0)))
