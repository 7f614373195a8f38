"""Paths that nothing but a vortex parts."""

import numpy as np
import pytest

from formulations.moving_cost.cores import vortex_cores
from formulations.moving_cost.field import search_field
from formulations.moving_cost.method import Query
from formulations.moving_cost.refined import Refined
from instances.environment.region import Region
from instances.environment.wind import Rotation, Uniform
from instances.environment.wind_table import Sum
from instances.environment.wind_vortices import Vortices
from instances.paths import check_paths

SIDE = 20_000.0
SQUARE = Region.rectangle(SIDE, SIDE)
CENTRES = ((6000.0, 12_000.0), (14_000.0, 7000.0))
PAIR = Vortices(CENTRES, (1.5e5, -1.2e5), (1500.0, 1200.0))


def cores(wind, speed=20.0):
    query = Query(np.zeros((0, 2)), SQUARE, wind, speed)
    return vortex_cores(search_field(query.measure, SQUARE).bending, SQUARE)


def test_cores_are_where_the_vortices_are_strongest_first():
    found = cores(Sum((Uniform((4.0, -3.0)), PAIR)))
    np.testing.assert_allclose(found, [CENTRES[1], CENTRES[0]], atol=100.0)


@pytest.mark.parametrize(("wind", "speed"), [(PAIR, 200.0), (Rotation(2e-4), 20.0), (Uniform((5.0, 0.0)), 20.0)])
def test_what_bends_paths_alike_or_hardly_at_all_has_no_cores(wind, speed):
    assert len(cores(wind, speed)) == 0


def test_refined_passes_a_vortex_on_the_better_side():
    """Between the two lies open country: the lattice led east of the vortex, at 946.066 s."""
    wind = Sum((Uniform((1.1, -1.2)), Vortices(((8866.0, 3476.0),), (-157_000.0,), (1807.0,))))
    query = Query(np.array([[11_950.0, 1890.0], [12_880.0, 18_050.0]]), SQUARE, wind, 20.0)
    found = Refined().solve(query)
    assert check_paths(found.paths, found.cost, query.terminals, SQUARE, wind, 20.0) == []
    assert found.cost[0, 1] == pytest.approx(941.040, abs=0.01)
    assert found.statistics["rivals"] > 0
