"""adaptive: the polished plan, bent in flight by what was read.

Every so many rounds of readings the squared exponential is fitted to all of them by restricted likelihood, and what
remains of every tour is polished again under it, from where the UAV is, for what is still unknown, within what is left
of its endurance; the order of visits stays. A rest is taken only where it promises less variance than the one in the
air. With known hyperparameters variances do not depend on what is read, so that all that is gained is gained through
them (A. Krause, C. Guestrin, Nonmyopic Active Learning of Gaussian Processes, 2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from formulations.average_variance import AverageVariance
from formulations.kernel import SquaredExponential
from formulations.limits import Limits
from formulations.mapping.map_model import MapModel, Offered, choose_model
from formulations.polish.path_polish import polish
from formulations.surveying.polished import Polished, polish_problem
from formulations.surveying.problem import Sensor, SurveyProblem, Tours, readings, travelled
from instances.arrays import Floats

SMOOTH = Offered((SquaredExponential,))
"""Planning stays with the squared exponential, whose gradients polish needs."""


@dataclass(frozen=True)
class Adaptive(Polished):
    """Polished tours, polished again in flight.

    every : rounds of readings between two re-plans (at least 1).
    """

    every: int = 10

    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Plan, then fly, read and re-plan until everybody is home."""
        tours = super().plan(problem, sensor, limits=limits, seed=seed)
        places, values, model = np.empty((0, 2)), np.empty(0), MapModel(problem.kernel)
        step, done = max(1, self.every), 0
        while done + step < max(len(readings(tour, problem.spacing)) for tour in tours):
            for tick in range(done, done + step):
                for uav, tour in enumerate(tours):
                    here = readings(tour, problem.spacing)[tick : tick + 1]
                    places = np.concatenate([places, here])
                    values = np.concatenate([values, sensor.read(uav, tick + 1, here)])
            done += step
            model = choose_model(model, SMOOTH, problem.noise_sd, places, values).model
            tours = bent(problem, tours, done * problem.spacing, model, places)
        return tours


def bent(problem: SurveyProblem, tours: Sequence[Floats], flown: float, model: MapModel, known: Floats) -> Tours:
    """Return `tours` with what is left of them after `flown` [m] polished under `model`; known : readings so far."""
    heads, rests = zip(*(divided(tour, flown) for tour in tours), strict=True)
    noise_sd = float(np.hypot(problem.noise_sd, model.nugget_sd))
    judged = AverageVariance(model.kernel, noise_sd, problem.targets, known=known)
    budgets = [max(0.0, problem.length - problem.cost_of(head)) for head in heads]
    wanted = polish_problem(problem, judged, rests, np.array(budgets))
    spacing = max(problem.spacing, 0.5 * min(model.kernel.length_scales))
    found = polish(wanted, spacing=spacing, warm=True).paths
    return [np.concatenate([head, rest[1:]]) for head, rest in zip(heads, found, strict=True)]


def divided(tour: Floats, at: float) -> tuple[Floats, Floats]:
    """Return `tour` (k, 2) [m] up to `at` [m] and from there on; the rest of one that is over is (0, 2)."""
    s = travelled(tour)
    if not len(s) or at >= s[-1]:
        return tour, np.empty((0, 2))
    here = np.array([[np.interp(at, s, tour[:, axis]) for axis in (0, 1)]])
    return np.concatenate([tour[s < at], here]), np.concatenate([here, tour[s > at]])
