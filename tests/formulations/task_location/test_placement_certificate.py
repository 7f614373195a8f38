"""The bounds: never under what was found, however it was found."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from formulations.kernel import SquaredExponential
from formulations.task_location.certificate import certificate, design_nodes, information_gain_bound, trivial_bound
from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.placement import PlacementProblem, lattice, place
from formulations.task_location.registry import make_method
from formulations.task_location.supremum import supremum
from instances.environment.region import Region
from instances.errors import InputError

SQUARE = Region.rectangle(20_000, 20_000)
KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
LONG = Criterion(SquaredExponential(30.0, (8000.0, 8000.0)), SQUARE.cell_centres(10, 10))
TRIANGLE = Region(Polygon([(0, 0), (20_000, 0), (5000, 15_000)], [[(6000, 3000), (9000, 3000), (7000, 6000)]]))


@pytest.mark.parametrize(("n", "brute"), [(4, 13.6032), pytest.param(6, 19.9965, marks=pytest.mark.slow)])
def test_bounds_hold_over_brute_force(n, brute):
    sites = lattice(SQUARE, 4)
    gain = LONG.under(Convention.INFORMATION_GAIN)
    choices = [list(s) for s in itertools.combinations(range(16), n)]
    best_gain = max(gain.value(sites[s]) for s in choices)
    assert best_gain == pytest.approx(brute, abs=1e-4)
    best_b = max(LONG.value(sites[s]) for s in choices)
    assert best_gain <= information_gain_bound(gain, SQUARE, n).bound <= trivial_bound(gain, n)
    assert best_b <= certificate(LONG, SQUARE, n).bound


@settings(deadline=None, max_examples=5)
@given(st.integers(1, 12), st.integers(0, 10**6), st.sampled_from([SQUARE, TRIANGLE]), st.floats(0.3, 3.0))
def test_no_design_passes_the_continuous_bound(n, seed, region, noise_sd):
    rng = np.random.default_rng(seed)
    kernel = SquaredExponential(30.0, (5000.0, 9000.0))
    criterion = Criterion(kernel, region.cell_centres(6, 6), noise_sd=noise_sd, convention=Convention.INFORMATION_GAIN)
    bound = information_gain_bound(criterion, region, n, updates=30).bound
    spread = max((region.sample(n, rng) for _ in range(20)), key=criterion.value)
    assert criterion.value(spread) <= bound
    clustered = np.repeat(region.sample(1, rng), n, axis=0)
    assert criterion.value(clustered) <= bound


@pytest.mark.parametrize(
    "region", [SQUARE, pytest.param(TRIANGLE, marks=pytest.mark.slow)], ids=["square", "triangle with hole"]
)
def test_the_continuous_bound_is_close_to_what_nlp_finds(region):
    criterion = Criterion(KERNEL, region.cell_centres(10, 10), convention=Convention.INFORMATION_GAIN)
    placement = place(PlacementProblem(region, criterion, 12), make_method("nlp"), "nlp")
    bound = certificate(criterion, region, 12).bound
    assert 0.985 * bound <= placement.information["ig"] <= bound


def test_few_noisy_tests_cap_the_bound():
    criterion = Criterion(KERNEL, SQUARE.cell_centres(2, 2))
    found = certificate(criterion, SQUARE, 30)
    assert found.kind == "what the test readings hold"
    assert criterion.value(SQUARE.sample(200, np.random.default_rng(0))) <= found.bound


def test_supremum_is_above_every_point_and_tight():
    nodes = design_nodes(TRIANGLE, np.array([4000.0, 4000.0]))[::5]
    rows = np.random.default_rng(0).normal(size=(3, len(nodes)))
    rows /= np.sqrt(np.einsum("ij,jk,ik->i", rows, KERNEL(nodes, nodes), rows)).max() * 3

    def expansion(points):
        covariance = KERNEL(nodes, points)
        along = rows @ covariance
        second = np.empty((len(points), 2))
        for d in (0, 1):
            gap = (points[None, :, d] - nodes[:, d, None]) / 4000
            slope, bend = rows @ (-gap * covariance), rows @ ((gap**2 - 1) * covariance)
            second[:, d] = 2 * (slope**2 + along * bend).sum(axis=0) / 4000**2
        return (along**2).sum(axis=0), second

    bound = supremum(expansion, TRIANGLE, np.array([4000.0, 4000.0]), 900.0)
    highest = expansion(lattice(TRIANGLE, 400))[0].max()
    assert highest <= bound <= 1.002 * highest


def test_bounds_refuse_what_does_not_fit():
    with pytest.raises(InputError, match="at least 1"):
        certificate(LONG, SQUARE, 0)
