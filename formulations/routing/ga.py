"""ga: the paper's genetic algorithm.

Source: B. Ombuki-Berman and F. T. Hanshar, "Using Genetic Algorithms for Multi-depot Vehicle Routing", in
Bio-inspired Algorithms for the Vehicle Routing Problem, Springer 2009, which ``ipp_wind.tex`` follows. A generation:

    parents     tournaments of 2: the fitter with probability 0.8, else either of them
    crossover   best-cost route crossover of each pair with probability 0.60
    mutation    every 10th generation inter-depot with probability 0.25, in the others intra-depot with 0.20
    elitism     the best 1 % replace random children

Initial grouping: every task to its nearest depot, in random order. A task is border-line, and may change depots in
the inter-depot mutation, where (d_k − d_nearest) / d_nearest ≤ 2 for another depot k, which is then a candidate.
The operators are in ``ga_operators.py``.

What differs, because the problem does: fitness is C_max (the paper's eq. c_max), each depot has one UAV and no
capacity, so a group is one route and the paper's scheduler, which cuts groups into routes, has nothing to do; and the
"distance" of a task from a depot is the way there and back, c_ki + c_ik. Tasks as near to several depots (UAVs at one
place) are dealt among them at random. The crossover puts tasks back at their best places over all depots, not among the
routes of the depot it drew, as implementations that follow the original do (its text was not at hand): with one route
a depot, that would join both parents' tasks of the depot in one tour, when the longest tour is what counts.
In a fleet every group has the costs of its own UAV. Endurance is kept by scaled costs (search/endurance.py), so that
fitness is C_max once routes are found that can be flown; it may find none. Where costs change with time fitness is what
the clock says, and the operators compare places by the costs of half time; take-offs within a window are those of
``clocked/waiting.py``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.clocked.waiting import Waits
from formulations.routing.ga_operators import (
    Population,
    best_cost_route_crossover,
    chromosome,
    copy,
    evaluate,
    inter_depot_mutation,
    intra_depot_mutation,
)
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.costs import Costs, FleetCosts, search_costs, warm_up, warm_up_by_clock
from formulations.routing.search.endurance import Endurance
from formulations.routing.solver import Result
from instances import InputError, Instance, Routes, as_routes
from instances.arrays import Bools, Floats, Ints
from instances.frozen import guiding
from instances.kernels import njit

Clock = Callable[[Population, Costs], None]
"""Sets totals and fitness to what tours take by the clock."""

_LOOKS = 5_000_000
"""Insertion places that the crossovers between two looks at the clock try: about 20 ms."""


@dataclass(frozen=True)
class GeneticAlgorithm(RecordedSolver):
    """Ombuki-Berman and Hanshar's genetic algorithm; ``limits.iterations`` counts generations.

    population : chromosomes (at least 2).
    generations : it ends after so many even where there is time left (at least 0).
    tournament : size of the tournaments (at least 1).
    tournament_rate : probability that the fittest of a tournament wins; else any of it does (0 to 1).
    elite : share of the population that survives as it is (0 to 1).
    crossover_rate : probability that a pair is crossed (0 to 1).
    intra_rate : probability of the intra-depot mutation (0 to 1).
    inter_rate : probability of the inter-depot mutation, in the generations that have it (0 to 1).
    inter_every : every how many generations the inter-depot mutation takes the place of the intra-depot one (at
        least 1).
    border : how much farther, as a share, than the nearest depot a candidate depot may be (at least 0).
    """

    proves: ClassVar[bool] = False
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance", "time", "window"})

    population: int = 400
    generations: int = 3000
    tournament: int = 2
    tournament_rate: float = 0.8
    elite: float = 0.01
    crossover_rate: float = 0.60
    intra_rate: float = 0.20
    inter_rate: float = 0.25
    inter_every: int = 10
    border: float = 2.0

    def __post_init__(self) -> None:
        least_of = {"population": 2, "generations": 0, "tournament": 1, "inter_every": 1, "border": 0}
        for name, least in least_of.items():
            if getattr(self, name) < least:
                raise InputError(f"ga: {name} must be at least {least}, got {getattr(self, name)}")
        for name in ("tournament_rate", "elite", "crossover_rate", "intra_rate", "inter_rate"):
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"ga: {name} must lie in [0, 1], got {getattr(self, name)}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels."""
        tiny = (warm_up_by_clock if "time" in instance.axes else warm_up)(instance, 2, 2)
        GeneticAlgorithm(population=4, inter_every=1).solve(tiny, limits=Limits(iterations=1))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Evolve until the generations or the limits end it; the start joins the first population."""
        limits, rng = recorder.limits, np.random.default_rng(seed)
        instance, clock, waits = _clocked(recorder.instance)
        endurance = Endurance(instance, search_costs(instance))
        endurance.refer(min(endurance.most, recorder.objective))
        people = self._first_population(recorder, instance, endurance.costs, rng)
        clock(people, endurance.costs)
        recorder.incumbent(_fittest(people))
        costs, candidates = endurance.costs, border_line(instance, self.border)
        last = self.generations if limits.iterations is None else min(self.generations, limits.iterations)
        generation = 0
        while generation < last and recorder.remaining > 0:
            fittest = np.argmin(people.fitness)
            if endurance.follow(people.totals[fittest]) or waits.follow(float(people.fitness[fittest])):
                evaluate_all(costs, people)
                clock(people, costs)
            inter = (generation + 1) % self.inter_every == 0
            children, complete = self._next_generation(recorder, costs, rng, people, candidates, inter, clock)
            if children.fitness.min() < recorder.objective:
                recorder.incumbent(_fittest(children))
            people, generation = children, generation + complete
        stopped_by = "time" if generation < last else "finished" if generation == self.generations else "iterations"
        return recorder.result(stopped_by, generations=generation)

    def _first_population(
        self, recorder: Recorder, instance: Instance, costs: Costs, rng: np.random.Generator
    ) -> Population:
        """Return random chromosomes, the recorder's routes among them; fewer where time is up, but one."""
        start = recorder.routes
        people = unborn(self.population, instance.n_tasks, instance.n_depots)
        nearest = nearest_depots(instance)
        for row in range(self.population):
            people.perms[row], people.sizes[row] = random_chromosome(nearest, rng)
            if row == 0 and start is not None:
                people.perms[row] = [task for route in start for task in route]
                people.sizes[row] = [len(route) for route in start]
            people.fitness[row] = evaluate(costs, chromosome(people, row))
            if recorder.remaining <= 0:
                break
        return people

    def _next_generation(
        self,
        recorder: Recorder,
        costs: Costs,
        rng: np.random.Generator,
        people: Population,
        candidates: Bools,
        inter: bool,
        clock: Clock,
    ) -> tuple[Population, bool]:
        """Return the next generation, and whether it is complete: where time is up some are not born."""
        children = unborn(self.population, people.perms.shape[1], people.sizes.shape[1])
        mutation_rate = self.inter_rate if inter else self.intra_rate
        rates = float(self.tournament_rate), float(self.crossover_rate), float(mutation_rate)
        stride = 2 * max(1, _LOOKS // people.perms.shape[1] ** 2)
        for first in range(0, self.population, stride):
            if recorder.remaining <= 0:
                clock(children, costs)
                return children, False
            rows = first, min(first + stride, self.population)
            breed(costs, rng, people, children, rows, candidates, self.tournament, inter, rates)
        clock(children, costs)
        keep_elite(rng, people, children, round(self.elite * self.population))
        return children, True


def _clocked(instance: Instance) -> tuple[Instance, Clock, Waits]:
    """Return whose costs guide the operators, what makes totals and fitness those of the clock, and who may wait.

    Where costs change with time the first are those of half time, else the second has nothing to do.
    """
    if "time" not in instance.axes:
        return instance, lambda people, costs: None, Waits(instance, 0.0)
    from formulations.routing.clocked.problem import half_time, search_clocks  # here: others need no such kernels
    from formulations.routing.ga_clock import evaluate_by_clock

    half, clocks = half_time(instance), search_clocks(instance)
    waits = Waits(instance, 2 * half)

    def clock(people: Population, costs: Costs) -> None:
        scale = costs.scale if isinstance(costs, FleetCosts) else np.ones(instance.n_depots)
        evaluate_by_clock(clocks, scale, waits.table, people)

    return guiding(instance, half), clock, waits


def unborn(count: int, n_tasks: int, n_depots: int) -> Population:
    """Return room for so many chromosomes, unfit as yet."""
    perms, sizes = np.zeros((count, n_tasks), dtype=np.int64), np.zeros((count, n_depots), dtype=np.int64)
    return Population(perms, sizes, np.zeros(sizes.shape), np.full(count, np.inf))


def _fittest(people: Population) -> Routes:
    """Return the routes of the shortest C_max."""
    row = np.argmin(people.fitness)
    return as_routes(np.split(people.perms[row], np.cumsum(people.sizes[row])[:-1]))


def depot_distance(instance: Instance) -> Floats:
    """Return c_ki + c_ik [s] of each task and depot, at its UAV's own costs, shape (n, m)."""
    n, costs, classes = instance.n_tasks, instance.class_costs, instance.classes
    uavs = np.arange(n, instance.n_nodes)
    return costs[classes, uavs, :n].T + costs[classes, :n, uavs].T


def nearest_depots(instance: Instance) -> Bools:
    """Return which depots are the nearest of each task, shape (n, m); several where they are equally near."""
    distance = depot_distance(instance)
    return distance == distance.min(axis=1, keepdims=True)


def random_chromosome(nearest: Bools, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Return perm and sizes of the tasks grouped by nearest depot, each group in random order."""
    depot = np.where(nearest, rng.random(nearest.shape), -1.0).argmax(axis=1)  # ties at random
    order = rng.permutation(len(nearest))
    return order[np.argsort(depot[order], kind="stable")], np.bincount(depot, minlength=nearest.shape[1])


def border_line(instance: Instance, border: float) -> Bools:
    """Return which depots are candidates of each task, shape (n, m): no farther than (1 + border) × the nearest."""
    distance = depot_distance(instance)
    return distance <= (1.0 + border) * distance.min(axis=1, keepdims=True)


@njit(cache=True)
def evaluate_all(costs: Costs, people: Population) -> None:
    """Recompute the tour costs and fitness of all chromosomes."""
    for row in range(len(people.fitness)):
        people.fitness[row] = evaluate(costs, chromosome(people, row))


@njit(cache=True)
def winner(rng: Any, fitness: Floats, size: int, rate: float) -> int:
    """Return the row that wins a tournament."""
    entrants = rng.integers(0, len(fitness), size)
    if rng.random() >= rate:
        return entrants[rng.integers(0, size)]
    best = entrants[0]
    for row in entrants:
        if fitness[row] < fitness[best]:
            best = row
    return best


@njit(cache=True)
def breed(
    costs: Costs,
    rng: Any,
    people: Population,
    children: Population,
    rows: tuple[int, int],
    candidates: Bools,
    tournament: int,
    inter: bool,
    rates: tuple[float, float, float],
) -> None:
    """Make the children of rows[0] to rows[1] − 1, pair by pair; rates are those of tournament, crossover, mutation."""
    tournament_rate, crossover_rate, mutation_rate = rates
    perms, sizes, totals, _ = people
    pair = Population(np.empty_like(perms[:2]), np.empty_like(sizes[:2]), np.empty_like(totals[:2]), np.empty(2))
    for row in range(rows[0], rows[1], 2):
        for p in range(2):
            copy(people, winner(rng, people.fitness, tournament, tournament_rate), pair, p)
        if rng.random() < crossover_rate:
            best_cost_route_crossover(costs, rng, pair)
        for p in range(min(2, rows[1] - row)):
            if rng.random() < mutation_rate:
                if inter:
                    inter_depot_mutation(costs, rng, chromosome(pair, p), candidates)
                else:
                    intra_depot_mutation(costs, rng, chromosome(pair, p))
            pair.fitness[p] = evaluate(costs, chromosome(pair, p))
            copy(pair, p, children, row + p)


@njit(cache=True)
def keep_elite(rng: Any, people: Population, children: Population, elite: int) -> None:
    """Put the fittest `elite` of the people in the place of random children."""
    survivors, places = np.argsort(people.fitness)[:elite], rng.permutation(len(people.fitness))[:elite]
    for old, new in zip(survivors, places):  # noqa: B905 - numba knows no strict
        copy(people, old, children, new)
