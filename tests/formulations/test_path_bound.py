"""Path bound: below every tour that is tried, tight where that is known, above what their number alone gives."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import Polygon

from formulations import path_bound as module
from formulations.average_variance import AverageVariance
from formulations.kernel import Matern12, SquaredExponential
from formulations.path_bound import path_bound
from formulations.surveying.problem import length_of, readings
from instances.environment.region import Region

SQUARE = Region.rectangle(8000.0, 6000.0)
DEPOTS = np.array([[500.0, 500.0], [7000.0, 5000.0]])
KERNEL = SquaredExponential(30.0, (2000.0, 3000.0))
TARGETS = SQUARE.cell_centres(12, 12)
JUDGED = AverageVariance(KERNEL, 1.0, TARGETS, weights=np.where(TARGETS[:, 0] < 2000.0, 5.0, 1.0))


def closed(depot: np.ndarray, length: float, draws: np.random.Generator) -> np.ndarray:
    """Return a random tour in the square as long as may be flown at most."""
    tour = np.concatenate([depot[None], draws.uniform((0, 0), (8000, 6000), (draws.integers(2, 7), 2)), depot[None]])
    return depot + min(1.0, length / length_of(tour)) * (tour - depot)


@pytest.mark.parametrize("length", [4000.0, 15_000.0])
def test_no_tour_passes_it_and_it_passes_what_the_number_alone_gives(length):
    draws = np.random.default_rng(1)
    bound = path_bound(JUDGED, SQUARE, DEPOTS, length, 500.0, steps=30)
    for _ in range(40):
        tours = [closed(depot, length, draws) for depot in DEPOTS]
        assert JUDGED.value(np.concatenate([readings(tour, 500.0) for tour in tours])) >= bound
    assert bound > 1.1 * JUDGED.lower_bound(2 * int(length / 500.0))


def test_it_falls_with_length_and_with_what_is_known_and_every_number_of_steps_gives_one():
    def bound(judged: AverageVariance = JUDGED, length: float = 6000.0, steps: int = 20) -> float:
        return path_bound(judged, SQUARE, DEPOTS, length, 500.0, steps)

    assert bound(length=9000.0) < bound() < bound(length=4000.0)
    known = AverageVariance(KERNEL, 1.0, JUDGED.targets, JUDGED.weights, known=SQUARE.cell_centres(4, 3))
    assert bound(known) < bound()
    assert 0.0 <= bound(steps=0) <= bound()


def test_it_is_tight_where_all_readings_can_be_at_the_only_target():
    one = AverageVariance(KERNEL, 1.0, DEPOTS[:1])
    bound = path_bound(one, SQUARE, DEPOTS[:1], 5000.0, 500.0, steps=200)
    exact = 900.0 / (1.0 + 10 * 900.0)
    assert 0.9 * exact <= bound <= exact


def test_without_a_reading_it_is_the_prior():
    assert path_bound(JUDGED, SQUARE, DEPOTS, 400.0, 500.0) == pytest.approx(900.0, rel=1e-5)


def test_what_bounds_the_slope_in_cells_is_above_it_everywhere():
    bent = Region(Polygon([(0, 0), (8000, 0), (8000, 6000), (6000, 6000), (6000, 1000), (0, 1000)]))
    field = module._Field(JUDGED, bent)
    xi = np.random.default_rng(2).exponential(0.03, len(field.places))
    radii = np.array([300.0, 2500.0, 9000.0])
    most = field.greatest(xi, DEPOTS, radii)
    points = np.concatenate([field.places, bent.sample(4000, np.random.default_rng(3))])
    left = field._left(xi)
    phi = field._features(points)
    slopes = np.einsum("ij,ij->i", phi @ (left @ field.wanted @ left), phi)
    for depot, row in zip(DEPOTS, most, strict=True):
        away = np.hypot(*(points - depot).T)
        for radius, ceiling in zip(radii, row, strict=True):
            assert slopes[away <= radius].max() <= ceiling
        assert row[-1] <= 1.5 * slopes.max()  # a cell may reach over the border


def test_its_average_variance_is_that_of_readings():
    field = module._Field(JUDGED, SQUARE)
    xi = np.zeros(len(field.places))
    xi[[5, 40, 77]] = 1.0, 2.0, 1.0
    assert field.value(xi) == pytest.approx(JUDGED.value(field.places[[5, 40, 40, 77]]), rel=1e-8)
    step = np.zeros_like(xi)
    step[60] = 1e-6
    assert (field.value(xi - step) - field.value(xi + step)) / 2e-6 == pytest.approx(field.slopes(xi)[60], rel=1e-5)


def test_for_other_kernels_and_huge_regions_it_is_what_the_number_gives():
    rough = AverageVariance(Matern12(30.0, (2000.0, 2000.0)), 1.0, JUDGED.targets)
    assert path_bound(rough, SQUARE, DEPOTS, 5000.0, 500.0) == rough.lower_bound(20)
    huge = Region.rectangle(200_000.0, 200_000.0)
    assert path_bound(JUDGED, huge, DEPOTS, 5000.0, 500.0) == JUDGED.lower_bound(20)
