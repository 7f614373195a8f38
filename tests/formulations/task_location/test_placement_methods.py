"""Every method: points inside, worth recomputed, same seed same answer; and what the good ones must reach."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from shapely.geometry import Polygon
from threadpoolctl import threadpool_info, threadpool_limits

from formulations.kernel import SquaredExponential
from formulations.limits import Limits
from formulations.task_location.boundary import distance_gradient, is_rectangle
from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.greedy import greedy_choice
from formulations.task_location.greedy_swap import Exchange
from formulations.task_location.placement import (
    PlacementMethod,
    PlacementProblem,
    PlacementStatus,
    checked_points,
    lattice,
    place,
)
from formulations.task_location.registry import METHODS, make_method
from formulations.task_location.starts import relocated
from instances.environment.region import Region
from instances.errors import InputError

KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
SQUARE = Region.rectangle(20_000, 20_000)
ANGLE_WITH_HOLE = Region(
    Polygon(
        [(0, 0), (20_000, 0), (20_000, 9000), (9000, 9000), (9000, 20_000), (0, 20_000)],
        [[(3000, 3000), (6000, 3000), (6000, 6000), (3000, 6000)]],
    )
)


def problem(region: Region, n: int, cells: int = 10, **rest: Convention) -> PlacementProblem:
    return PlacementProblem(region, Criterion(KERNEL, region.cell_centres(cells, cells), **rest), n)


@pytest.mark.parametrize("name", METHODS.targets())
def test_every_method_has_points_when_its_time_is_up_at_once(name):
    found = place(problem(SQUARE, 12, cells=6), make_method(name), name, limits=Limits(time=1e-9))
    assert found.points.shape == (12, 2)
    assert found.stopped_by == "time" or name in ("greedy", "grid", "random")


@pytest.mark.parametrize("region", [SQUARE, ANGLE_WITH_HOLE], ids=["square", "angle with hole"])
@pytest.mark.parametrize("name", METHODS.targets())
def test_every_method_keeps_the_contract(name, region):
    given = problem(region, 4, cells=6)
    first, again = (place(given, make_method(name), name, seed=5, certificate=14.0) for _ in range(2))
    assert first.points.shape == (4, 2)
    assert (region.signed_distance(first.points) >= -1e-6).all()
    assert first.mutual_information == pytest.approx(given.criterion.value(first.points), abs=1e-9)
    assert np.array_equal(first.points, again.points)
    assert [v for _, v in first.trace] == sorted(v for _, v in first.trace)
    assert first.trace[-1][1] == pytest.approx(first.mutual_information, abs=1e-9)
    assert 0 < first.ratio < 1
    assert first.method == name
    assert first.as_dict()["status"] in ("locally solved", "heuristic")


@pytest.mark.parametrize("name", METHODS.targets())
def test_one_task(name):
    placement = place(problem(SQUARE, 1, cells=4), make_method(name), name)
    assert 0 < placement.mutual_information <= 0.5 * math.log(901)


def test_greedy_is_the_naive_greedy():
    criterion = Criterion(KERNEL, SQUARE.cell_centres(6, 6))
    sites = lattice(SQUARE, 7)
    chosen: list[int] = []
    for _ in range(6):
        gains = [criterion.value(sites[[*chosen, j]]) if j not in chosen else -1 for j in range(len(sites))]
        chosen.append(int(np.argmax(gains)))
    found = greedy_choice(criterion, sites, 6)
    assert criterion.value(sites[found]) == pytest.approx(criterion.value(sites[chosen]), abs=1e-9)


def test_no_exchange_of_one_task_improves_greedy_swap():
    given = PlacementProblem(SQUARE, Criterion(KERNEL, SQUARE.cell_centres(6, 6)), 5, candidates_per_axis=7)
    placement = place(given, make_method("greedy-swap"), "greedy-swap")
    for i, site in itertools.product(range(5), given.candidates):
        other = placement.points.copy()
        other[i] = site
        if len(np.unique(other, axis=0)) == 5:
            assert given.criterion.value(other) <= placement.mutual_information + 1e-6


def test_exchange_finds_the_brute_forced_best():
    criterion = Criterion(KERNEL, SQUARE.cell_centres(6, 6))
    sites = lattice(SQUARE, 6)
    exchange = Exchange(criterion, sites, [0, 1, 2])
    exchange.improve(1)
    best = max((j for j in range(36) if j not in (0, 2)), key=lambda j: criterion.value(sites[[0, j, 2]]))
    assert exchange.chosen[1] == best


@pytest.mark.parametrize("region", [SQUARE, ANGLE_WITH_HOLE], ids=["square", "angle with hole"])
def test_nlp_is_at_least_as_good_as_its_start_and_as_nelder_mead(region):
    given = problem(region, 6)
    values = {
        name: place(given, make_method(name), name, seed=1).mutual_information
        for name in ("nlp", "greedy-swap", "nelder-mead", "grid", "random", "l-bfgs-b", "slsqp")
    }
    assert values["nlp"] >= max(values.values()) * 0.999
    assert values["nlp"] > values["grid"] > 0
    assert values["nlp"] >= max(values["nelder-mead"], values["random"])


def test_nlp_leaves_a_poor_first_end_by_hops(monkeypatch):
    poor = SQUARE.sample(40, np.random.default_rng(2))
    monkeypatch.setattr("formulations.task_location.nlp.greedy_start", lambda *_: poor)
    given = problem(SQUARE, 40, cells=20)
    alone = place(given, make_method("nlp", {"starts": 1}), "nlp").mutual_information
    assert alone < 105.0 < place(given, make_method("nlp"), "nlp").mutual_information


PAPER = {10: 33.0618, 20: 63.0262, 40: 105.0301}
"""Tasks in the paper's square → the most mutual information known [nats]."""


