"""Several threads: populations of one family."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.recorder import Recorder
from formulations.routing.registry import make_solver
from formulations.routing.search import tours as rings
from formulations.routing.search.budget import Budget, BudgetParameters, Window
from formulations.routing.search.costs import search_costs
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.lineage import Family
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.stages import next_stages, share_best
from formulations.routing.search.strategy import SEVERAL_DEPOTS
from formulations.routing.solver import ignore
from instances import Instance, check_routes, tour_costs

N, M = 30, 3
FOUNDERS = 5


def plane(seed, endurance=None):
    xy = np.random.default_rng(seed).uniform(0.0, 100.0, (N + M, 2))
    return Instance("plane", np.linalg.norm(xy[:, None] - xy[None], axis=2), N, M, endurance=endurance)


def family_of_two(instance, seed=1):
    parameters = SearchParameters(several_depots=replace(SEVERAL_DEPOTS, size=FOUNDERS, short=None))
    endurance = Endurance(instance, search_costs(instance))
    endurance.refer(endurance.most)
    data, family = problem_data(endurance.costs, N, parameters.neighbourhood), Family(threads=2)
    return [Population(data, endurance, parameters, seeded(seed, i), None, family) for i in range(2)]


def test_two_threads_make_as_many_founders_as_one_would_and_all_take_their_parents_from_the_same_members():
    populations = family_of_two(plane(2))
    family, now, founders = populations[0].family, 0.0, 2
    for population in populations:
        population.plan(1e-5)
    assert family.founders == FOUNDERS
    while family.since_restart < 2 * FOUNDERS:
        for population in populations:
            population.advance(now, 50)
        share_best(populations)
        now = min(population.end for population in populations)
        ended = [population for population in populations if now >= population.end]
        next_stages(populations, now)
        founders += sum(population._newcomer.length == family.founder for population in ended)
        assert populations[0].incumbent == populations[1].incumbent
        assert len(family.members) <= FOUNDERS
    assert founders == FOUNDERS
    assert family.stages == 2 * FOUNDERS


def test_a_founder_that_leaves_room_for_three_in_both_threads_is_one_of_a_population():
    for threads, planned in ((1, False), (2, True)):
        populations = family_of_two(plane(3))
        populations[0].family.threads = threads
        populations[0].plan(5e-5)
        assert (populations[0].end < 1.0) == planned


def test_once_routes_that_can_be_flown_are_found_tours_of_all_threads_are_priced_anew():
    instance = plane(4, endurance=np.array([150.0, 400.0, 1e4]))
    populations = family_of_two(instance)
    before = populations[1]._newcomer.tours.cost.copy()
    populations[0].best = rings.from_routes(populations[0].data.costs, ((), (), tuple(range(N))))
    share_best(populations)
    under_way = populations[1]._newcomer.tours
    assert (under_way.cost != before).any()
    scale = populations[0].data.costs.scale
    assert under_way.cost == pytest.approx(scale * tour_costs(instance, rings.to_routes(under_way)))
    assert populations[1].best.cost == pytest.approx(populations[0].best.cost)


@pytest.mark.parametrize("endurance", [None, np.array([150.0, 400.0, 1e4])])
def test_a_run_of_two_threads_is_repeatable(endurance):
    instance = plane(5, endurance)
    limits = Limits(time=3600, iterations=60_000, threads=2)
    first, again = (make_solver("memetic").solve(instance, limits=limits, seed=3) for _ in range(2))
    assert first.routes == again.routes
    assert [event.objective for event in first.trace] == [event.objective for event in again.trace]
    assert first.statistics == again.statistics
    assert first.statistics["stages"] > FOUNDERS
    assert check_routes(instance, first.routes) == []


def test_by_the_clock_no_population_is_planned_before_threads_have_shown_their_speed():
    how = BudgetParameters(probed=1000)
    by_clock = Budget(Recorder(plane(6), Limits(time=1e-9), ignore), how)
    by_clock.took(999)
    assert not by_clock.has_probed
    by_clock.took(1)
    assert by_clock.has_probed
    by_steps = Budget(Recorder(plane(6), Limits(time=3600.0, iterations=1000), ignore), how)
    assert not by_steps.has_probed
    by_steps.took(10)
    assert by_steps.has_probed


def test_threads_take_equal_steps_where_these_are_counted_and_equal_time_by_the_clock():
    by_steps = Budget(Recorder(plane(6), Limits(time=3600.0, iterations=900, threads=2), ignore), BudgetParameters())
    window = by_steps.next_window(4000, 250)
    assert (window.steps, window.level, window.over) == (900, 250, False)
    alone = Budget(Recorder(plane(6), Limits(time=3600.0), ignore), BudgetParameters())
    alone.took(10**6)
    began, window = time.perf_counter(), alone.next_window(4000, 250)
    assert (window.steps, window.level) == (4000, 250)
    assert began < window.until <= began + 0.1
    by_clock = Budget(Recorder(plane(6), Limits(time=3600.0, threads=2), ignore), BudgetParameters())
    by_clock.took(10**6)
    began = time.perf_counter()
    window = by_clock.next_window(4000, 250)
    assert began < window.until <= began + 0.1
    assert window.level == 250 < window.steps


def test_a_thread_stops_when_its_window_is_over_but_takes_a_level_of_steps():
    population = family_of_two(plane(7))[0]
    assert population.run(0.0, Window(25, 10, math.inf), 1e-6) == 25
    assert population.run(0.0, Window(10**9, 10, 0.0), 1e-12) == 10
    taken = population.run(0.0, Window(10**9, 10, time.perf_counter() + 0.05), 1e-12)
    assert 10 < taken < 10**9
    assert taken % 10 == 0
