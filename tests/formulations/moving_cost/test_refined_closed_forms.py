"""`refined` against closed forms: constant vorticity, potential winds around polygons, a point vortex in a disc."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import shapely
from scipy.optimize import brentq

from formulations.moving_cost.costing import CALM
from formulations.moving_cost.method import Query
from formulations.moving_cost.refined import Refined
from instances.environment.region import Region
from instances.environment.wind import Rotation, Shear, Uniform, WindField
from instances.environment.wind_grid import Grid
from instances.environment.wind_table import Sum
from instances.environment.wind_vortices import Vortices
from instances.wind_metric import cost_matrix

SIDE = 20_000.0
INNER = np.random.default_rng(4).uniform(6_000, 14_000, (6, 2))
"""Terminals far enough from the border for every arc between them."""
ZONES = [
    shapely.Polygon([(8000, 8500), (12500, 9000), (10500, 12000)]),
    shapely.Polygon([(4000, 13000), (7000, 12500), (6500, 15500), (5500, 14000)]),
    shapely.box(13_000, 3_000, 15_000, 10_000),
]
SMALL = Refined(samples=800)


@pytest.mark.parametrize(
    ("wind", "v0"),
    [
        (Uniform((-7.0, -7.0)), 20.0),
        (Rotation(5e-4, (9000.0, 11_000.0)), 20.0),
        (Rotation(-5e-4, (9000.0, 11_000.0)), 40.0),
        (Shear(1.2e-3, (0.0, 10_000.0)), 20.0),
        (Sum((Uniform((3.0, 1.0)), Shear(-1e-3, (0.0, 9_000.0)))), 25.0),
    ],
)
def test_constant_vorticity(wind: WindField, v0: float) -> None:
    region = Region.rectangle(SIDE, SIDE)
    found = SMALL.solve(Query(INNER, region, wind, v0)).cost
    expected = cost_matrix(INNER, v0, wind)
    off = ~np.eye(6, dtype=bool)
    np.testing.assert_allclose(found[off], expected[off], rtol=1e-5)


def visibility_lengths(points: np.ndarray, region: Region) -> np.ndarray:
    """Shortest lengths through the corners of polygons by shapely and Floyd–Warshall: the slow twin."""
    corners = np.concatenate([np.asarray(ring.coords)[:-1] for ring in region.polygon.interiors])
    nodes = np.concatenate([points, corners])
    lines = shapely.linestrings([[(a, b) for b in nodes] for a in nodes])
    seen = shapely.covers(region.polygon.buffer(1e-7), lines)
    d = np.where(seen, np.hypot(*(nodes[:, None] - nodes[None]).transpose(2, 0, 1)), np.inf)
    for k in range(len(d)):
        d = np.minimum(d, d[:, k, None] + d[None, k])
    return d[: len(points), : len(points)]


POTENTIAL: dict[str, tuple[WindField, Callable[[np.ndarray], np.ndarray]]] = {
    "calm": (CALM, lambda p: np.zeros(len(p))),
    "uniform": (Uniform((12.0, -9.0)), lambda p: p @ np.array([12.0, -9.0])),
    "saddle": (
        Grid((0.0, 0.0), (SIDE, SIDE), np.array([[0.0, 0.0], [14.0, 14.0]]), np.array([[0.0, 14.0], [0.0, 14.0]])),
        lambda p: 7e-4 * p[:, 0] * p[:, 1],
    ),
    "vortex outside": (
        Vortices(((-4000.0, 9000.0),), (2e5,), (0.0,)),
        lambda p: 2e5 / (2 * np.pi) * np.arctan2(p[:, 1] - 9000.0, p[:, 0] + 4000.0),
    ),
}


@pytest.mark.parametrize("name", POTENTIAL)
def test_potential_winds_around_polygons_to_rounding(name: str) -> None:
    wind, phi = POTENTIAL[name]
    region = Region.rectangle(SIDE, SIDE).minus(ZONES)
    terminals = region.sample(10, np.random.default_rng(8))
    v0 = 40.0
    found = SMALL.solve(Query(terminals, region, wind, v0)).cost
    p = phi(terminals) / v0**2
    tau = visibility_lengths(terminals, region) / v0
    expected = tau - (p[None, :] - p[:, None])
    off = ~np.eye(len(terminals), dtype=bool)
    assert (np.abs(found - expected)[off] / tau[off]).max() <= 1e-12


def test_point_vortex_in_a_disc() -> None:
    """C = min over both sides s of L_s/v0 − s Γ D_s/(2π v0²), L_s the taut string, D_s the angle it sweeps."""
    centre, radius, gamma, v0 = np.array([10_000.0, 10_000.0]), 2_000.0, 1.5e5, 20.0
    corners = 720
    angle = 2 * np.pi * np.arange(corners) / corners
    wrapped = radius * (np.pi / corners) / math.sin(np.pi / corners)  # a polygon as long as the circle
    disc = shapely.Polygon(centre + wrapped * np.column_stack([np.cos(angle), np.sin(angle)]))
    region = Region.rectangle(SIDE, SIDE).minus([disc])
    terminals = np.array([[3000.0, 9500.0], [17_500.0, 10_800.0], [9000.0, 16_000.0], [12_000.0, 4000.0]])
    wind = Vortices((tuple(centre),), (gamma,), (0.0,))
    found = SMALL.solve(Query(terminals, region, wind, v0)).cost
    r = np.hypot(*(terminals - centre).T)
    theta = np.arctan2(*(terminals - centre).T[::-1])
    for i in range(4):
        for j in range(4):
            if i == j:
                continue
            costs = []
            for s in (1, -1):
                swept = (s * (theta[j] - theta[i])) % (2 * np.pi)
                around = swept - math.acos(radius / r[i]) - math.acos(radius / r[j])
                if around > 0:
                    length = math.sqrt(r[i] ** 2 - radius**2) + math.sqrt(r[j] ** 2 - radius**2) + radius * around
                else:
                    length = math.hypot(*(terminals[j] - terminals[i]))
                if swept < np.pi or around > 0:
                    costs.append(length / v0 - s * gamma * swept / (2 * np.pi * v0**2))
            assert found[i, j] == pytest.approx(min(costs), rel=1e-5)


def test_parallel_shear() -> None:
    """w = (U(y), 0): cos θ/v0 − U/v0² = p is conserved along a geodesic, which p makes end where it should."""

    def u(y: np.ndarray) -> np.ndarray:
        return 8 * np.sin(2 * np.pi * y / 12_000.0)

    rows = np.repeat(u(np.linspace(0.0, SIDE, 4001))[:, None], 2, axis=1)
    wind = Grid((0.0, 0.0), (SIDE, 5.0), rows, np.zeros_like(rows))
    v0 = 20.0
    terminals = np.array([[5500.0, 4000.0], [14_000.0, 15_000.0], [9000.0, 16_500.0], [12_000.0, 5500.0]])
    found = SMALL.solve(Query(terminals, Region.rectangle(SIDE, SIDE), wind, v0)).cost
    for i, j in ((0, 1), (1, 0), (0, 2), (2, 0), (3, 1), (1, 3), (2, 3), (3, 2)):
        (xa, ya), (xb, yb) = terminals[i], terminals[j]
        y = ya + (np.arange(40_000) + 0.5) / 40_000 * (yb - ya)
        dy = abs(yb - ya) / 40_000

        def cosine(p: float, y: np.ndarray = y) -> np.ndarray:
            return v0 * p + u(y) / v0

        def miss(p: float, y: np.ndarray = y, dy: float = dy, dx: float = xb - xa) -> float:
            c = cosine(p, y)
            return float((c / np.sqrt(1 - c * c)).sum() * dy - dx)

        low, high = -1 - (u(y) / v0).min(), 1 - (u(y) / v0).max()
        c = cosine(brentq(miss, (low + 1e-3) / v0, (high - 1e-3) / v0, xtol=1e-15))
        expected = float(((1 / v0 - u(y) * c / v0**2) / np.sqrt(1 - c * c)).sum() * dy)
        assert found[i, j] == pytest.approx(expected, rel=1e-5)
