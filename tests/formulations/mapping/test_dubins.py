"""Dubins paths against a geometric construction, closed forms and laws."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from formulations.mapping import dubins

RADIUS = 50.0


def geometric_length(p0: tuple[float, float, float], p1: tuple[float, float, float], r: float) -> float:
    """Length by circles and tangents, all words, in the plane (no normal form): an independent way."""
    best = math.inf
    for s0, s1 in itertools.product((1, -1), repeat=2):
        a = np.array(p0[:2]) + s0 * r * np.array([-math.sin(p0[2]), math.cos(p0[2])])
        b = np.array(p1[:2]) + s1 * r * np.array([-math.sin(p1[2]), math.cos(p1[2])])
        gap = b - a
        distance = math.hypot(*gap)
        direction = math.atan2(gap[1], gap[0])
        if s0 == s1:  # outer tangent, then the third-circle words
            best = min(best, _arc(p0[2], direction, s0) * r + distance + _arc(direction, p1[2], s0) * r)
            if distance < 4 * r:
                for side in (1, -1):
                    apex = direction + side * math.acos(distance / (4 * r))
                    centre = a + 2 * r * np.array([math.cos(apex), math.sin(apex)])
                    touch0, touch1 = (centre - a) / (2 * r), (b - centre) / (2 * r)
                    h0 = math.atan2(touch0[1], touch0[0]) + s0 * math.pi / 2
                    h1 = math.atan2(touch1[1], touch1[0]) - s0 * math.pi / 2
                    middle = _arc(h0, h1, -s0)
                    best = min(best, (_arc(p0[2], h0, s0) + middle + _arc(h1, p1[2], s0)) * r)
        elif distance >= 2 * r:  # inner tangent
            tilt = math.asin(2 * r / distance)
            h = direction + s0 * tilt
            straight = math.sqrt(distance**2 - 4 * r**2)
            best = min(best, _arc(p0[2], h, s0) * r + straight + _arc(h, p1[2], s1) * r)
    return best


def _arc(h0: float, h1: float, sign: int) -> float:
    angle = (sign * (h1 - h0)) % (2 * math.pi)
    return 0.0 if angle > 2 * math.pi - 1e-10 else angle


def test_length_agrees_with_a_geometric_construction_on_5000_random_pairs() -> None:
    rng = np.random.default_rng(1)
    for k in range(5000):
        reach = 120.0 if k % 2 else 2000.0  # half of them near, where the three-arc words live
        x, y = rng.uniform(-reach, reach, 2)
        h0, h1 = rng.uniform(-math.pi, math.pi, 2)
        expected = geometric_length((0.0, 0.0, h0), (x, y, h1), RADIUS)
        assert dubins.dubins_length(0.0, 0.0, h0, x, y, h1, RADIUS) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("goal", "length"),
    [
        ((300.0, 0.0, 0.0), 300.0),
        ((0.0, 100.0, math.pi), 50.0 * math.pi),
        ((0.0, -100.0, math.pi), 50.0 * math.pi),
        ((0.0, 0.0, 0.0), 0.0),
        ((50.0, 50.0, math.pi / 2), 25.0 * math.pi),
        ((0.0, 0.0, math.pi), 50.0 * math.pi * 7 / 3),  # turning on the spot: three arcs of 60°, 300°, 60°
    ],
)
def test_closed_forms(goal: tuple[float, float, float], length: float) -> None:
    assert dubins.dubins_length(0.0, 0.0, 0.0, *goal, RADIUS) == pytest.approx(length, abs=1e-9)


pose = st.tuples(st.floats(-500, 500), st.floats(-500, 500), st.floats(-7, 7))


@settings(deadline=None)
@given(pose, pose, pose)
@example((-6e-8, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # so near that a middle arc of 2π once counted as 0
def test_laws(p: tuple[float, float, float], q: tuple[float, float, float], via: tuple[float, float, float]) -> None:
    length = dubins.dubins_length(*p, *q, RADIUS)
    assert length >= math.hypot(q[0] - p[0], q[1] - p[1]) - 1e-9
    # flown backwards with reversed headings it is as long
    back = dubins.dubins_length(q[0], q[1], q[2] + math.pi, p[0], p[1], p[2] + math.pi, RADIUS)
    assert back == pytest.approx(length, abs=1e-6)
    detour = dubins.dubins_length(*p, *via, RADIUS) + dubins.dubins_length(*via, *q, RADIUS)
    assert length <= detour + 1e-6


@settings(deadline=None)
@given(pose, pose)
def test_the_segments_lead_to_the_goal(p: tuple[float, float, float], q: tuple[float, float, float]) -> None:
    word, *lengths = dubins.dubins_path(*p, *q, RADIUS)
    x, y, h = p
    for turn, length in zip(dubins.TURNS[word], lengths, strict=True):
        x, y, h = dubins.advance(x, y, h, int(turn), length, RADIUS)
    assert (x, y) == pytest.approx(q[:2], abs=1e-6)
    assert math.cos(h - q[2]) == pytest.approx(1.0, abs=1e-9)


def test_closed_programme_is_the_best_of_all_heading_choices() -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(0, 400, (4, 2))
    headings = rng.uniform(0, 2 * math.pi, (4, 5))
    cost = dubins.heading_costs(points, headings, RADIUS)
    length, choice = dubins.closed_programme(cost)
    legs = range(4)
    best = min(sum(cost[k, c[k], c[(k + 1) % 4]] for k in legs) for c in itertools.product(range(5), repeat=4))
    assert length == pytest.approx(best, rel=1e-12)
    assert sum(cost[k, choice[k], choice[(k + 1) % 4]] for k in legs) == pytest.approx(best, rel=1e-12)
