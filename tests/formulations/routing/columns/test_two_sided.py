"""Tours from both sides: the same as from one, of any costs, prices and cuts; what is lost is said."""

import itertools

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns import tightening, two_sided
from formulations.routing.columns.label_search import Found, no_limit, pair, path, search
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.pool import Pool, list_tours
from formulations.routing.columns.pricing import DualBound, Duals, Effort, Pricer
from formulations.routing.columns.two_sided import Attempt, Sides
from formulations.routing.solver import Status
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, tour_costs
from tests.formulations.routing.test_branch_and_price import random_instance

N = 9
PLENTY = 10**6


def duals_of(seed: int, cuts: bool) -> Duals:
    """Prices of which some are negative, a tour's price, and dear cuts that overlap."""
    rng = np.random.default_rng(seed)
    sets = tuple(c for c in itertools.combinations(range(N), 3) if cuts and rng.random() < 0.9)
    price, sigma = rng.normal(60, 40, N), np.array([rng.choice([0.0, 0.4, 1.0])])
    return Duals(price, sigma, np.zeros(1), rng.uniform(0, 8, len(sets)), sets)


def priced(seed: int, cuts: bool) -> tuple[Instance, Duals, Pricer]:
    """One UAV, whose tours have up to six tasks or so."""
    instance = random_instance(N, 1, seed)
    cap, effort = float(instance.cost.mean() * 5), Effort(2, 30, PLENTY, 2, both=True)
    return instance, duals_of(seed, cuts), Pricer(Legs.of(instance).under(cap), cap, effort, make_store(N, 100_000))


def as_sets(found: Found) -> dict[tuple[int, ...], tuple[float, float]]:
    """Return reduced cost and cost of each set."""
    rows = zip(found.visited.tolist(), found.values.tolist(), found.costs.tolist(), strict=True)
    return {tuple(words): (value, cost) for words, value, cost in rows}


