"""Interval lengths: never above any choice of headings, Dubins lengths where sectors have no width."""

from __future__ import annotations

import math

import numpy as np
import pytest

from formulations.mapping.dubins import dubins_length
from formulations.moving_cost.turns.interval import interval_length, interval_lengths
from instances.kernels import njit

Case = tuple[float, float, float, float, float, float]


def cases(count: int, seed: int) -> list[Case]:
    """Displacements of up to 8 radii, sectors from none to all headings."""
    rng, found = np.random.default_rng(seed), []
    for k in range(count):
        reach = rng.choice([0.3, 1.0, 2.0, 4.0, 8.0])
        width = rng.uniform(0, rng.choice([0.2, 1.0, 2 * math.pi]), 2)
        width = np.where([k % 5 == 0, k % 6 == 0], 0.0, np.where([k % 7 == 0, k % 8 == 0], 2 * math.pi, width))
        (dx, dy), (low0, low1) = rng.uniform(-reach, reach, 2), rng.uniform(-7, 7, 2)
        found.append((dx, dy, low0, width[0], low1, width[1]))
    return found


@njit(cache=True)
def sampled(dx: float, dy: float, low0: float, width0: float, low1: float, width1: float, pieces: int) -> float:
    """Return the least Dubins length of headings on a grid over both sectors, radius 1."""
    best = math.inf
    for a in range(pieces + 1):
        for b in range(pieces + 1):
            h0, h1 = low0 + width0 * a / pieces, low1 + width1 * b / pieces
            best = min(best, dubins_length(0.0, 0.0, h0, dx, dy, h1, 1.0))
    return best


def excess(count: int, seed: int, pieces: int) -> tuple[float, float]:
    """Return by how much interval lengths exceed sampled ones at most, and the median of what they are below."""
    below = np.array([sampled(*case, pieces) - interval_length(*case, 1.0) for case in cases(count, seed)])
    return float(-below.min()), float(np.median(below))


def test_no_choice_of_headings_is_shorter() -> None:
    above, below = excess(300, 1, 40)
    assert above < 1e-12
    assert below < 1e-3  # and it is no idle bound


@pytest.mark.slow
def test_no_choice_of_headings_is_shorter_in_ten_thousand_cases() -> None:
    assert excess(10_000, 2, 40)[0] < 1e-12


def test_sectors_without_width_have_dubins_lengths() -> None:
    for dx, dy, h0, _, h1, _ in cases(300, 3):
        assert interval_length(dx, dy, h0, 0.0, h1, 0.0, 1.0) == pytest.approx(
            dubins_length(0.0, 0.0, h0, dx, dy, h1, 1.0), abs=1e-9
        )


def test_a_small_width_changes_little_and_only_shortens() -> None:
    for dx, dy, h0, _, h1, _ in cases(100, 4):
        narrow = interval_length(dx, dy, h0, 1e-7, h1, 1e-7, 1.0)
        wide = interval_length(dx, dy, h0 - 0.1, 0.2, h1 - 0.1, 0.2, 1.0)
        assert wide <= narrow + 1e-9
        assert narrow <= dubins_length(0.0, 0.0, h0, dx, dy, h1, 1.0) + 1e-9


def test_closed_forms() -> None:
    everything = 2 * math.pi
    assert interval_length(3.0, 4.0, 0.0, everything, 1.0, everything, 1.0) == pytest.approx(5.0, abs=1e-12)
    assert interval_length(0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 1.0) == 0.0
    # straight up from a heading east: a quarter of a left turn about (0, 1) and on
    assert interval_length(1.0, 5.0, 0.0, 0.0, 0.0, everything, 1.0) == pytest.approx(math.pi / 2 + 4.0, abs=1e-12)
    # to the place beside, heading free: two turns, the second the longer way about (0.866…, −0.5…)
    assert interval_length(0.0, 1.0, 0.0, 0.0, 0.0, everything, 1.0) == pytest.approx(
        sampled(0.0, 1.0, 0.0, 0.0, 0.0, everything, 400), abs=1e-3
    )


def test_lengths_scale_with_the_radius_and_turn_with_the_plane() -> None:
    for dx, dy, low0, width0, low1, width1 in cases(100, 5):
        turned = math.cos(1.0) * dx - math.sin(1.0) * dy, math.sin(1.0) * dx + math.cos(1.0) * dy
        there = interval_length(dx, dy, low0, width0, low1, width1, 1.0)
        larger = interval_length(500 * turned[0], 500 * turned[1], low0 + 1, width0, low1 + 1, width1, 500.0)
        back = interval_length(-dx, -dy, low1 + math.pi, width1, low0 + math.pi, width0, 1.0)
        assert (larger / 500, back) == pytest.approx((there, there), abs=1e-8)


def test_a_table_holds_the_lengths_between_states() -> None:
    points, nodes = np.array([[0.0, 0.0], [300.0, 100.0]]), np.array([0, 0, 1])
    lows, widths = np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.5, 2 * math.pi])
    length = interval_lengths(points, nodes, lows, widths, 50.0)
    assert length[0, 1] == length[1, 0] == 0.0
    assert length[1, 2] == interval_length(300.0, 100.0, 1.0, 0.5, 2.0, 2 * math.pi, 50.0)
    assert length[2, 0] == interval_length(-300.0, -100.0, 2.0, 2 * math.pi, 0.0, 0.0, 50.0)
