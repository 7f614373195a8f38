"""`ruin-recreate` and `memetic` where costs change with time: what these solvers call for such instances.

Both begin with a plan that knows no clock, its tours flown in their better directions: `ruin-recreate` with greedy
tours, `memetic` with those of a static search for the costs of half time, which gets a share of the limit.
"""

from __future__ import annotations

from formulations.limits import Limits
from formulations.routing.clocked.annealing import anneal_by_clock
from formulations.routing.clocked.population import ClockedPopulation
from formulations.routing.clocked.problem import ClockedProblem, at_take_off, half_time
from formulations.routing.greedy import greedy_routes
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.annealing import AnnealingParameters
from formulations.routing.search.budget import Budget, BudgetParameters
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import NeighbourhoodParameters
from formulations.routing.search.randomness import seeded
from formulations.routing.search.schedule import Schedule, ScheduleParameters
from formulations.routing.search.strategy import SEVERAL_DEPOTS
from formulations.routing.search.tours import duplicate, to_routes
from formulations.routing.solver import Result
from instances import Instance, Routes
from instances.frozen import guiding, in_better_directions

STATIC = 0.1
"""Share of the limit that the static plan gets."""


def ruin_recreate_by_clock(recorder: Recorder, removals: int, seed: int) -> Result:
    """Anneal until a limit; one step is one iteration."""
    problem, rng = ClockedProblem(recorder.instance, NeighbourhoodParameters()), seeded(seed)
    tours = problem.tours(recorder.routes or _greedy(recorder.instance))
    how = AnnealingParameters(removals=removals, moves=0.0)
    best, fittest, search = duplicate(tours), duplicate(tours), problem.search(tours, removals)
    recorder.incumbent(to_routes(best))
    parameters, measure = ScheduleParameters(), SEVERAL_DEPOTS.measure
    schedule = Schedule(parameters.founder, parameters.softness[0], parameters.final)
    budget = Budget(recorder, BudgetParameters())
    while not budget.stopped_by:
        problem.follow(best, fittest)
        longest = float(best.cost.max())
        temperature, objective = schedule.at(budget.fraction, best, longest, parameters)
        steps = budget.next_steps()
        anneal_by_clock(search, best, fittest, rng, steps, temperature, objective, measure, how)
        budget.took(steps)
        if best.cost.max() < longest:
            recorder.incumbent(to_routes(best))
    return recorder.result(budget.stopped_by, iterations=budget.iterations)


def memetic_by_clock(recorder: Recorder, static: RecordedSolver, parameters: SearchParameters, seed: int) -> Result:
    """Search until a limit; `static` makes the plan that knows no clock."""
    instance = recorder.instance
    plan = _static_plan(recorder, static, seed)
    problem = ClockedProblem(instance, parameters.neighbourhood)
    start = problem.tours(recorder.routes or plan)
    recorder.incumbent(to_routes(start))
    budget = Budget(recorder, parameters.budget)
    began, planned = budget.fraction, False
    population = ClockedPopulation(problem, parameters, seeded(seed, 0), start, began)
    lowest = population.incumbent
    while not budget.stopped_by:
        now = budget.fraction
        if not planned and now >= began + parameters.budget.probe:
            planned = True
            population.plan(1.0 / budget.total_steps)
        if now >= population.end:
            population.next_stage(now)
        steps = budget.next_steps(parameters.budget.level)
        population.advance(now, steps)
        budget.took(steps)
        if population.incumbent < lowest or recorder.routes is None:
            lowest = population.incumbent
            recorder.incumbent(to_routes(population.best))
    recorder.incumbent(to_routes(population.best))
    return recorder.result(budget.stopped_by, iterations=budget.iterations, stages=population.family.stages)


def _static_plan(recorder: Recorder, static: RecordedSolver, seed: int) -> Routes:
    """Return the plan for the costs of half time, its tours in their better directions."""
    instance, limits = recorder.instance, recorder.limits
    steps = None if limits.iterations is None else max(1, int(STATIC * limits.iterations))
    share = Limits(time=max(STATIC * limits.time, 1e-3), iterations=steps)
    found = static.solve(guiding(instance, half_time(instance)), limits=share, seed=seed).routes
    return in_better_directions(instance, found) if found else _greedy(instance)


def _greedy(instance: Instance) -> Routes:
    """Return greedy tours of the costs of take-off, in their better directions."""
    return in_better_directions(instance, greedy_routes(at_take_off(instance)))
