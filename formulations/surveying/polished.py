"""polished: tasks as the workbench places and routes them, then path polish (`formulations.polish`).

Whole tasks leave endurance unused; here the tasks become waypoints, which move for what is sensed along the path: the
mean posterior variance at the problem's targets, under what is believed before take-off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from formulations.average_variance import AverageVariance
from formulations.limits import Limits
from formulations.polish.path_polish import PolishProblem, polish
from formulations.polish.straight_legs import StraightLegs
from formulations.surveying.placed import Workbench
from formulations.surveying.problem import Sensor, SurveyProblem, Tours
from instances.arrays import Floats


@dataclass(frozen=True)
class Polished(Workbench):
    """The workbench's tours with their waypoints moved for what is sensed on the way."""

    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Place, route, polish."""
        return polished(problem, super().plan(problem, sensor, limits=limits, seed=seed))


def polished(problem: SurveyProblem, tours: Sequence[Floats]) -> Tours:
    """Return `tours` polished."""
    judged = AverageVariance(problem.kernel, problem.noise_sd, problem.targets)
    return polish(polish_problem(problem, judged, tours, np.full(len(tours), problem.length))).paths


def polish_problem(
    problem: SurveyProblem, judged: AverageVariance, paths: Sequence[Floats], budgets: Floats
) -> PolishProblem:
    """Return the polish of `paths` for `judged`, each within its `budgets` [m]; speed is 1 m/s in calm air."""
    measure, room = problem.measure, problem.region
    if measure is None:
        return PolishProblem(judged, StraightLegs(1.0, 1.0), problem.spacing, paths, budgets, room)

    def flown(uav: int, path: Floats) -> tuple[float, bool]:
        return float(measure.segments(path[:-1], path[1:]).sum()), True

    speed = measure.speed
    legs = StraightLegs.of(measure, room, speed, speed)
    return PolishProblem(judged, legs, problem.spacing / speed, paths, budgets / speed, room, flown=flown)
