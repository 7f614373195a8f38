"""Laws of the moving cost, obstacles included (hypothesis), and what every method must keep."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.moving_cost.costing import CALM
from formulations.moving_cost.method import MovingCosts, Query
from formulations.moving_cost.refined import Refined
from formulations.moving_cost.registry import METHODS, make_method
from instances import InputError
from instances.environment.region import Region
from instances.environment.wind import Uniform
from instances.environment.wind_table import Sum
from instances.environment.wind_vortices import Vortices
from instances.paths import check_paths

SIDE, V0, N = 10_000.0, 20.0, 5
OFF = ~np.eye(N, dtype=bool)
LAWS = settings(deadline=None, max_examples=6, derandomize=True)


@st.composite
def queries(draw: st.DrawFn) -> Query:
    """Up to three polygons as no-fly zones, one or two vortices, five terminals in a 10 km square."""
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    zones = []
    for _ in range(draw(st.integers(0, 3))):
        corners = np.sort(rng.uniform(0, 2 * np.pi, draw(st.integers(3, 6))))
        ring = rng.uniform(2000, 8000, 2) + rng.uniform(600, 1500) * np.column_stack([np.cos(corners), np.sin(corners)])
        zone = shapely.Polygon(ring)
        if zone.area > 1e5 and all(zone.distance(other) > 50 for other in zones):
            zones.append(zone)
    region = Region.rectangle(SIDE, SIDE).minus(zones)
    vortices = draw(st.integers(1, 2))
    wind = Vortices(
        tuple(map(tuple, rng.uniform(0, SIDE, (vortices, 2)))),
        tuple(rng.uniform(-6e4, 6e4, vortices)),
        tuple(rng.uniform(800, 1500, vortices)),
    )
    return Query(region.sample(N, rng), region, wind, V0)


def solved(query: Query) -> MovingCosts:
    return Refined(samples=400).solve(query)


@LAWS
@given(queries())
def test_paths_are_confirmed_and_no_random_search_beats_them(query: Query) -> None:
    found = solved(query)
    assert check_paths(found.paths, found.cost, query.terminals, query.region, query.wind, V0) == []
    random = make_method("dijkstra", {"samples": 500, "radius_factor": 2.0}).solve(query)
    assert check_paths(random.paths, random.cost, query.terminals, query.region, query.wind, V0) == []
    assert (found.cost <= random.cost + 1e-9 * random.cost.max()).all()


@LAWS
@given(queries())
def test_flying_back_in_the_opposite_wind_costs_the_same(query: Query) -> None:
    against = Vortices(query.wind.centres, tuple(-g for g in query.wind.circulation), query.wind.core)  # type: ignore[attr-defined]
    back = solved(Query(query.terminals, query.region, against, V0)).cost.T
    np.testing.assert_allclose(solved(query).cost, back, rtol=2e-5)


@LAWS
@given(queries(), st.floats(-3, 3), st.floats(-3, 3))
def test_a_uniform_wind_on_top_shifts_costs_by_its_potential(query: Query, u: float, v: float) -> None:
    shifted = solved(Query(query.terminals, query.region, Sum((query.wind, Uniform((u, v)))), V0)).cost
    p = query.terminals @ np.array([u, v]) / V0**2
    expected = solved(query).cost - (p[None, :] - p[:, None])
    np.testing.assert_allclose(shifted, expected, atol=2e-5 * expected.max())


@LAWS
@given(queries())
def test_triangle_inequality_and_the_way_there_and_back(query: Query) -> None:
    c = solved(query).cost
    through = (c[:, :, None] + c[None, :, :]).min(axis=1)
    assert (c <= through * (1 + 1e-6) + 1e-9).all()
    calm = solved(Query(query.terminals, query.region, CALM, V0)).cost
    # The shortest path there and back costs 2 L/v0 in any wind; the best ones cost no more.
    assert ((c + c.T) <= 2 * calm * (1 + 1e-6))[OFF].all()


@LAWS
@given(queries(), st.permutations(range(N)))
def test_a_closed_tour_in_a_potential_wind_costs_its_length(query: Query, tour: list[int]) -> None:
    outside = Vortices(((-3000.0, 4000.0),), (1.5e5,), (0.0,))
    c = solved(Query(query.terminals, query.region, outside, V0)).cost
    calm = solved(Query(query.terminals, query.region, CALM, V0)).cost
    legs = (tour, [*tour[1:], tour[0]])
    assert c[legs].sum() == pytest.approx(calm[legs].sum(), rel=1e-12)


EASY = Query(
    np.random.default_rng(5).uniform(500, 9500, (6, 2)),
    Region.rectangle(SIDE, SIDE).minus([shapely.box(4000, 4000, 4400, 4400)]),
    Vortices(((5000.0, 5000.0),), (4e4,), (1000.0,)),
    V0,
)


@pytest.mark.parametrize(
    "name", [name for name in METHODS.targets() if name != "closed-form"]
)  # that needs constant vorticity
def test_every_method_returns_confirmed_paths_and_the_same_ones_again(name: str) -> None:
    options = {"samples": 600}
    found, again = (make_method(name, options).solve(EASY) for _ in range(2))
    assert check_paths(found.paths, found.cost, EASY.terminals, EASY.region, EASY.wind, V0) == []
    np.testing.assert_array_equal(found.cost, again.cost)
    assert (np.diagonal(found.cost) == 0).all()


def test_dijkstra_is_never_worse_than_fmt_star_and_sharing_changes_nothing() -> None:
    options = {"samples": 800, "radius_factor": 1.3, "seed": 3}
    tree = make_method("fmt-star", options).solve(EASY)
    unshared = make_method("fmt-star", {**options, "share": False}).solve(EASY)
    exact = make_method("dijkstra", options).solve(EASY)
    np.testing.assert_array_equal(tree.cost, unshared.cost)
    assert (exact.cost <= tree.cost * (1 + 1e-12)).all()
    assert tree.cost.sum() <= 1.01 * exact.cost.sum()
    assert unshared.statistics["collision_tests"] > tree.statistics["collision_tests"]


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("fmt-tree", {}, "did you mean 'fmt-star'"),
        ("refined", {"sample": 3}, "did you mean 'samples'"),
        ("refined", {"samples": 1.5}, "a whole number"),
        ("refined", {"samples": 0}, "at least 1"),
        ("dijkstra", {"radius_factor": -1.0}, "radius_factor from 0 to"),
        ("fmt-star", {"share": 1}, "true or false"),
    ],
)
def test_bad_methods_and_options_are_named(name: str, options: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        make_method(name, options)
