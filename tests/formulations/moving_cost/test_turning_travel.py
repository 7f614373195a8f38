"""Instances between headings: exact values of small ones, candidate headings, files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.turns.headings import HeadingStates, headings, sectors
from formulations.moving_cost.turns.spacing import advice, spacing_ratio
from formulations.moving_cost.turns.travel import Turns, relaxed, turning_instance, turns_of
from formulations.routing.subset_dp import SubsetDp
from instances import InputError, objective
from instances.arrays import Floats
from instances.files import read_instance
from instances.formats.native import document_text


def points(n_tasks: int, n_depots: int, seed: int = 0) -> Floats:
    rng = np.random.default_rng(1000 * n_tasks + 100 * n_depots + seed)
    return rng.uniform(0, 20000, (n_tasks + n_depots, 2))


def least(places: Floats, n_tasks: int, radius: float, states: HeadingStates, closed: bool = False) -> float:
    """Return the proved length [m] of the shortest longest tour."""
    instance = turning_instance("turns", places, n_tasks, Turns(radius, 1.0), states, closed=closed)
    result = SubsetDp().solve(instance, limits=Limits(time=600.0))
    assert result.status == "OPTIMAL"
    assert result.routes is not None
    assert result.objective == objective(instance, result.routes)
    return float(result.objective or 0.0)


def test_there_and_back_with_free_headings_at_the_depot() -> None:
    places, r = np.array([[4000.0, 0.0], [0.0, 0.0]]), 1000.0
    closed_form = 2 * (math.sqrt((4000 - r) ** 2 - r**2) + r * (math.pi - math.acos(r / (4000 - r))))
    assert least(places, 1, r, headings(places, 1, uniform=4)) == pytest.approx(closed_form, rel=1e-12)
    assert closed_form == pytest.approx(9478.120722, abs=1e-6)


def test_there_and_back_with_one_heading_at_the_depot() -> None:
    places, r = np.array([[4000.0, 0.0], [0.0, 0.0]]), 1000.0
    found = least(places, 1, r, headings(places, 1, uniform=8, free_depots=False), closed=True)
    assert found == pytest.approx(2 * (4000 - 2 * r) + 2 * math.pi * r, rel=1e-12)


@pytest.mark.parametrize(
    ("count", "discrete", "bound"),
    [
        (8, 33826.209686, 31638.317010),
        (16, 33684.663370, 32662.644618),
        (32, 33620.415712, 33168.303115),
        (64, 33604.945240, 33429.833545),
    ],
)
def test_four_tasks_two_uavs(count: int, discrete: float, bound: float) -> None:
    places = points(4, 2)
    assert least(places, 4, 2000.0, headings(places, 4, uniform=count, free_depots=False)) == pytest.approx(
        discrete, abs=1e-6
    )
    assert least(places, 4, 2000.0, sectors(4, 2, count)) == pytest.approx(bound, abs=1e-6)


@pytest.mark.parametrize(
    ("radius", "discrete", "bound"), [(500.0, 37198.582240, 37103.684890), (2000.0, 38668.884391, 38205.404786)]
)
def test_eight_tasks_two_uavs(radius: float, discrete: float, bound: float) -> None:
    places = points(8, 2)
    assert least(places, 8, radius, headings(places, 8, uniform=32, free_depots=False)) == pytest.approx(
        discrete, abs=1e-6
    )
    assert least(places, 8, radius, sectors(8, 2, 32)) == pytest.approx(bound, abs=1e-6)


def test_more_headings_cost_less_and_free_depots_least() -> None:
    places = points(4, 2)
    few, more = (headings(places, 4, uniform=8, sights=k, tangents=k, free_depots=False) for k in (0, 3))
    assert len(more.nodes) > len(few.nodes)
    assert least(places, 4, 2000.0, more) <= least(places, 4, 2000.0, few)
    assert least(places, 4, 2000.0, headings(places, 4, uniform=8)) <= least(places, 4, 2000.0, few)


def test_headings_lie_along_sights_and_chords() -> None:
    places = np.array([[0.0, 0.0], [1000.0, 0.0], [0.0, 3000.0], [-5000.0, -5000.0]])
    along = headings(places, 3, uniform=0, sights=1, tangents=2)
    chord = math.atan2(3000.0, -1000.0)
    assert along.of(0) == pytest.approx(sorted([0.0, math.pi, chord, chord + math.pi]))
    assert along.widths[along.nodes == 3] == pytest.approx([2 * math.pi])
    with pytest.raises(InputError, match="needs a heading"):
        headings(places, 3, uniform=0)


def test_more_headings_stand_beside_those_there_are_each_once() -> None:
    states = headings(points(2, 1), 2, uniform=4)
    more = states.also(np.array([1, 0, 1]), np.array([0.3, 2 * math.pi, -math.pi / 2]))
    assert more.nodes.tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 1, 2]
    assert more.of(1) == pytest.approx([0.0, math.pi / 2, math.pi, 3 * math.pi / 2, 0.3])
    assert more.widths[-1] == 2 * math.pi


def test_an_instance_knows_its_headings_and_its_relaxation_after_a_file(tmp_path: Path) -> None:
    places = points(4, 2)
    made = turning_instance("kept", places, 4, Turns(500.0, 20.0), headings(places, 4, uniform=8, sights=1))
    (tmp_path / "kept.json").write_text(document_text(made))
    read = read_instance(tmp_path / "kept.json")
    assert read.digest == made.digest
    known = turns_of(read)
    assert known is not None
    assert known[0] == Turns(500.0, 20.0)
    assert np.array_equal(known[1].lows, headings(places, 4, uniform=8, sights=1).lows)
    below, above = relaxed(read, 16), SubsetDp().solve(read, limits=Limits(time=60.0))
    assert below is not None
    bound = SubsetDp().solve(below, limits=Limits(time=60.0)).objective
    assert 0.97 * (above.objective or 0.0) < (bound or 0.0) <= (above.objective or 0.0)


def test_the_spacing_ratio_says_whether_turns_count() -> None:
    ratio = spacing_ratio(20_000.0**2, 40, 50.0)
    assert ratio == pytest.approx(63.2, abs=0.1)  # the paper's scenario
    assert "without them" in advice(ratio)
    assert "together" in advice(spacing_ratio(20_000.0**2, 40, 1000.0))
    with pytest.raises(InputError, match="turning radius must be positive"):
        spacing_ratio(1.0, 1, 0.0)
