"""pypolo: each UAV goes on to the place of best score of PyPolo, way home kept.

PyPolo's MyopicPlanning draws candidates uniformly from the region's bounding box and goes to that of the greatest

    (H − min H)/(max H − min H) − (d − min d)/(max d − min d),   H = entropy of the reading, d = distance

(W. Chen, R. Khardon, L. Liu, AK: Attentive Kernel for Information Gathering, RSS 2022). It plans for one robot and
knows neither endurance nor home: here UAVs take turns, who has flown least goes next, all share what is known, and a
place from which there is no way home is drawn again, ASKED times at most.

PyPolo 0.0.3 calls `ndarray.ptp`, which numpy 2 has not: there it cannot run, and is declined.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

import numpy as np

from formulations.blas import one_thread
from formulations.limits import Limits
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.surveying.problem import Sensor, SurveyPlanner, SurveyProblem, Tours, length_of, readings
from instances.arrays import Floats

ASKED = 10
"""Places that are drawn before a UAV goes home."""


@dataclass(frozen=True)
class EntropyAndDistance(SurveyPlanner):
    """MyopicPlanning of PyPolo 0.0.3.

    candidates : places drawn for each decision (at least 2).
    """

    candidates: int = 1000

    def accepts(self, problem: SurveyProblem) -> str | None:
        """Decline where the library is missing or cannot run, and regions in which a leg may leave the region."""
        if find_spec("pypolo") is None:
            return "pypolo is not installed (docs/methods/surveys.md says how)"
        if int(np.__version__.partition(".")[0]) >= 2:
            return f"PyPolo 0.0.3 needs numpy below 2 (it calls ndarray.ptp), and here is numpy {np.__version__}"
        return None if problem.is_convex else "legs are straight, so the region must be convex"

    def prepare(self, problem: SurveyProblem) -> None:
        """Import, which takes seconds."""
        _strategy()

    @one_thread()
    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Choose leg after leg until nobody can go on."""
        x0, y0, x1, y1 = problem.region.bounds
        draws, count = np.random.RandomState(seed), max(2, self.candidates)
        robots = [_Robot(depot) for depot in problem.depots]
        planners = [_strategy()([x0, x1, y0, y1], draws, count, robot) for robot in robots]
        known, flying = np.empty((0, 2)), set(range(len(robots)))
        tours = [depot[None] for depot in problem.depots]
        while flying:
            uav = min(flying, key=lambda k: length_of(tours[k]))
            goal = self._next(problem, planners[uav], tours[uav], known)
            if goal is None:
                flying.remove(uav)
                goal = problem.depots[uav]
            taken = len(readings(tours[uav], problem.spacing))
            tours[uav] = np.concatenate([tours[uav], goal[None]])
            robots[uav].state = goal
            known = np.concatenate([known, readings(tours[uav], problem.spacing)[taken:]])
        return tours

    def _next(self, problem: SurveyProblem, planner: Any, tour: Floats, known: Floats) -> Floats | None:
        """Return the place [m] that PyPolo goes on to, None where none of ASKED has a way home."""

        def model(places: Floats) -> tuple[None, Floats]:
            process = GaussianProcess(problem.kernel, problem.noise_sd, places, 0.0)
            process.extend(known, np.zeros(len(known)))
            return None, np.hypot(process.posterior().sd, problem.noise_sd)

        left = problem.length - problem.cost_of(tour)
        for _ in range(ASKED):
            goal = np.asarray(planner.get(model), dtype=float).reshape(-1, 2)[-1:]
            cost = problem.costs(tour[-1:], goal) + problem.costs(goal, tour[:1])
            if cost[0] <= left and problem.region.contains(goal).all():
                return np.asarray(goal[0])
        return None


def _strategy() -> Any:
    from pypolo.strategies import MyopicPlanning

    return MyopicPlanning


@dataclass
class _Robot:
    """What PyPolo asks of a robot: where it is; that it is sent to a goal is all that is wanted of it."""

    state: Floats
    goal_states: list[Floats] = field(default_factory=list)
    sampling_locations: list[Floats] = field(default_factory=list)

    @property
    def has_goal(self) -> bool:
        return bool(self.goal_states)

    def control(self) -> tuple[float, None]:
        return 0.0, None

    def update(self, distance: float, action: None) -> None:
        self.sampling_locations.append(self.goal_states.pop())

    def commit_data(self) -> Floats:
        sent, self.sampling_locations = np.array(self.sampling_locations), []
        return sent