@pytest.mark.parametrize("seed", [5, pytest.param(9, marks=pytest.mark.slow)])
@pytest.mark.parametrize("n", [10, pytest.param(20, marks=pytest.mark.slow), pytest.param(40, marks=pytest.mark.slow)])
def test_nlp_finds_the_best_known_placement_of_the_papers_square(n, seed):
    found = place(problem(SQUARE, n, cells=20), make_method("nlp"), "nlp", seed=seed)
    assert found.mutual_information == pytest.approx(PAPER[n], abs=1e-4)
    assert found.status is PlacementStatus.LOCALLY_SOLVED


@pytest.mark.parametrize("region", [SQUARE, ANGLE_WITH_HOLE], ids=["square", "angle with hole"])
def test_a_hop_puts_two_tasks_elsewhere_in_the_region(region):
    points, rng = region.sample(5, np.random.default_rng(0)), np.random.default_rng(1)
    hopped = relocated(region, points, rng)
    assert (hopped != points).any(axis=1).sum() == 2
    assert region.contains(hopped).all()
    assert (relocated(region, points[:1], rng) != points[:1]).any(axis=1).sum() == 1


def test_methods_run_with_one_blas_thread():
    def blas_threads():
        return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]

    class Looking(PlacementMethod):
        status = PlacementStatus.HEURISTIC

        def search(self, problem, progress, seed):
            threads.extend(blas_threads())
            progress.offer(problem.region.sample(problem.n_tasks, np.random.default_rng(0)), 0.0)
            return self.status

    threads: list[int] = []
    with threadpool_limits(2, user_api="blas"):  # the suite itself keeps to one
        assert 2 in (given := blas_threads())  # a library that was built without threads has one
        place(problem(SQUARE, 3), Looking(), "looking")
        assert blas_threads() == given
    assert threads
    assert set(threads) == {1}


def test_nlp_ends_where_the_gradient_vanishes():
    from formulations.task_location.derivatives import Expansion

    given = problem(SQUARE, 5)
    placement = place(given, make_method("nlp"), "nlp")
    assert placement.status is PlacementStatus.LOCALLY_SOLVED
    inside = SQUARE.signed_distance(placement.points) > 1.0
    slope = Expansion(given.criterion, placement.points).gradient * 4000
    assert np.abs(slope[inside]).max() < 1e-4


def test_both_nelder_mead_forms_take_the_same_path():
    given = problem(SQUARE, 2, cells=4)
    short, literal = (
        place(given, make_method("nelder-mead", {"form": form}), form, seed=3) for form in ("reduced", "literal")
    )
    assert short.points == pytest.approx(literal.points, abs=5.0)


