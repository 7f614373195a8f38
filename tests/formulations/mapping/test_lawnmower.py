"""Lawnmower tours: all lanes are flown once, from the depots and back, fairly shared."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon

from formulations.mapping.flight import Flight
from formulations.mapping.lawnmower import best_lawnmower, lanes, lawnmower_tours, length_of
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


def lengths_of(flights: list[Flight]) -> float:
    return sum(flight.length for flight in flights)


def test_the_best_lawnmower_has_the_fewest_lanes_that_are_long_enough() -> None:
    depots = np.array([[500.0, 500.0], [11.5e3, 500.0]])
    kind = {"speed": 50.0, "radius": 50.0}
    count, flights = best_lawnmower(SQUARE, depots, 90e3, lengths_of, **kind)
    assert len(flights) == 2
    assert lengths_of(flights) >= 90e3
    fewer, _ = best_lawnmower(SQUARE, depots, 60e3, lengths_of, **kind)
    assert 2 <= fewer < count


def test_the_best_lawnmower_is_the_one_of_least_worth() -> None:
    wide = Region.rectangle(20e3, 8e3)
    depots = np.array([[500.0, 500.0]])

    def steps_north(flights: list[Flight]) -> float:
        """How far is flown south–north, of the whole length."""
        poses = flights[0].track(1.0)[1]
        return float(np.abs(np.sin(poses[:, 2])).mean())

    least, most = (
        best_lawnmower(wide, depots, 80e3, worth, speed=50.0, radius=50.0)[1]
        for worth in (steps_north, lambda flights: -steps_north(flights))
    )
    assert steps_north(least) < 0.4
    assert steps_north(most) > 0.6


@pytest.mark.slow
def test_more_depots_than_lanes_are_tried_still_fly() -> None:
    depots = np.column_stack([np.linspace(100, 11_900, 61), np.full(61, 100.0)])
    count, flights = best_lawnmower(SQUARE, depots, 1.0, lengths_of, speed=50.0, radius=50.0)
    assert (count, len(flights)) == (61, 61)
