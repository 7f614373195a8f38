"""Lawnmower tours: all lanes are flown once, from the depots and back, fairly shared."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon

from formulations.mapping.lawnmower import lanes, lawnmower_tours, length_of
from instances.environment.region import Region

SQUARE = Region.rectangle(12e3, 12e3)


def test_lanes_of_a_square_known_by_hand() -> None:
    track = lanes(SQUARE, 3, along=0)
    expected = [[2e3, 2e3], [10e3, 2e3], [10e3, 6e3], [2e3, 6e3], [2e3, 10e3], [10e3, 10e3]]
    np.testing.assert_allclose(track, expected)
    np.testing.assert_allclose(lanes(SQUARE, 3, along=1), np.array(expected)[:, ::-1])


def test_lanes_keep_to_a_region_that_is_no_rectangle() -> None:
    triangle = Region(Polygon([(0, 0), (10e3, 0), (0, 10e3)]))
    assert triangle.contains(lanes(triangle, 5, along=0, inset=0.1)).all()


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("depots", [[[0.0, 0.0]], [[6e3, 11e3], [500.0, 500.0], [11.5e3, 500.0]]])
def test_tours_are_closed_and_cover_the_track_once(along: int, depots: list[list[float]]) -> None:
    tours = lawnmower_tours(SQUARE, depots, 6, along)
    track = lanes(SQUARE, 6, along)
    assert len(tours) == len(depots)
    for tour, depot in zip(tours, depots, strict=True):
        np.testing.assert_array_equal(tour[[0, -1]], [depot, depot])
    flown = [tour[1:-1] for tour in tours]
    assert sum(map(length_of, flown)) == pytest.approx(length_of(track))
    covered = shapely.union_all([shapely.LineString(part).buffer(1.0) for part in flown])
    assert covered.covers(shapely.LineString(track))


def test_the_longest_tour_is_shorter_than_with_equal_stretches() -> None:
    depots = np.array([[6e3, 11e3], [500.0, 500.0], [11.5e3, 500.0]])
    lengths = [length_of(tour) for tour in lawnmower_tours(SQUARE, depots, 6, 0)]
    assert max(lengths) <= 1.05 * np.mean(lengths)
