"""Eras: many UAVs at one site begin anew where nothing shorter comes, and the best of all eras meet."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.search import tours as rings
from formulations.routing.search.costs import search_costs
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.eras import EraParameters, Eras
from formulations.routing.search.lineage import Family
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.packing import Packing
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.stages import next_stages, share_best
from formulations.routing.search.strategy import ONE_SITE
from instances import Instance, check_routes, makespan, tour_costs

HOW = EraParameters(stale=0.1, founders=2.0, factor=2.0, less=1e-3, meeting=0.8)
N, M = 24, Packing().uavs
STEP = 2e-6


def crowds(seed, endurance=None):
    """As many far crowds of three tasks as UAVs at a site: the farthest task leaves a UAV little time for others."""
    rng = np.random.default_rng(seed)
    angle, far = np.repeat(np.arange(M) * 2 * np.pi / M, 3), rng.uniform(45.0, 50.0, N)
    tasks = np.column_stack([far * np.cos(angle), far * np.sin(angle)]) + rng.uniform(-1.0, 1.0, (N, 2))
    xy = np.vstack([tasks, np.zeros((M, 2))])
    return Instance("crowds", np.linalg.norm(xy[:, None] - xy[None], axis=2), N, M, endurance=endurance)


def family(instance, eras=HOW, threads=1):
    """Populations of one family that pack, each with a founder under way."""
    parameters = SearchParameters(one_site=replace(ONE_SITE, packing=Packing(room=np.inf, eras=eras)))
    endurance = Endurance(instance, search_costs(instance))
    endurance.refer(endurance.most)
    data = problem_data(endurance.costs, N, parameters.neighbourhood)
    common = Family(threads)
    populations = [Population(data, endurance, parameters, seeded(7, i), None, common) for i in range(threads)]
    for population in populations:
        population.plan(STEP)
        population.improved = False
    common.eras.note(populations[0].incumbent, 0.0, eras)
    return populations


@pytest.mark.parametrize(("now", "over"), [(0.29, False), (0.31, True), (0.69, True), (0.71, False)])
def test_an_era_ends_after_a_share_of_the_limit_without_a_shorter_tour_while_another_has_time(now, over):
    eras = Eras(began=0.2, shortened=0.2)
    assert eras.is_over(now, 0.0, HOW) == over


@pytest.mark.parametrize(("now", "over"), [(0.59, False), (0.61, True)])
def test_what_took_long_to_find_is_given_as_long_again(now, over):
    eras = Eras()
    eras.note(10.0, 0.1, HOW)
    eras.note(9.0, 0.2, HOW)
    eras.note(9.0 * (1.0 - 0.5 * HOW.less), 0.4, HOW)
    assert eras.shortest == 9.0
    assert eras.is_over(now, 0.0, HOW) == over


@pytest.mark.parametrize(("now", "over"), [(0.39, False), (0.41, True), (0.59, True), (0.61, False)])
def test_an_era_has_time_for_some_founders(now, over):
    assert Eras(began=0.2, shortened=0.2).is_over(now, 0.1, HOW) == over


def test_a_new_era_knows_nothing_of_those_before():
    eras = Eras()
    eras.note(10.0, 0.1, HOW)
    eras.begin("champion", 0.4)
    assert eras.champions == ["champion"]
    assert not eras.is_over(0.49, 0.0, HOW)
    eras.note(30.0, 0.45, HOW)
    assert (eras.shortest, eras.shortened) == (30.0, 0.45)


@pytest.mark.parametrize("threads", [1, 2])
def test_the_stages_of_all_end_with_an_era_and_late_the_best_of_all_eras_is_a_member(threads):
    instance = crowds(3)
    populations = family(instance, threads=threads)
    common, now, shortest, begun, met = populations[0].family, 0.0, np.inf, 0, False
    while now < 1.0:
        for population in populations:
            population.advance(now, 20)
            population.improved = False
        share_best(populations)
        shortest = min(shortest, populations[0].incumbent)
        now, before = min(population.end for population in populations), len(common.eras.champions)
        next_stages(populations, now)
        if len(common.eras.champions) > before:
            begun += 1
            assert now + HOW.stale <= HOW.meeting
            assert common.members == []
            assert common.eras.champions[-1].cost.max() < populations[0].incumbent
            assert all(population._begin == now for population in populations)
            assert len({population.incumbent for population in populations}) == 1
        if now >= HOW.meeting and not met:
            met = True
            assert common.eras.champions == []
            assert all(population.incumbent <= shortest for population in populations)
            assert min(member.cost.max() for member in common.members) <= shortest
    assert met
    assert begun >= 2
    best = rings.to_routes(populations[0].best)
    assert not check_routes(instance, best)
    assert makespan(instance, best) <= shortest * (1 + 1e-12)


def test_no_era_ends_before_its_best_tours_are_told_of(monkeypatch):
    monkeypatch.setattr(Population, "grow_up", lambda population: None)
    population = family(crowds(4), EraParameters(stale=0.0, founders=0.0, factor=0.0))[0]
    for improved in (True, False):
        population.improved = improved
        champions = len(population.family.eras.champions)
        next_stages([population], population.end)
        assert (len(population.family.eras.champions) > champions) != improved


def test_no_era_ends_where_a_chained_search_will_take_over_or_nothing_is_packed():
    for changed in ("chains", "packing"):
        population = family(crowds(5), EraParameters(stale=0.0, founders=0.0, factor=0.0))[0]
        if changed == "chains":
            population.chains = True
        else:
            population.family.founder = 1.0
        next_stages([population], population.end)
        assert population.family.eras.champions == []


def test_champions_are_priced_anew_with_all_else_once_routes_that_can_be_flown_are_found():
    instance = crowds(6, np.full(M, 1e4) - 9e3 * (np.arange(M) == 0))
    population = family(instance)[0]
    champion = rings.duplicate(population.best)
    before = champion.cost.copy()
    population.family.eras.begin(champion, 0.1)
    population.best = rings.from_routes(population.data.costs, tuple(tuple(range(3 * k, 3 * k + 3)) for k in range(M)))
    share_best([population])
    scale = population.data.costs.scale
    assert (champion.cost != before).any()
    assert champion.cost == pytest.approx(scale * tour_costs(instance, rings.to_routes(champion)))


class Anew(Memetic):
    """`memetic` whose eras may be short."""

    parameters: ClassVar[SearchParameters] = SearchParameters(
        one_site=replace(ONE_SITE, packing=Packing(room=np.inf, longest=1.0, eras=HOW._replace(founders=0.0)))
    )


@pytest.mark.parametrize("threads", [1, 2])
def test_a_run_of_some_eras_is_repeatable_and_no_worse_than_the_best_of_them(threads, monkeypatch):
    begun, begin = [], Eras.begin
    monkeypatch.setattr(Eras, "begin", lambda eras, *given: (begun.append(given), begin(eras, *given)))
    instance = crowds(8)
    limits = Limits(time=3600, iterations=450_000 // threads, threads=threads)
    first, again = (Anew().solve(instance, limits=limits, seed=2) for _ in range(2))
    assert len(begun) >= 4
    assert first.routes == again.routes
    assert first.statistics == again.statistics
    assert first.objective == min(event.objective for event in first.trace) == makespan(instance, first.routes)
