"""workbench, greedy, random: tasks are placed, as many as endurance takes, and routed min-max by the memetic search.

How many fit is found by trial: from n ≈ (Σ_k L_k)²/A, the tours of an even spread, in growing steps to the first n
whose longest tour is longer than a UAV may fly, then by bisection. Every trial has the same budget of search steps, so
that a seed always makes the same plan. Legs are straight, or bend at corners of what is in the way, and cost what they
cost in the wind.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from formulations.blas import one_thread
from formulations.limits import Limits
from formulations.replanning.ways import Legs, Ways
from formulations.routing.registry import make_solver
from formulations.surveying.problem import Sensor, SurveyPlanner, SurveyProblem, Tours
from formulations.task_location.criterion import Criterion
from formulations.task_location.placement import PlacementProblem, place
from formulations.task_location.registry import make_method
from instances import Instance, Routes
from instances.arrays import Floats
from instances.environment.wind import Uniform
from instances.moving_cost import CostKind, CostMeasure

SHARE = 0.8
"""Of (Σ_k L_k)²/A: so many tasks are tried first."""
LARGEST_STEP = 16
"""By which the number of tasks grows at most from trial to trial."""
STEPS = 4_000
"""Of the route search, for each task of a trial."""
CALM = CostMeasure(CostKind.ENERGY, Uniform((0.0, 0.0)), 1.0)
"""Costs are lengths [m]."""


@dataclass(frozen=True)
class Placed(SurveyPlanner):
    """What the planners of tasks share: the number that fits, and their routes.

    steps : of the route search, for each task (at least 1).
    """

    steps: int = STEPS
    solver: ClassVar[str] = "memetic"

    def prepare(self, problem: SurveyProblem) -> None:
        """Compile the route search."""
        make_solver(self.solver).prepare(instance_of(problem, problem.depots[:1] + 1.0)[0])

    @abstractmethod
    def placed(self, problem: SurveyProblem, count: int, seed: int) -> Floats:
        """Return `count` tasks, shape (count, 2) [m]."""

    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Return the tours past the most tasks that fit; nobody flies where not even one does."""
        found: dict[int, Tours | None] = {0: [np.empty((0, 2)) for _ in problem.depots]}

        def fits(count: int) -> bool:
            if count not in found:
                tours = self.routed(problem, self.placed(problem, count, seed), seed)
                found[count] = tours if max(map(problem.cost_of, tours)) <= problem.length else None
            return found[count] is not None

        most = _greatest(fits, max(1, round(SHARE * _even(problem))))
        return found[most] or []

    @one_thread()
    def routed(self, problem: SurveyProblem, tasks: Floats, seed: int) -> Tours:
        """Return closed tours past `tasks` (n, 2) [m], the longest about as short as can be."""
        instance, legs = instance_of(problem, tasks)
        method = make_solver(self.solver)
        steps = max(1, self.steps) * len(tasks)
        routes = method.solve(instance, limits=Limits(time=math.inf, iterations=steps), seed=seed).routes
        assert routes is not None  # without endurance there are always routes
        return tours_of(legs, len(tasks), routes)


@dataclass(frozen=True)
class Workbench(Placed):
    """Tasks of most mutual information (b) with the field at test points.

    method : how tasks are placed (workbench methods lists them).
    tests : columns and rows of test points (at least 1).
    """

    method: str = "l-bfgs-b"
    tests: int = 10

    def placed(self, problem: SurveyProblem, count: int, seed: int) -> Floats:
        """Place by the method."""
        centres = problem.region.cell_centres(max(1, self.tests), max(1, self.tests))
        criterion = Criterion(problem.kernel, centres, None, problem.noise_sd)
        made = make_method(self.method)
        return place(PlacementProblem(problem.region, criterion, count), made, self.method, seed=seed).points


@dataclass(frozen=True)
class Greedy(Workbench):
    """Tasks one after the other, each where it adds most mutual information (b)."""

    method: str = "greedy"


@dataclass(frozen=True)
class RandomTasks(Placed):
    """Uniform random tasks; of n + 1 the first n are those of n."""

    def placed(self, problem: SurveyProblem, count: int, seed: int) -> Floats:
        """Draw."""
        return problem.region.sample(count, np.random.default_rng(seed))


def instance_of(problem: SurveyProblem, tasks: Floats) -> tuple[Instance, Legs]:
    """Return routing past `tasks` (n, 2) [m], costs in metres, and its legs: straight where that is inside."""
    points = np.concatenate([tasks, problem.depots])
    legs = Ways(problem.region, problem.measure or CALM).between(points)
    cost = legs.cost if problem.measure is None else problem.measure.speed * legs.cost
    return Instance("survey", cost, len(tasks), len(problem.depots), points), legs


def tours_of(legs: Legs, n_tasks: int, routes: Routes) -> Tours:
    """Return the polyline of each route, from the depot past its tasks, the first points of `legs`, and back."""
    tours = []
    for depot, route in enumerate(routes, n_tasks):
        parts = [legs.points[[depot]], *(legs.path(a, b)[1:] for a, b in pairwise([depot, *route, depot]))]
        tours.append(np.concatenate(parts) if route else np.empty((0, 2)))
    return tours


def _even(problem: SurveyProblem) -> float:
    """Return how many tasks, evenly spread, tours of all the length allowed pass: their legs are √(A/n)."""
    return float((len(problem.depots) * problem.length) ** 2 / problem.region.polygon.area)


def _greatest(fits: Callable[[int], bool], first: int) -> int:
    """Return the n ≥ 0 of a change from fitting to not fitting that is met from `first`; 0 fits."""
    low, high, step = 0, first, max(1, first // 10)
    while fits(high):
        low, high, step = high, high + step, min(2 * step, LARGEST_STEP)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
