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
place) are dealt among them at random.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.ga_operators import (
    best_cost_route_crossover,
    evaluate,
    inter_depot_mutation,
    intra_depot_mutation,
)
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.solver import Result
from instances import InputError, Instance, Routes, as_routes
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


@dataclass(frozen=True)
class GeneticAlgorithm(RecordedSolver):
    """Ombuki-Berman and Hanshar's genetic algorithm; ``limits.iterations`` counts generations.

    Options
    -------
    population : chromosomes.
    generations : it ends after so many even where there is time left.
    tournament : size of the tournaments.
    tournament_rate : probability that the fittest of a tournament wins; else any of it does.
    elite : fraction of the population that survives as it is.
    crossover_rate : probability that a pair is crossed.
    intra_rate : probability of the intra-depot mutation.
    inter_rate : probability of the inter-depot mutation, in the generations that have it.
    inter_every : every how many generations the inter-depot mutation takes the place of the intra-depot one.
    border : how much farther, as a fraction, than the nearest depot a candidate depot may be.
    """

    proves: ClassVar[bool] = False

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
        for name, least in (
            ("population", 2),
            ("generations", 0),
            ("tournament", 1),
            ("inter_every", 1),
            ("border", 0),
        ):
            if getattr(self, name) < least:
                raise InputError(f"ga: {name} must be at least {least}, got {getattr(self, name)}")
        for name in ("tournament_rate", "elite", "crossover_rate", "intra_rate", "inter_rate"):
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"ga: {name} must lie in [0, 1], got {getattr(self, name)}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels."""
        tiny = Instance("warm-up", np.zeros((4, 4)), 2, 2)
        GeneticAlgorithm(population=4, inter_every=1).solve(tiny, limits=Limits(iterations=1))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Evolve until the generations or the limits end it; the start joins the first population."""
        instance, limits, rng = recorder.instance, recorder.limits, np.random.default_rng(seed)
        people = self._first_population(instance, rng, recorder.routes)
        candidates = border_line(instance, self.border)
        last = self.generations if limits.iterations is None else min(self.generations, limits.iterations)
        recorder.incumbent(people.routes(people.fittest))
        generation = 0
        while generation < last and recorder.remaining > 0:
            generation += 1
            people = self._next(people, instance.cost, candidates, rng, generation)
            if people.fitness[people.fittest] < recorder.objective:
                recorder.incumbent(people.routes(people.fittest))
        stopped_by = "time" if generation < last else "finished" if generation == self.generations else "iterations"
        return recorder.result(stopped_by, generations=generation)

    def _first_population(self, instance: Instance, rng: np.random.Generator, start: Routes | None) -> Population:
        n, m = int(instance.n_tasks), int(instance.n_depots)
        chromosomes = [random_chromosome(instance, rng) for _ in range(self.population)]
        if start is not None:
            chromosomes[0] = start
        perms = np.array([[task for route in routes for task in route] for routes in chromosomes], dtype=np.int64)
        sizes = np.array([[len(route) for route in routes] for routes in chromosomes], dtype=np.int64)
        people = Population(perms, sizes, np.zeros((self.population, m)), np.zeros(self.population))
        for row in range(self.population):
            people.fitness[row] = evaluate(instance.cost, perms[row], sizes[row], people.totals[row], n)
        return people

    def _next(
        self, people: Population, cost: Floats, candidates: Bools, rng: np.random.Generator, generation: int
    ) -> Population:
        inter = generation % self.inter_every == 0
        return Population(
            *next_generation(
                cost,
                rng,
                people.perms,
                people.sizes,
                people.totals,
                people.fitness,
                candidates,
                self.tournament,
                float(self.tournament_rate),
                round(self.elite * self.population),
                float(self.crossover_rate),
                inter,
                float(self.inter_rate if inter else self.intra_rate),
            )
        )


@dataclass(frozen=True, eq=False)
class Population:
    """Chromosomes, a row each: perms (p, n), sizes (p, m), totals (p, m) [s], fitness (p,) [s]."""

    perms: Ints
    sizes: Ints
    totals: Floats
    fitness: Floats

    @property
    def fittest(self) -> int:
        """The row of the shortest C_max."""
        return int(np.argmin(self.fitness))

    def routes(self, row: int) -> Routes:
        """Return a chromosome as routes."""
        return as_routes(np.split(self.perms[row], np.cumsum(self.sizes[row])[:-1]))


def depot_distance(instance: Instance) -> Floats:
    """Return c_ki + c_ik [s] of each task and depot, shape (n, m)."""
    n = instance.n_tasks
    return instance.cost[n:, :n].T + instance.cost[:n, n:]


def random_chromosome(instance: Instance, rng: np.random.Generator) -> Routes:
    """Return the tasks grouped by nearest depot, each group in random order."""
    distance = depot_distance(instance)
    nearest = distance == distance.min(axis=1, keepdims=True)
    depot = np.where(nearest, rng.random(nearest.shape), -1.0).argmax(axis=1)  # ties at random
    order = rng.permutation(instance.n_tasks)
    return as_routes(order[depot[order] == k] for k in range(instance.n_depots))


def border_line(instance: Instance, border: float) -> Bools:
    """Return which depots are candidates of each task, shape (n, m): no farther than (1 + border) × the nearest."""
    distance = depot_distance(instance)
    return distance <= (1.0 + border) * distance.min(axis=1, keepdims=True)


@njit(cache=True)
def winner(rng: Any, fitness: Floats, size: int, rate: float) -> int:  # pragma: no cover - compiled
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
def next_generation(
    cost: Floats,
    rng: Any,
    perms: Ints,
    sizes: Ints,
    totals: Floats,
    fitness: Floats,
    candidates: Bools,
    tournament: int,
    tournament_rate: float,
    elite: int,
    crossover_rate: float,
    inter: bool,
    mutation_rate: float,
) -> tuple[Ints, Ints, Floats, Floats]:  # pragma: no cover - compiled
    """Return the perms, sizes, totals and fitness of the next generation."""
    people, n = perms.shape
    children = np.empty_like(perms), np.empty_like(sizes), np.empty_like(totals), np.empty_like(fitness)
    pair = (
        np.empty((2, n), dtype=np.int64),
        np.empty((2, sizes.shape[1]), dtype=np.int64),
        np.empty((2, sizes.shape[1])),
    )
    for row in range(0, people, 2):
        for p in range(2):
            parent = winner(rng, fitness, tournament, tournament_rate)
            pair[0][p], pair[1][p], pair[2][p] = perms[parent], sizes[parent], totals[parent]
        if rng.random() < crossover_rate:
            best_cost_route_crossover(cost, rng, pair[0], pair[1], pair[2], n)
        for p in range(min(2, people - row)):
            if rng.random() < mutation_rate:
                if inter:
                    inter_depot_mutation(cost, rng, pair[0][p], pair[1][p], pair[2][p], candidates, n)
                else:
                    intra_depot_mutation(cost, rng, pair[0][p], pair[1][p], pair[2][p], n)
            children[3][row + p] = evaluate(cost, pair[0][p], pair[1][p], pair[2][p], n)
            children[0][row + p], children[1][row + p], children[2][row + p] = pair[0][p], pair[1][p], pair[2][p]
    survivors = np.argsort(fitness)[:elite]
    places = rng.permutation(people)[:elite]
    for old, new in zip(survivors, places):  # noqa: B905 - numba knows no strict
        children[0][new], children[1][new], children[2][new] = perms[old], sizes[old], totals[old]
        children[3][new] = fitness[old]
    return children
