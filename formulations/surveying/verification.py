"""What is wrong with flown tours, and what their readings are worth: measured on them, not taken from the planner.

The map is fitted by `choose_model` to every reading of all UAVs, whatever planned them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from formulations.blas import one_thread
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_model import EVERY_KERNEL, MapModel, choose_model
from formulations.mapping.survey import Score, score
from formulations.surveying.problem import SurveyProblem, length_of, noise, readings
from instances.arrays import Floats

TOLERANCE = 1e-3
"""Metres by which tours may miss a depot, the border or a reading's place, and exceed their length: rounding."""


def tour_faults(problem: SurveyProblem, tours: Sequence[Floats], samples: Sequence[Floats]) -> list[str]:
    """Return what is wrong with `tours`, (k, 2) [m] each, and with where they say to have measured, a sentence each."""
    if len(tours) != len(problem.depots) or len(samples) != len(tours):
        return [f"has tours of {len(tours)} and samples of {len(samples)} UAVs for {len(problem.depots)} depots"]
    found = []
    for uav, (tour, measured) in enumerate(zip(tours, samples, strict=True)):
        if not (np.isfinite(tour).all() and np.isfinite(measured).all()):
            return [f"UAV {uav}: positions are not finite"]
        found += [f"UAV {uav} {fault}" for fault in _faults(problem, problem.depots[uav], tour, measured)]
    return found


def _faults(problem: SurveyProblem, depot: Floats, tour: Floats, measured: Floats) -> list[str]:
    found, length, cost = [], length_of(tour), problem.cost_of(tour)
    for end, where in (("starts", tour[:1]), ("ends", tour[-1:])):
        if (away := float(np.hypot(*(where - depot).T).max(initial=0.0))) > TOLERANCE:
            found.append(f"{end} {away:.6g} m from its depot")
    if cost > problem.length + TOLERANCE:
        spent = f"flies {length:.6g} m" if problem.measure is None else f"spends {cost:.6g} m of calm air in the wind"
        found.append(f"{spent}, more than the {problem.length:.6g} m it may")
    if (depth := _depth_outside(problem, tour)) > TOLERANCE:
        found.append(f"flies up to {depth:.6g} m outside the region")
    due = readings(tour, problem.spacing)
    if len(due) != len(measured):
        found.append(f"has {len(measured)} samples where {len(due)} are due on {length:.6g} m")
    elif (away := float(np.hypot(*(due - measured).T).max(initial=0.0))) > TOLERANCE:
        found.append(f"says it measured {away:.6g} m from where it was at that time")
    return found


def _depth_outside(problem: SurveyProblem, tour: Floats) -> float:
    if len(tour) < 2:
        return 0.0
    area = problem.region.polygon
    beyond = shapely.get_coordinates(shapely.difference(shapely.linestrings(tour), area))
    return float(np.max(shapely.distance(shapely.points(beyond), area), initial=0.0))


def reading_faults(
    problem: SurveyProblem, tours: Sequence[Floats], read: Sequence[tuple[int, int, float, float]]
) -> list[str]:
    """Return what is wrong with readings taken in flight: UAV, number from 1 and place [m] of each, in time order."""
    due = [readings(tour, problem.spacing) for tour in tours]
    for uav, tick, x, y in read:
        if not (0 <= uav < len(due) and 1 <= tick <= len(due[uav])):
            return [f"read number {tick} of UAV {uav}, which never measured it"]
        if np.hypot(*(due[uav][tick - 1] - (x, y))) > TOLERANCE:
            return [f"UAV {uav} read at ({x:g}, {y:g}) m as its number {tick}, but was elsewhere"]
    if any(later < earlier for earlier, later in pairwise(tick for _, tick, _, _ in read)):
        return ["read in flight, but not in the order of time"]
    return []


@dataclass(frozen=True)
class Worth:
    """What tours are worth: score of the map, its model in words, what the plan promised and how long it is.

    promised_sd : √J, the root mean square posterior sd at the problem's targets, under what was believed.
    information : ½ log det(I + K/σ²) of the readings under the same [nats]. length, longest [m].
    """

    score: Score
    model: str
    promised_sd: float
    information: float
    length: float
    longest: float
    samples: int


@one_thread()
def worth_of(
    problem: SurveyProblem, tours: Sequence[Floats], truth: Callable[[Floats], Floats], points: Floats, seed: int
) -> Worth:
    """Measure `truth` along `tours` with the noise of `seed`, map it at `points` (p, 2) [m] and judge the map."""
    positions, values = measured(problem, tours, truth, seed)
    model = choose_model(MapModel(problem.kernel), EVERY_KERNEL, problem.noise_sd, positions, values).model
    process = GaussianProcess(model, problem.noise_sd, points)
    process.extend(positions, values)
    planned = GaussianProcess(problem.kernel, problem.noise_sd, problem.targets, 0.0)
    planned.extend(positions, values)
    lengths = [length_of(tour) for tour in tours]
    return Worth(
        score(process.posterior(), truth(points), problem.noise_sd),
        str(model),
        float(np.sqrt(np.mean(planned.posterior().sd ** 2))),
        planned.information(),
        sum(lengths),
        max(lengths),
        len(values),
    )


def measured(
    problem: SurveyProblem, tours: Sequence[Floats], truth: Callable[[Floats], Floats], seed: int
) -> tuple[Floats, Floats]:
    """Return positions (N, 2) [m] and values (N,) of all readings in the order of time, then of UAVs."""
    rows = []
    for uav, tour in enumerate(tours):
        at = readings(tour, problem.spacing)
        values = truth(at) + noise(problem.noise_sd, seed, uav, range(1, len(at) + 1))
        rows += [(tick, uav, *place, value) for tick, (place, value) in enumerate(zip(at, values, strict=True))]
    table = np.array(sorted(rows), dtype=float).reshape(-1, 5)
    return table[:, 2:4], table[:, 4]
