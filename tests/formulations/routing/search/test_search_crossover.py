"""Crossover, and what a population does."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.search import crossover as mixing
from formulations.routing.search import tours as rings
from formulations.routing.search.annealing import AnnealingParameters
from formulations.routing.search.costs import both_ways
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.energy import fitness
from formulations.routing.search.lineage import Successes
from formulations.routing.search.parameters import PopulationParameters, SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.recreate import RecreateParameters
from formulations.routing.search.stages import next_stages
from formulations.routing.search.strategy import ONE_SITE, SEVERAL_DEPOTS
from instances import Instance, check_routes, tour_costs

N = 15


def plane(seed, positions):
    """Tasks and depots in a plane with a wind, so that depots at one position have equal costs."""
    rng = np.random.default_rng(seed)
    xy = np.vstack([rng.uniform(0, 100, (N, 2)), np.array(positions, float)])
    leg = xy[None] - xy[:, None]
    cost = np.hypot(leg[..., 0], leg[..., 1]) * 1.2 - 0.3 * leg[..., 0]
    np.fill_diagonal(cost, 0.0)
    instance = Instance("plane", np.maximum(cost, 0.0), N, len(positions))
    return instance, problem_data(both_ways(instance.cost), N, NeighbourhoodParameters())


def random_routes(seed, m):
    rng = np.random.default_rng(seed)
    routes = [[] for _ in range(m)]
    for v in rng.permutation(N):
        routes[rng.integers(m)].append(int(v))
    return tuple(map(tuple, routes))


SPREAD = [(0, 0), (100, 0), (50, 100)]
SHARED = [(0, 0), (50, 50), (0, 0), (0, 0)]


def test_depots_with_the_same_costs_are_one_site():
    assert plane(1, SHARED)[1].site.tolist() == [0, 1, 0, 0]
    assert plane(1, SPREAD)[1].site.tolist() == [0, 1, 2]


def test_a_tour_matches_the_one_of_its_site_that_shares_most_tasks():
    _, field = plane(2, SHARED)
    child = rings.from_routes(field.costs, ((0, 1), (2, 3, 4, 5), (6, 7, 8), tuple(range(9, N))))
    donor = rings.from_routes(field.costs, ((6, 7, 2, 3, 4, 5), (0, 1), (8,), tuple(range(9, N))))
    assert mixing.matching_tour(child, donor, 0, field.site) == 2
    assert mixing.matching_tour(child, donor, 1, field.site) == 1


@given(st.integers(0, 10**6))
@settings(deadline=None, max_examples=30)
def test_inheriting_a_tour_copies_it_and_names_the_removed(seed):
    instance, field = plane(seed, SPREAD)
    first, second = random_routes(seed, 3), random_routes(seed + 1, 3)
    child, donor = rings.from_routes(field.costs, first), rings.from_routes(field.costs, second)
    removed = np.empty(N, np.int32)
    count = mixing.inherit(field.costs, child, donor, 1, 1, removed, 0)
    found = rings.to_routes(child)
    assert found[1] == second[1]
    for k in (0, 2):
        assert found[k] == tuple(v for v in first[k] if v not in second[1])
    assert sorted(removed[:count]) == sorted(set(first[1]) - set(second[1]))
    rings.sum_costs(child)
    assert child.cost == pytest.approx(tour_costs(instance, found))


MANY = [(8 * k, 100 * (k % 2)) for k in range(12)]


@pytest.mark.parametrize("positions", [SPREAD, SHARED, [(0, 0)], MANY])
@given(seed=st.integers(0, 10**6))
@settings(deadline=None, max_examples=30)
def test_a_child_visits_every_task_once_and_books_its_costs(positions, seed):
    instance, field = plane(seed, positions)
    m = len(positions)
    child = rings.from_routes(field.costs, random_routes(seed, m))
    donor = rings.from_routes(field.costs, random_routes(seed + 1, m))
    mixing.crossover(field, child, donor, 0.5, RecreateParameters(), seeded(seed))
    routes = rings.to_routes(child)
    assert check_routes(instance, routes) == []
    assert child.cost == pytest.approx(tour_costs(instance, routes))


def test_many_tours_are_inherited_from_one_region():
    """Crowds of five tasks on a circle, each flown round by one UAV one way, in the other parent the other way."""
    m, angle = 12, np.repeat(np.arange(12), 6) * np.pi / 6 + np.tile(np.linspace(0, 0.3, 6), 12)
    xy = np.column_stack([np.cos(angle), np.sin(angle)]).reshape(m, 6, 2)
    xy = np.vstack([xy[:, :5].reshape(-1, 2), xy[:, 5]])
    cost = np.hypot(*(xy[:, None] - xy).transpose(2, 0, 1))
    field = problem_data(both_ways(cost), 60, NeighbourhoodParameters())
    ahead = tuple(tuple(range(5 * k, 5 * k + 5)) for k in range(m))
    back = tuple(tour[::-1] for tour in ahead)
    lengths = set()
    for seed in range(30):
        child, donor = (rings.from_routes(field.costs, routes) for routes in (ahead, back))
        mixing.crossover(field, child, donor, 1.0, RecreateParameters(), seeded(seed))
        given = [k for k, tour in enumerate(rings.to_routes(child)) if tour == back[k]]
        gaps = [(b - a) % m for a, b in zip(given, given[1:] + given[:1], strict=True)]
        assert sorted(gaps)[:-1] == [1] * (len(given) - 1), given
        lengths.add(len(given))
    assert len(lengths) > 3


STEP = 1e-5
"""Of the limit: a founder takes a tenth of it, at the least depth."""


def new_population(seed, positions, decompositions=0.0, perturbations=0.0):
    """Return an instance and a population on it, of crossovers unless shares say otherwise."""
    instance, data = plane(seed, positions)
    stages = PopulationParameters(decompositions=decompositions, perturbations=perturbations, depth=1.0)
    parameters = SearchParameters(annealing=AnnealingParameters(removals=6, guides=4), population=stages)
    parameters = replace(parameters, several_depots=replace(SEVERAL_DEPOTS, size=8, focused=True))
    return instance, Population(data, Endurance(instance, data.costs), parameters, seeded(seed), None)


def test_a_population_fills_with_founders_then_keeps_only_better_strangers():
    instance, population = new_population(5, SPREAD)
    population.plan(STEP)
    ends = []
    now = 0.0
    for _ in range(30):
        population.advance(now, 1)
        now = population.end
        ends.append(now)
        if now >= 1.0:
            break
        next_stages([population], now)
        values = [fitness(member.cost, population.measure) for member in population.family.members]
        assert len(values) <= population.family.founders
        assert len(set(values)) == len(values)
    assert now == pytest.approx(1.0)
    assert ends[:5] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert ends[5] == pytest.approx(0.55)
    assert population.best.cost.max() <= min(member.cost.max() for member in population.family.members) * (1 + 1e-12)
    assert check_routes(instance, rings.to_routes(population.best)) == []


@pytest.mark.parametrize("shares", [(1.0, 0.0), (0.5, 0.5)])
def test_a_population_that_decomposes_keeps_whole_routes_and_never_loses_its_best(shares):
    instance, population = new_population(7, [*SPREAD, (100, 100), (0, 50)], *shares)
    population.plan(STEP / 10)
    now, best = 0.0, np.inf
    while now < 1.0:
        population.advance(now, 20)
        now = population.end
        next_stages([population], now)
        for member in (*population.family.members, population.best):
            routes = rings.to_routes(member)
            assert check_routes(instance, routes) == []
            assert member.cost == pytest.approx(tour_costs(instance, routes))
        assert population.best.cost.max() <= best
        best = population.best.cost.max()
    assert population.family.stages > 5 * population.family.founders


def test_a_population_that_may_run_once_only_does_not_split_its_time():
    _, population = new_population(6, SPREAD)
    population.plan(6e-5)
    assert population.end == 1.0


def test_where_all_start_at_one_site_fitness_is_measured_by_the_incumbent_and_recreations_look_at_all_near_tasks():
    together, apart = (new_population(6, positions)[1] for positions in ([(0, 0)] * 3, SPREAD))
    assert (together.strategy, apart.strategy.measure) == (replace(ONE_SITE, packing=None), SEVERAL_DEPOTS.measure)
    assert together.measure.cap == together.best.cost.max()
    assert apart.measure == SEVERAL_DEPOTS.measure
    assert together.annealing.recreate.width == NeighbourhoodParameters().tasks > apart.annealing.recreate.width


@pytest.mark.parametrize(("positions", "reheats"), [([(0, 0)] * 3, True), (SPREAD, False)])
def test_where_all_start_at_one_site_good_members_are_reheated_once_nothing_new_comes(positions, reheats):
    _, population = new_population(8, positions)
    population.plan(STEP / 100)
    now, reheated = 0.0, 0
    while now < 1.0:
        population.advance(now, 20)
        now = population.end
        next_stages([population], now)
        if population._newcomer.first == ONE_SITE.reheating.first:
            reheated += 1
            routes = rings.to_routes(population._newcomer.tours)
            assert routes in [rings.to_routes(member) for member in population.family.members]
    assert (reheated > 0) == reheats


@pytest.mark.parametrize(
    ("positions", "most", "quenches"), [([(0, 0)] * 3, 1.0, True), ([(0, 0)] * 3, 0.0, False), (SPREAD, 1.0, False)]
)
def test_where_all_start_at_one_site_some_are_quenched_from_scratch_once_nothing_new_comes(positions, most, quenches):
    _, population = new_population(8, positions)
    population.plan(STEP / 100)
    if population.strategy.quench is not None:
        population.strategy = replace(population.strategy, quench=replace(population.strategy.quench, founder=most))
    now, quenched = 0.0, 0
    while now < 1.0:
        population.advance(now, 20)
        now = population.end
        next_stages([population], now)
        newcomer, schedule = population._newcomer, population._schedule
        if newcomer.length == pytest.approx(ONE_SITE.quench.length * population.family.founder):
            quenched += 1
            assert population._staleness > 0.0
            assert newcomer.first == schedule.first == ONE_SITE.fine_first
            assert schedule.final == ONE_SITE.fine
            assert newcomer.tours.size.sum() == N
    assert (quenched > 0) == quenches


def test_what_brings_nothing_new_is_drawn_seldom_but_never_not_at_all():
    children, perturbed = Successes(), Successes()
    assert perturbed.share(children, 0.3) == pytest.approx(0.3)
    for i in range(400):
        perturbed.note(False, 0.03)
        children.note(i % 2 == 0, 0.03)
    assert children.rate == pytest.approx(0.5, abs=0.02)
    assert 0.005 < perturbed.share(children, 0.5) < 0.03
    assert perturbed.share(children, 0.5) + children.share(perturbed, 0.5) == pytest.approx(1.0)
    assert perturbed.share(children, 0.0) == 0.0
    assert perturbed.share(children, 1.0) == 1.0


@pytest.mark.parametrize("shares", [(0.0, 0.0), (0.0, 1.0)])
def test_only_what_was_tried_changes_its_rate(shares):
    _, population = new_population(5, SPREAD, *shares)
    population.plan(STEP)
    now = 0.0
    while now < 1.0:
        population.advance(now, 1)
        now = population.end
        next_stages([population], now)
    family = population.family
    tried, left = (family.perturbed, family.children) if shares[1] else (family.children, family.perturbed)
    assert tried.rate != 0.5
    assert left.rate == 0.5
