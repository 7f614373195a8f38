"""myopic: each UAV goes on to the place of greatest entropy within reach from which it still gets home.

Of the candidate places within `within` of the UAV, the one of greatest posterior variance, given every reading that
has been taken or will be on the legs chosen so far; entropy ½ log 2πe var grows with it. The UAV that has flown least
chooses next. Variances do not depend on what is read, so the whole plan is known before take-off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.blas import one_thread
from formulations.limits import Limits
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.surveying.problem import Sensor, SurveyPlanner, SurveyProblem, Tours, length_of, readings
from formulations.task_location.placement import lattice
from instances.arrays import Floats


@dataclass(frozen=True)
class Myopic(SurveyPlanner):
    """Entropy within reach.

    within : farthest next place, in length scales of what is believed (above 0).
    candidates : places a side of the region's bounding box (at least 2).
    """

    within: float = 1.5
    candidates: int = 41

    def accepts(self, problem: SurveyProblem) -> str | None:
        """Decline regions in which a straight leg may leave the region."""
        return None if problem.is_convex else "legs are straight, so the region must be convex"

    @one_thread()
    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Choose leg after leg until nobody can go on."""
        places = lattice(problem.region, max(2, self.candidates))
        reach = self.within * max(problem.kernel.length_scales)
        process = GaussianProcess(problem.kernel, problem.noise_sd, places, 0.0)
        tours, flying = [depot[None] for depot in problem.depots], set(range(len(problem.depots)))
        while flying:
            uav = min(flying, key=lambda k: length_of(tours[k]))
            target = _next(problem, tours[uav], problem.depots[uav], places, process.posterior().sd, reach)
            if target is None:
                flying.remove(uav)
                target = problem.depots[uav]
            taken = len(readings(tours[uav], problem.spacing))
            tours[uav] = np.concatenate([tours[uav], target[None]])
            new = readings(tours[uav], problem.spacing)[taken:]
            process.extend(new, np.zeros(len(new)))
        return tours


def _next(
    problem: SurveyProblem, tour: Floats, depot: Floats, places: Floats, sd: Floats, reach: float
) -> Floats | None:
    """Return the place [m] where the UAV goes on to, None where it must go home."""
    left, away = problem.length - problem.cost_of(tour), np.hypot(*(places - tour[-1]).T)
    there, back = problem.costs(tour[-1:], places), problem.costs(places, depot[None])
    open_to = (away > 0.5 * problem.spacing) & (away <= reach) & (there + back <= left)
    return places[np.argmax(np.where(open_to, sd, -1.0))] if open_to.any() else None
