"""Honest methods that log when they begin, one for each problem, for `kills`."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from formulations.moving_cost.method import MovingCostMethod, MovingCosts, silent
from formulations.routing.solver import Solver
from formulations.surveying.problem import SurveyPlanner
from formulations.task_location.placement import PlacementMethod, PlacementStatus
from instances.paths import Paths
from tests.faults.hostile import honest

WORK = 0.4
"""Seconds that each run takes."""


def log(seed: int) -> None:
    """Add seed and moment [s since 1970] to the log of executions, in one piece."""
    path = os.environ.get("WORKBENCH_EXECUTED")
    if path:
        descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(descriptor, f"{seed} {time.time()}\n".encode())
        os.close(descriptor)


@dataclass(frozen=True)
class Routes(Solver):
    """Does everything with the first UAV."""

    proves: ClassVar[bool] = False

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        log(seed)
        time.sleep(WORK)
        found = honest(instance, observe)
        return found


@dataclass(frozen=True)
class Points(PlacementMethod):
    """Offers the region's first candidates."""

    status: ClassVar[PlacementStatus] = PlacementStatus.HEURISTIC

    def search(self, problem, progress, seed):
        log(seed)
        time.sleep(WORK)
        points = problem.candidates[: problem.n_tasks]
        progress.offer(points, problem.criterion.value(points))
        return self.status


@dataclass(frozen=True)
class Costs(MovingCostMethod):
    """Flies straight; its seed is not told to it."""

    def solve(self, query, progress=silent):
        p, n = query.terminals, len(query.terminals)
        if n > 2:  # two are asked for to prepare
            log(-1)
            time.sleep(WORK)
        legs = [p[[i, j]] if i != j else np.empty((0, 2)) for i in range(n) for j in range(n)]
        return MovingCosts(np.hypot(*(p[:, None] - p[None]).transpose(2, 0, 1)) / query.v0, Paths.of(n, legs))


@dataclass(frozen=True)
class Tours(SurveyPlanner):
    """Flies to the middle of the region and back."""

    def plan(self, problem, sensor, *, limits, seed):
        log(seed)
        time.sleep(WORK)
        return [np.stack([depot, depot + 0.3 * (problem.targets.mean(0) - depot), depot]) for depot in problem.depots]
