"""Headings are chosen so that turns stay inside: a task or depot beside a border is passed along it."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from formulations.mapping.flight import plan_flight
from formulations.mapping.flight_check import RESOLUTION, margin
from instances.arrays import Floats
from instances.environment.region import Region

SQUARE = box(0.0, 0.0, 4000.0, 4000.0)


def tour(*stops: tuple[float, float]) -> list[Floats]:
    return [np.array([a, b], dtype=float) for a, b in zip(stops, [*stops[1:], stops[0]], strict=True)]


BULGING = tour((3.0, 500.0), (2500.0, 3500.0), (1500.0, 3998.0), (300.0, 3000.0))


def test_turns_beside_a_border_stay_inside() -> None:
    free, kept = plan_flight(BULGING, radius=50.0), plan_flight(BULGING, radius=50.0, within=SQUARE)
    assert margin(free, Region(SQUARE)).distance < -10.0
    assert margin(kept, Region(SQUARE)).distance >= -RESOLUTION
    assert free.length < kept.length < free.length + 500.0


def test_a_tour_that_stays_inside_is_not_changed() -> None:
    legs = tour((500.0, 500.0), (2500.0, 3500.0), (1500.0, 2000.0))
    free, kept = plan_flight(legs, radius=50.0), plan_flight(legs, radius=50.0, within=SQUARE)
    np.testing.assert_array_equal(free.starts, kept.starts)
    np.testing.assert_array_equal(free.segments, kept.segments)


def test_where_no_turn_fits_the_tour_is_the_shortest() -> None:
    legs = tour((0.5, 0.5), (2500.0, 3500.0))  # in the very corner
    free, kept = plan_flight(legs, radius=50.0), plan_flight(legs, radius=50.0, within=SQUARE)
    assert kept.length == pytest.approx(free.length)
    assert margin(kept, Region(SQUARE)).distance < -1.0


def test_a_zone_beside_the_track_is_kept_free_of_turns() -> None:
    legs = tour((500.0, 500.0), (2000.0, 2000.0), (3500.0, 1200.0))
    zone = box(1500.0, 2001.0, 2500.0, 2300.0)
    within = Polygon(SQUARE.exterior, [zone.exterior.coords])
    assert margin(plan_flight(legs, radius=50.0), Region(SQUARE), [zone]).distance < -0.1
    kept = plan_flight(legs, radius=50.0, within=within)
    assert margin(kept, Region(SQUARE), [zone]).distance >= -RESOLUTION
