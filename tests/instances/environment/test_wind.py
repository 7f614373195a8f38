"""Analytic winds: exact line integrals, the [wind] table, bad input."""

from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.environment.wind import Rotation, Shear, Uniform, WindField
from instances.environment.wind_grid import Grid
from instances.environment.wind_table import Sum, wind_from_toml
from instances.environment.wind_turbulence import Turbulence
from instances.environment.wind_vortices import Vortices

FIELDS = [
    Uniform((3.0, -4.0)),
    Shear(0.002, (0.0, 500.0)),
    Rotation(-0.001, (200.0, 300.0)),
    Sum((Uniform((1.0, 2.0)), Rotation(0.003, (50.0, 60.0)))),
    Vortices(((300.0, -200.0), (-3000.0, 0.0)), (9e4, -4e4), (400.0, 0.0)),
    Turbulence(5.0, 2500.0, seed=3),
]


def sampled(wind: WindField, bounds: tuple[float, float, float, float], columns: int, rows: int) -> Grid:
    """`wind` on columns × rows nodes over `bounds`."""
    xs, ys = np.linspace(bounds[0], bounds[2], columns), np.linspace(bounds[1], bounds[3], rows)
    w = wind(np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)).reshape(rows, columns, 2)
    return Grid(bounds[:2], (float(xs[1] - xs[0]), float(ys[1] - ys[0])), w[..., 0], w[..., 1])


def quadrature(wind: WindField, a: np.ndarray, b: np.ndarray, points: int = 4001) -> float:
    """Composite midpoint rule with many points: the slow twin of `line_integral`."""
    s = (np.arange(points) + 0.5) / points
    return float((wind(a + s[:, None] * (b - a)) @ (b - a)).mean())


@pytest.mark.parametrize("wind", FIELDS, ids=lambda w: type(w).__name__)
def test_line_integral_is_the_integral(wind: WindField) -> None:
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-1000, 1000, (2, 20, 2))
    expected = [quadrature(wind, p, q) for p, q in zip(a, b, strict=True)]
    np.testing.assert_allclose(wind.line_integral(a, b), expected, rtol=1e-6, atol=1e-2)
    np.testing.assert_allclose(wind.line_integral(b, a), -wind.line_integral(a, b), rtol=1e-9)


@pytest.mark.parametrize(
    "wind", [*FIELDS, sampled(FIELDS[3], (-1000.0, -1000.0, 1000.0, 1000.0), 5, 4)], ids=lambda w: type(w).__name__
)
def test_one_point_is_an_end_of_all_segments(wind: WindField) -> None:
    points = np.random.default_rng(2).uniform(-1000, 1000, (20, 2))
    one = np.tile(points[:1], (20, 1))
    np.testing.assert_array_equal(wind.line_integral(points, points[:1]), wind.line_integral(points, one))
    np.testing.assert_array_equal(wind.line_integral(points[:1], points), wind.line_integral(one, points))
    with pytest.raises(ValueError, match="broadcast"):
        wind.line_integral(points, points[:2])


@pytest.mark.parametrize("wind", FIELDS, ids=lambda w: type(w).__name__)
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
        ({"velocity": [1, 2]}, "the key 'kind' is missing: one of 'uniform'"),
        ({"kind": "uniform", "velocity": [1]}, "velocity"),
        ({"kind": "uniform", "velocty": [1, 2]}, "did you mean 'velocity'"),
        ({"kind": "rotation", "rate": "fast"}, "rate"),
        ({"kind": "shear", "rate": float("nan")}, "rate"),
        ({"kind": "vortices", "centres": [[0, 0]], "circulation": [1.0, 2.0]}, "as many centres"),
        ({"kind": "vortices", "centres": [[0, 0]], "circulation": [1.0], "core": [-1.0]}, "at least 0"),
        ({"kind": "turbulence", "length_scale": 100.0}, "rms"),
        ({"kind": "turbulence", "rms": 1.0, "length_scale": 0.0}, "length_scale must be a positive number"),
        ({"kind": "sum", "parts": []}, "a list of tables, at least one"),
        ({"kind": "sum", "parts": [3]}, r"parts\[0\] must be a table, got 3"),
    ],
)
def test_bad_tables_are_named(table: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        wind_from_toml(table, Path())


def test_grid_line_integral_is_exact_across_cells_and_outside() -> None:
    rng = np.random.default_rng(2)
    grid = Grid((-500.0, -400.0), (90.0, 70.0), *rng.normal(size=(2, 12, 13)))
    a, b = rng.uniform(-800, 1000, (2, 30, 2))
    expected = [quadrature(grid, p, q, 400_001) for p, q in zip(a, b, strict=True)]
    np.testing.assert_allclose(grid.line_integral(a, b), expected, rtol=1e-6, atol=1e-4)
    np.testing.assert_allclose(grid.line_integral(b, a), -grid.line_integral(a, b), rtol=1e-9, atol=1e-9)


def test_grid_line_integral_along_grid_lines() -> None:
    grid = Grid((0.0, 0.0), (1.0, 1.0), np.arange(12.0).reshape(3, 4), np.zeros((3, 4)))
    np.testing.assert_allclose(grid.line_integral([[0.0, 1.0], [3.0, 2.0]], [[3.0, 1.0], [0.0, 2.0]]), [16.5, -28.5])


@pytest.mark.parametrize("wind", FIELDS[:3], ids=lambda w: type(w).__name__)
def test_a_sampled_linear_wind_is_the_wind_itself(wind: WindField) -> None:
    grid = sampled(wind, (-1000.0, -1000.0, 1000.0, 1000.0), 5, 6)
    a, b = np.random.default_rng(3).uniform(-1000, 1000, (2, 20, 2))
    np.testing.assert_allclose(grid.line_integral(a, b), wind.line_integral(a, b), rtol=1e-9, atol=1e-6)


def test_circulation_around_a_point_vortex_is_its_strength() -> None:
    ring = 100 * np.exp(2j * np.pi * np.arange(7) / 7)
    a = np.column_stack([ring.real, ring.imag])
    wind = Vortices(((0.0, 0.0),), (12.5,), (0.0,))
    assert wind.line_integral(a, np.roll(a, -1, axis=0)).sum() == pytest.approx(12.5)
    assert wind.line_integral(a + 500, np.roll(a, -1, axis=0) + 500).sum() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
def test_turbulence_has_the_stated_rms_and_no_divergence() -> None:
    wind = Turbulence(5.0, 2000.0, seed=7)
    grid = sampled(wind, (0.0, 0.0, 40_000.0, 40_000.0), 801, 801)
    assert np.sqrt((grid.u**2 + grid.v**2).mean()) == pytest.approx(5.0, rel=0.15)
    fine = 0.01
    p = np.random.default_rng(0).uniform(0, 4e4, (50, 2))
    east, north = np.array([fine, 0.0]), np.array([0.0, fine])
    divergence = ((wind(p + east) - wind(p - east))[:, 0] + (wind(p + north) - wind(p - north))[:, 1]) / (2 * fine)
    assert np.abs(divergence).max() < 1e-7


def test_missing_values_of_a_grid_are_located() -> None:
    u = np.ones((3, 3))
    u[1, 2] = np.nan
    with pytest.raises(InputError, match=r"1 of 9 values .* first at \(200, 100\) m"):
        Grid((0.0, 0.0), (100.0, 100.0), u, np.ones((3, 3)))