def test_information_gain_puts_tasks_on_the_border_and_both_noisy_does_not():
    on_border = {}
    for c in (Convention.INFORMATION_GAIN, Convention.BOTH_NOISY):
        placement = place(problem(SQUARE, 12, cells=20, convention=c), make_method("nlp"), "nlp")
        on_border[c] = (SQUARE.signed_distance(placement.points) < 10).mean()
    assert on_border[Convention.INFORMATION_GAIN] >= 0.5
    assert on_border[Convention.BOTH_NOISY] == 0


def test_weights_draw_tasks_to_where_information_is():
    cells = SQUARE.cell_centres(10, 10)
    west = cells[:, 0] < 10_000
    criterion = Criterion(KERNEL, cells, np.where(west, 1.0, 0.01), test_noise_sd=30.0)
    placement = place(PlacementProblem(SQUARE, criterion, 8), make_method("nlp"), "nlp")
    assert (placement.points[:, 0] < 10_000).sum() >= 7


def test_a_time_limit_keeps_what_was_found():
    given = problem(SQUARE, 10, cells=20)
    placement = place(given, make_method("nelder-mead"), "nelder-mead", limits=Limits(time=0.05))
    assert (placement.stopped_by, placement.status) == ("time", PlacementStatus.HEURISTIC)
    assert placement.mutual_information > 0


def test_claims_outside_the_region_are_refused():
    given = problem(SQUARE, 1, cells=4)
    with pytest.raises(RuntimeError, match="outside"):
        checked_points(given, np.array([[-1.0, 0.0]]), "liar")
    with pytest.raises(RuntimeError, match="shape"):
        checked_points(given, np.zeros((2, 2)), "liar")

    class Silent(PlacementMethod):
        def search(self, problem, progress, seed):
            return PlacementStatus.HEURISTIC

    with pytest.raises(RuntimeError, match="no points"):
        place(given, Silent(), "silent")


def test_distance_gradient_leads_inwards():
    region = ANGLE_WITH_HOLE
    points = region.sample(20, np.random.default_rng(0)) + 300.0
    step = distance_gradient(region, points)
    # on a ridge, where two sides are equally near, a step inwards gains less
    gained = region.signed_distance(points + step) - region.signed_distance(points)
    assert np.median(gained) == pytest.approx(1.0, abs=1e-6)
    assert (gained > 0).all()
    assert is_rectangle(SQUARE)
    assert not is_rectangle(region)


@pytest.mark.parametrize("n", [1, 2, 7, 40, 41, 97])
@pytest.mark.parametrize("region", [SQUARE, ANGLE_WITH_HOLE, Region(Polygon([(0, 0), (9e3, 20), (9e3, 60), (0, 40)]))])
def test_the_regular_lattice_has_the_points_asked_for(region, n):
    from formulations.task_location.grid import regular_points

    points = regular_points(region, n, np.array([4000.0, 4000.0]))
    assert len(np.unique(points, axis=0)) == n
    assert region.contains(points).all()


@pytest.mark.parametrize("n", [0, -1, 2.5, True, 1682])
def test_numbers_of_tasks_that_do_not_fit_are_refused(n):
    with pytest.raises(InputError, match=r"at least 1|do not fit"):
        problem(SQUARE, n, cells=4)


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("npl", {}, "did you mean 'nlp'"),
        ("nlp", {"start": 3}, "did you mean 'starts'"),
        ("nlp", {"starts": "many"}, "whole number"),
        ("nlp", {"starts": -1}, "at least 0"),
        ("nelder-mead", {"form": "long"}, "reduced, literal"),
    ],
)
def test_unusable_methods_are_refused(name, options, words):
    with pytest.raises(InputError, match=words):
        make_method(name, options)


def test_every_registered_method_is_a_placement_method():
    assert all(PlacementMethod in METHODS.load(name).__mro__ for name in METHODS.targets())
    with pytest.raises(InputError, match="seed"):
        place(problem(SQUARE, 1, cells=4), make_method("random"), "random", seed=-1)


@pytest.mark.parametrize(
    "corners",
    [[(0, 0), (2, 2), (2, 0), (0, 2)], [(0, 0), (1, 1), (2, 2)]],
    ids=["self-intersection", "empty interior"],
)
def test_unusable_regions_are_refused(corners):
    with pytest.raises(InputError, match="region"):
        Region(Polygon(corners))
