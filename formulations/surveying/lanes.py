"""lawnmower: parallel lanes, flown to and fro and shared by the UAVs (`formulations.mapping.lawnmower`).

Of lanes west–east and south–north and of several margins, each with as many lanes as every UAV can fly and come home,
the one that promises the least mean posterior variance before take-off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.average_variance import AverageVariance
from formulations.blas import one_thread
from formulations.limits import Limits
from formulations.mapping.lawnmower import INSETS, MOST_LANES, lawnmower_tours
from formulations.surveying.problem import Sensor, SurveyPlanner, SurveyProblem, Tours, readings


@dataclass(frozen=True)
class Lawnmower(SurveyPlanner):
    """What a person flies without a planner."""

    def accepts(self, problem: SurveyProblem) -> str | None:
        """Decline regions that lanes may leave, and those where not even one lane fits."""
        if not problem.is_convex:
            return "lanes are straight, so the region must be convex"
        fitting = any(_most_lanes(problem, along, inset) for along in (0, 1) for inset in INSETS)
        return None if fitting else f"no lane and the ways there and back are at most {problem.length:g} m a UAV"

    @one_thread()
    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Return the tours of least promised variance."""
        left = AverageVariance(problem.kernel, problem.noise_sd, problem.targets)

        def promised(tours: Tours) -> float:
            return left.value(np.concatenate([readings(tour, problem.spacing) for tour in tours]))

        tried = [_most_lanes(problem, along, inset) for along in (0, 1) for inset in INSETS]
        return min(filter(None, tried), key=promised)


def _most_lanes(problem: SurveyProblem, along: int, inset: float) -> Tours | None:
    """Return the tours of the most lanes that fit, None where none does."""
    best: Tours | None = None
    for count in range(1, MOST_LANES):
        tours = lawnmower_tours(problem.region, problem.depots, count, along, inset)
        if max(map(problem.cost_of, tours)) <= problem.length:
            best = tours
        elif count >= len(problem.depots):  # fewer lanes than UAVs can be the longer way
            break
    return best