@pytest.mark.parametrize("cuts", [False, True], ids=["plain", "cuts"])
@pytest.mark.parametrize("seed", range(6))
def test_both_sides_find_what_one_finds(seed: int, cuts: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """More than sixty-four cuts: their bits take two words."""
    monkeypatch.setattr(two_sided, "_ALONE", PLENTY)
    instance, duals, pricer = priced(seed, cuts)
    assert not cuts or len(duals.cuts) > 64
    sides, store = pricer.sides(0, duals), pricer.store.of_uav(0)
    one = search(sides.problem, store, 0.0, no_limit, tours=PLENTY)
    [both] = sides.all_tours(store, [Attempt(0.0, PLENTY, PLENTY)], no_limit)
    assert both.complete
    assert both.pairs > 0
    expected = as_sets(one)
    assert as_sets(both) == {words: pytest.approx(values) for words, values in expected.items()}
    orders, ends = store.orders(both)
    for end, words, cost in zip(ends.tolist(), both.visited, both.costs.tolist(), strict=True):
        tour = path(orders, end)
        assert tour_costs(instance, [tour])[0] == pytest.approx(cost)
        assert sum(1 << i for i in tour) == int(words[0])


@pytest.mark.parametrize("beam", [1, 2, 5, 20])
@pytest.mark.parametrize("seed", range(6))
def test_what_a_beam_loses_is_not_below_what_it_says(seed: int, beam: int) -> None:
    _, duals, pricer = priced(seed, cuts=True)
    sides, store = pricer.sides(0, duals), pricer.store.of_uav(0)
    every = as_sets(search(sides.problem, store, 0.0, no_limit, tours=PLENTY))
    found = sides.search(store, 0.0, no_limit, beam=beam, tours=PLENTY)
    some = as_sets(found)
    assert found.complete == (found.floor == np.inf)
    for words, (value, _) in every.items():
        assert words in some or value >= found.floor - 1e-9
        assert words not in some or some[words][0] >= value - 1e-9
    least = min((value for value, _ in every.values()), default=0.0)
    narrow = pricer.at(Effort(2, 30, beam, 2, both=True), pricer.legs).price(0, duals, 0.0)
    assert narrow.least <= least + 1e-9


def test_a_list_that_does_not_fit_is_followed_by_the_first_that_does() -> None:
    """By labels, and by tours, of one side and of both: thresholds fall, and no tour is listed that is not below."""
    _, duals, pricer = priced(1, cuts=False)
    sides, store = pricer.sides(0, duals), pricer.store.of_uav(0)
    every = search(sides.problem, store, 0.0, no_limit, tours=PLENTY)
    low, high = (float(np.sort(every.values)[at : at + 2].mean()) for at in (2, 30))
    for searched, first in itertools.product((sides, Sides(sides.problem, None)), (40, PLENTY)):
        attempts = [Attempt(0.0, first, 20), Attempt(high, PLENTY, 20), Attempt(low, PLENTY, 20)]
        tried = searched.all_tours(store, attempts, no_limit)
        assert not any(found.complete for found in tried[:-1])
        assert tried[-1].complete
        assert tried[-1].values.size == 3
        assert tried[-1].values.max() < low
    assert len(sides.all_tours(store, [Attempt(low, PLENTY, PLENTY)], no_limit)) == 1


def test_no_tour_is_lost_in_silence_where_the_store_is_full() -> None:
    """Ways home have no room left for a first label."""
    _, duals, pricer = priced(1, cuts=False)
    sides = pricer.sides(0, duals)
    one = search(sides.problem, make_store(N, 100_000), 0.0, no_limit, tours=PLENTY)
    for room in range(N, one.labels, 7):
        [found] = sides.all_tours(make_store(N, room), [Attempt(0.0, 4 * (one.labels - 1), PLENTY)], no_limit)
        assert not found.complete or as_sets(found).keys() == as_sets(one).keys()
        assert found.complete or found.floor == -np.inf


def test_once_time_is_up_nothing_is_said_to_be_all() -> None:
    _, duals, pricer = priced(2, cuts=False)
    sides, store = pricer.sides(0, duals), pricer.store.of_uav(0)
    looks = iter(range(PLENTY))
    for most in range(0, 40, 5):
        [*_, found] = sides.all_tours(store, [Attempt(0.0, 400, PLENTY)], lambda most=most: next(looks) % 40 >= most)
        assert not found.complete
        assert (store.slots == -1).all()


@pytest.mark.parametrize(("ahead", "behind"), [(0, 0), (7, 2**31 - 2), (-1, 3), (2**31 - 2, -1)])
def test_a_pair_is_told_by_one_number(ahead: int, behind: int) -> None:
    class Parents:
        last, parent = {ahead: 5, behind: 6}, {ahead: -1, behind: -1}

    [end] = pair(np.array([ahead]), np.array([behind])).tolist()
    expected = ((5,) if ahead >= 0 else ()) + ((6,) if behind >= 0 else ())
    if ahead == behind:
        expected = (6, 6)
    assert path(Parents, end) == expected


@pytest.mark.parametrize("seed", range(4))
def test_lists_from_both_sides_price_as_those_from_one(seed: int) -> None:
    instance, duals, pricer = priced(seed, cuts=True)
    at = DualBound(0.0, duals, np.array([pricer.price(0, duals, 0.0).least]))
    none = Pool.empty(1, N)
    alone = pricer.at(Effort(2, 30, PLENTY, 2), pricer.legs)
    one, both = (list_tours(none, some, at, PLENTY, PLENTY, none).pool for some in (alone, pricer))
    assert one.complete
    assert both.complete
    assert dict(zip(map(tuple, one.visited.tolist()), one.cost, strict=True)) == pytest.approx(
        dict(zip(map(tuple, both.visited.tolist()), both.cost, strict=True))
    )
    for p in range(0, both.size, 50):
        column = both.column(p)
        assert tour_costs(instance, [column.tasks])[0] == pytest.approx(column.cost)
    few = both.nearest(at, 10)
    values = np.sort(duals.values([both.column(p) for p in range(both.size)]))
    assert np.sort(duals.values([few.column(p) for p in range(few.size)])) == pytest.approx(values[: few.size])
    assert few.size >= 10
    assert both.nearest(at, both.size) is both


@pytest.mark.parametrize("seed", [0, 3])
def test_proofs_do_not_change_where_all_is_done_from_both_sides_and_lists_are_long(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every list from both sides, and every pool looked through in two steps."""
    place = np.random.default_rng(seed).uniform(0, 1, (16, 2))
    instance = Instance("plane", np.hypot(*(place[:, None] - place).transpose(2, 0, 1)), 14, 2)
    optimum = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
    monkeypatch.setattr(two_sided, "_ALONE", PLENTY)
    monkeypatch.setattr(tightening, "_FEW", 2)
    loose = tuple(tuple(range(k, 14, 2)) for k in range(2))
    result = BranchAndPrice(starts=0).solve(instance, limits=Limits(time=60.0), start=loose)
    assert result.status is Status.OPTIMAL
    assert result.objective == pytest.approx(optimum)
    assert result.statistics["pools"]
