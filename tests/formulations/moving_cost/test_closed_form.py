"""The method closed-form: its arcs are confirmed by the independent check, and refused where a region is in the way."""

import numpy as np
import pytest
import shapely

from formulations.moving_cost.closed_form import arcs
from formulations.moving_cost.costing import CALM, solve_query
from formulations.moving_cost.method import Query
from instances import InputError
from instances.environment.region import Region
from instances.environment.wind import Rotation, Shear, Uniform, WindField
from instances.environment.wind_table import Sum
from instances.environment.wind_vortices import Vortices
from instances.paths import check_paths

V0 = 20.0
WINDS = [
    CALM,
    Uniform((5.0, -3.0)),
    Shear(1.2e-3, (0.0, 10_000.0)),
    Rotation(5e-4, (10_000.0, 10_000.0)),
    Rotation(-5e-4, (9_000.0, 11_000.0)),
    Rotation(1e-13),
    Sum((Uniform((3.0, 1.0)), Shear(-1e-3, (0.0, 9_000.0)))),
]
SQUARE = Region.rectangle(20_000.0, 20_000.0)
INNER = np.random.default_rng(4).uniform(6_000, 14_000, (6, 2))
"""Terminals far enough from the border for every arc between them."""


@pytest.mark.parametrize("wind", WINDS, ids=lambda wind: type(wind).__name__)
def test_its_arcs_cost_what_it_says(wind: WindField) -> None:
    found = solve_query(Query(INNER, SQUARE, wind, V0), "closed-form")
    assert check_paths(found.paths, found.cost, INNER, SQUARE, wind, V0) == []


def test_arcs_turn_left_for_positive_curvature() -> None:
    path = arcs(np.array([[0.0, 0.0], [1000.0, 0.0]]), 1 / 2000.0).between(0, 1)
    radius = np.hypot(*(path - [500.0, np.sqrt(2000.0**2 - 500.0**2)]).T)
    np.testing.assert_allclose(radius, 2000.0, rtol=1e-12)
    assert path[1:-1, 1].max() < 0


def test_an_arc_that_leaves_the_region_is_refused() -> None:
    wind = Rotation(5e-4, (10_000.0, 10_000.0))
    border = np.array([[10.0, 5_000.0], [10.0, 15_000.0]])
    with pytest.raises(InputError, match=r"from node [01] to node [01] .* leaves the region .* try refined"):
        solve_query(Query(border, SQUARE, wind, V0), "closed-form")
    ends = np.array([[5_000.0, 10_000.0], [15_000.0, 10_000.0]])
    holed = SQUARE.minus([shapely.box(9_000, 9_000, 11_000, 11_000)])
    with pytest.raises(InputError, match=r"enters a no-fly zone \(2 paths do\)"):
        solve_query(Query(ends, holed, CALM, V0), "closed-form")


def test_a_wind_without_closed_form_is_refused() -> None:
    whirl = Vortices(((0.0, 0.0),), (1.0,), (10.0,))
    with pytest.raises(InputError, match="there is no closed form for a Vortices"):
        solve_query(Query(INNER, SQUARE, whirl, V0), "closed-form")
