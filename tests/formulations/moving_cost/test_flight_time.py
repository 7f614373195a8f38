"""Paths of least flight time: against Zermelo's navigation equation, closed forms and each other."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.integrate import solve_ivp

from formulations.moving_cost.costing import instance_of, query_of
from formulations.moving_cost.method import Query
from formulations.moving_cost.newton_terms import GAUSS_1, GAUSS_2
from formulations.moving_cost.newton_time import time_terms
from formulations.moving_cost.registry import make_method
from formulations.moving_cost.wind_surface import wind_at, wind_surface
from instances import InputError
from instances.environment.region import Region
from instances.environment.wind import Rotation, Shear, Uniform
from instances.environment.wind_vortices import Vortices
from instances.moving_cost import CostKind
from instances.paths import check_paths
from instances.scenario import Scenario

AIRSPEED, SIDE = 20.0, 20_000.0
SQUARE = Region.rectangle(SIDE, SIDE)
WHIRL = Vortices(((9000.0, 10_500.0),), (2e5,), (2000.0,))


def checked(query, name="refined", **options):
    found = make_method(name, options).solve(query)
    faults = check_paths(found.paths, found.cost, query.terminals, query.region, query.wind, query.v0, kind=query.kind)
    assert faults == []
    return found


def quickest_from(start, heading, seconds, wind):
    """Where the path of least time leads that leaves `start` with this air heading (Zermelo 1931)."""

    def slopes(p):
        east, north = (wind([p + step]) - wind([p - step]) for step in (np.array([0.01, 0.0]), np.array([0.0, 0.01])))
        return np.column_stack([east[0], north[0]]) / 0.02

    def rate(_, y):
        (ux, uy), (vx, vy) = slopes(y[:2])
        s, c = np.sin(y[2]), np.cos(y[2])
        u, v = wind([y[:2]])[0]
        return [AIRSPEED * c + u, AIRSPEED * s + v, s * s * vx + s * c * (ux - vy) - c * c * uy]

    return solve_ivp(rate, (0, seconds), [*start, heading], rtol=1e-10, atol=1e-7).y[:2, -1]


@pytest.mark.parametrize("wind", [Rotation(1e-3, (11_000.0, 9000.0)), Shear(1.2e-3, (0.0, 9000.0)), WHIRL])
def test_refined_finds_what_zermelos_equation_finds(wind):
    start, times = np.array([4000.0, 6000.0]), [500.0, 400.0, 300.0]
    ends = [quickest_from(start, heading, t, wind) for heading, t in zip((0.3, 0.8, 1.5), times, strict=True)]
    query = Query(np.vstack([start, ends]), SQUARE, wind, AIRSPEED, CostKind.TIME)
    np.testing.assert_allclose(checked(query, samples=800, precision=1e-7).cost[0, 1:], times, rtol=1e-6)


def test_the_newton_step_uses_the_derivatives_of_the_time():
    surface = wind_surface(WHIRL, SQUARE.bounds, (125.0, 125.0))
    p = np.column_stack([np.linspace(3000, 15_000, 12), 9500 + np.random.default_rng(1).normal(0, 160, 12)])
    normal = np.zeros_like(p)
    chord = p[2:] - p[:-2]
    normal[1:-1] = np.column_stack([-chord[:, 1], chord[:, 0]]) / np.hypot(*chord.T)[:, None]
    moves = 0.05 * np.eye(12)

    def cost(y):
        q, total = p + y[:, None] * normal, 0.0
        out, room = np.empty((2, 6)), np.empty((2, 3, 4))
        for a, d in zip(q[:-1], np.diff(q, axis=0), strict=True):
            for s in (GAUSS_1, GAUSS_2):
                wind_at(*(a + s * d), surface, *room, out)
                w = out[:, 0]
                left = AIRSPEED**2 - w @ w
                total += 0.5 * AIRSPEED * (np.sqrt((w @ d) ** 2 + d @ d * left) - w @ d) / left
        return total

    terms = time_terms(p, normal, surface, AIRSPEED)
    np.testing.assert_allclose(terms.g, [(cost(y) - cost(-y)) / 0.1 for y in moves], atol=1e-7)
    slopes = [
        (time_terms(p + y[:, None] * normal, normal, surface, AIRSPEED).g
         - time_terms(p - y[:, None] * normal, normal, surface, AIRSPEED).g) / 0.1
        for y in moves
    ]  # fmt: skip
    np.testing.assert_allclose(terms.diagonal + terms.bend, np.diag(slopes), atol=1e-9)
    np.testing.assert_allclose((terms.off + terms.off_bend)[:-1], np.diag(slopes, 1), atol=1e-9)
    assert (terms.diagonal[1:-1] > 0).all()


def test_the_surface_has_the_winds_values_and_slopes():
    surface = wind_surface(WHIRL, SQUARE.bounds, (125.0, 125.0))
    out, room = np.empty((2, 6)), np.empty((2, 3, 4))
    for x, y in np.random.default_rng(0).uniform(0, SIDE, (50, 2)):
        wind_at(x, y, surface, *room, out)
        np.testing.assert_allclose(out[:, 0], WHIRL([(x, y)])[0], atol=1e-3)
        east = (WHIRL([(x + 1, y)]) - WHIRL([(x - 1, y)]))[0] / 2
        np.testing.assert_allclose(out[:, 1], east, atol=1e-4)


ZONE = shapely.Polygon([(9000, 4000), (13_000, 6000), (11_000, 12_000), (9500, 11_000)])
AROUND = Query(
    np.random.default_rng(5).uniform([1000, 1000], [8000, 19_000], (6, 2)) + np.array([[0, 0], [11_000, 0]] * 3),
    SQUARE.minus([ZONE]), WHIRL, AIRSPEED, CostKind.TIME,
)  # fmt: skip


@pytest.mark.parametrize("name", ["fmt-star", "dijkstra"])
def test_the_searches_agree_with_refined_as_they_do_for_energy(name):
    off = ~np.eye(6, dtype=bool)
    excess = {}
    for kind in CostKind:
        query = replace(AROUND, kind=kind)
        best = checked(query, samples=800).cost[off]
        excess[kind] = checked(query, name, samples=1500, radius_factor=2.0).cost[off] / best - 1
        assert excess[kind].min() > -2e-6
    assert excess[CostKind.TIME].mean() < 1.5 * excess[CostKind.ENERGY].mean() < 0.02


def test_closed_form_and_refined_agree_in_a_uniform_wind():
    query = replace(AROUND, region=SQUARE, wind=Uniform((9.0, -5.0)))
    closed = checked(query, "closed-form").cost
    np.testing.assert_allclose(checked(query, samples=300).cost, closed, rtol=1e-9)
    with pytest.raises(InputError, match="closed-form: flight time has one in a uniform wind only, not in Vortices"):
        make_method("closed-form").solve(replace(query, wind=WHIRL))


def test_calm_air_makes_time_and_energy_the_same():
    calm = replace(AROUND, wind=Uniform((0.0, 0.0)))
    energy = checked(replace(calm, kind=CostKind.ENERGY), samples=300).cost
    np.testing.assert_allclose(checked(calm, samples=300).cost, energy, rtol=1e-9)


@pytest.mark.parametrize("name", ["refined", "fmt-star", "dijkstra"])
def test_a_wind_as_strong_as_the_airspeed_is_refused_with_its_place(name):
    with pytest.raises(InputError, match=r"wind: at \(\d+, \d+\) m it blows with .* than the airspeed of 5 m/s"):
        make_method(name, {"samples": 50}).solve(replace(AROUND, v0=5.0))


def test_an_instance_of_times_says_so():
    scenario = Scenario(
        "s", SQUARE, np.array([[500.0, 500.0]]), AIRSPEED, WHIRL, np.array([[9000.0, 9000.0]]), cost=CostKind.TIME
    )
    assert query_of(scenario).kind is CostKind.TIME
    instance, _ = instance_of(scenario, "dijkstra", {"samples": 50})
    assert instance.provenance["moving_cost"]["cost"] == "time"
    energy, _ = instance_of(replace(scenario, cost=CostKind.ENERGY), "dijkstra", {"samples": 50})
    assert "cost" not in energy.provenance["moving_cost"]
    assert instance.cost.sum() > energy.cost.sum()
