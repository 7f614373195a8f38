"""Analytic winds: exact line integrals, the [wind] table, bad input."""

from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.environment.wind import Rotation, Shear, Sum, Uniform, WindField, wind_from_toml

LINEAR = [
    Uniform((3.0, -4.0)),
    Shear(0.002, (0.0, 500.0)),
    Rotation(-0.001, (200.0, 300.0)),
    Sum((Uniform((1.0, 2.0)), Rotation(0.003, (50.0, 60.0)))),
]


def quadrature(wind: WindField, a: np.ndarray, b: np.ndarray, points: int = 4001) -> float:
    """Composite midpoint rule with many points: the slow twin of `line_integral`."""
    s = (np.arange(points) + 0.5) / points
    return float((wind(a + s[:, None] * (b - a)) @ (b - a)).mean())


@pytest.mark.parametrize("wind", LINEAR, ids=lambda w: type(w).__name__)
def test_line_integral_is_the_integral(wind: WindField) -> None:
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-1000, 1000, (2, 20, 2))
    expected = [quadrature(wind, p, q) for p, q in zip(a, b, strict=True)]
    np.testing.assert_allclose(wind.line_integral(a, b), expected, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(wind.line_integral(b, a), -wind.line_integral(a, b), rtol=1e-12)


@pytest.mark.parametrize("wind", LINEAR, ids=lambda w: type(w).__name__)
def test_toml_table_round_trip(wind: WindField) -> None:
    assert wind_from_toml(wind.to_toml()) == wind
    assert isinstance(wind, WindField)


def test_rotation_and_shear_turn_the_stated_way() -> None:
    np.testing.assert_allclose(Rotation(0.5, (1.0, 1.0))([[2.0, 1.0]]), [[0.0, 0.5]])
    np.testing.assert_allclose(Shear(0.5, (9.0, 1.0))([[2.0, 3.0]]), [[1.0, 0.0]])


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"kind": "unifrom", "velocity": [1, 2]}, "did you mean 'uniform'"),
        ({"velocity": [1, 2]}, "unknown kind None"),
        ({"kind": "uniform", "velocity": [1]}, "velocity"),
        ({"kind": "uniform", "velocty": [1, 2]}, "did you mean 'velocity'"),
        ({"kind": "rotation", "rate": "fast"}, "rate"),
        ({"kind": "shear", "rate": float("nan")}, "rate"),
        ({"kind": "sum", "parts": []}, "at least one part"),
        ({"kind": "sum", "parts": [3]}, "tables"),
    ],
)
def test_bad_tables_are_named(table: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        wind_from_toml(table, Path())
