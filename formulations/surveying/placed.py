"""workbench, greedy, random: tasks are placed, as many as endurance takes, and routed min-max by the memetic search.

How many fit is found by trial: from n ≈ (Σ_k L_k)²/A, the tours of an even spread, in growing steps to the first n
whose longest tour is longer than a UAV may fly, then by bisection. Every trial has the same budget of search steps, so
that a seed always makes the same plan.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from formulations.blas import one_thread
from formulations.limits import Limits
from formulations.routing.registry import make_solver
from formulations.surveying.problem import Sensor, SurveyPlanner, SurveyProblem, Tours, length_of
from formulations.task_location.criterion import Criterion
from formulations.task_location.placement import PlacementProblem, place
from formulations.task_location.registry import make_method
from instances import Instance, Routes
from instances.arrays import Floats

SHARE = 0.8
"""Of (Σ_k L_k)²/A: so many tasks are tried first."""
LARGEST_STEP = 16
"""By which the number of tasks grows at most from trial to trial."""
STEPS = 4_000
"""Of the route search, for each task of a trial."""


@dataclass(frozen=True)
class Placed(SurveyPlanner):
    """What the planners of tasks share: the number that fits, and their routes.

    steps : of the route search, for each task (at least 1).
    """

    steps: int = STEPS
    solver: ClassVar[str] = "memetic"

    def accepts(self, problem: SurveyProblem) -> str | None:
        """Decline regions in which a straight leg may leave the region."""
        return None if is_convex(problem) else "legs are straight, so the region must be convex"

    def prepare(self, problem: SurveyProblem) -> None:
        """Compile the route search."""
        make_solver(self.solver).prepare(instance_of(problem, problem.depots[:1] + 1.0))

    @abstractmethod
    def placed(self, problem: SurveyProblem, count: int, seed: int) -> Floats:
        """Return `count` tasks, shape (count, 2) [m]."""

    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Return the tours past the most tasks that fit; nobody flies where not even one does."""
        found: dict[int, Tours | None] = {0: [np.empty((0, 2)) for _ in problem.depots]}

        def fits(count: int) -> bool:
            if count not in found:
                tours = self.routed(problem, self.placed(problem, count, seed), seed)
                found[count] = tours if max(map(length_of, tours)) <= problem.length else None
            return found[count] is not None

        most = _greatest(fits, max(1, round(SHARE * _even(problem))))
        return found[most] or []

    @one_thread()
    def routed(self, problem: SurveyProblem, tasks: Floats, seed: int) -> Tours:
        """Return closed tours past `tasks` (n, 2) [m], the longest about as short as can be."""
        instance = instance_of(problem, tasks)
        method = make_solver(self.solver)
        steps = max(1, self.steps) * len(tasks)
        routes = method.solve(instance, limits=Limits(time=math.inf, iterations=steps), seed=seed).routes
        assert routes is not None  # without endurance there are always routes
        return tours_of(problem, tasks, routes)


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


def is_convex(problem: SurveyProblem) -> bool:
    """Return whether every straight leg between points of the region stays inside."""
    polygon = problem.region.polygon
    return bool(polygon.convex_hull.area - polygon.area <= 1e-9 * polygon.area)


def instance_of(problem: SurveyProblem, tasks: Floats) -> Instance:
    """Return routing past `tasks` (n, 2) [m] by straight legs; costs are lengths [m]."""
    points = np.concatenate([tasks, problem.depots])
    cost = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    return Instance("survey", cost, len(tasks), len(problem.depots), points)


def tours_of(problem: SurveyProblem, tasks: Floats, routes: Routes) -> Tours:
    """Return the polyline of each route, from the depot past its tasks and back."""
    return [
        np.concatenate([depot[None], tasks[list(route)], depot[None]]) if route else np.empty((0, 2))
        for depot, route in zip(problem.depots, routes, strict=True)
    ]


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
