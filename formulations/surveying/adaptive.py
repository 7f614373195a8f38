"""adaptive: the workbench's plan, changed in flight by what was read (`formulations.replanning`).

Every so many rounds of readings the squared exponential is fitted to all of them by restricted likelihood, and what
remains is placed, routed and, unless `polish` is off, polished anew under it, from where the UAVs are. Another plan is
flown where it promises less variance over the region than the one in the air, within what is left of
everybody's endurance. All that is gained is gained through what is learned of the field's length scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from formulations.limits import Limits
from formulations.mapping.flight import Flight
from formulations.mapping.map_grid import MapGrid
from formulations.mapping.map_model import MapModel
from formulations.replanning.aloft import Aloft, World
from formulations.replanning.in_flight import fly_replanned
from formulations.replanning.replan import Planner, Replan
from formulations.replanning.ways import Ways
from formulations.surveying.placed import CALM, Workbench
from formulations.surveying.polished import polished
from formulations.surveying.problem import Sensor, SurveyProblem, Tours
from instances.arrays import Floats

TARGETS = 20
"""Cells along the region's longer side at whose centres plans are judged in flight: a quarter of the problem's targets
make plans as good, in a quarter of the time."""


@dataclass(frozen=True)
class Adaptive(Workbench):
    """The workbench's tours, re-planned in flight.

    every : rounds of readings between two re-plans (at least 1).
    polish : whether waypoints are moved for what is sensed on the way, at take-off and in flight.
    """

    every: int = 5
    polish: bool = True

    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Plan, then fly, read and re-plan until everybody is home."""
        tours = super().plan(problem, sensor, limits=limits, seed=seed)
        if self.polish:
            tours = polished(problem, tours)
        centres = problem.region.cell_centres(max(1, self.tests), max(1, self.tests))
        return replanned(problem, tours, sensor, centres, every=max(1, self.every), polish=self.polish)[0]


def replanned(
    problem: SurveyProblem, tours: Tours, sensor: Sensor, tests: Floats, *, every: int = 5, polish: bool = True
) -> tuple[Tours, list[Replan]]:
    """Fly `tours` and re-plan them; return the tours as flown, and every re-plan.

    tests : points (m, 2) [m] by which tasks are placed. every, polish : as in `Adaptive`.
    """
    measure = problem.measure or CALM
    flights = [Flight.straight(tour, measure.speed) for tour in tours]
    within = np.full(len(tours), problem.length / measure.speed)
    aloft = Aloft(flights, [tour[1:-1] for tour in tours], problem.depots, within)
    model = MapModel(problem.kernel)
    targets = MapGrid.over(problem.region, TARGETS).points
    period = problem.spacing / measure.speed
    planner = Planner(model, problem.noise_sd, period, tests, targets, polish=polish)

    def read(tick: int, uavs: Sequence[int], places: Floats) -> Floats:
        return np.concatenate([sensor.read(k, tick, here) for k, here in zip(uavs, places, strict=True)])

    flown, made = fly_replanned(aloft, read, planner, world_of(problem), every=every)
    return [waypoints(flight) for flight in flown], made


def world_of(problem: SurveyProblem) -> World:
    """Return the region and its air; legs stay inside, and no other rule can be broken."""
    return World(Ways(problem.region, problem.measure or CALM), problem.region, None, lambda flights, rests: "")


def waypoints(flight: Flight) -> Floats:
    """Return the polyline of a straight flight, (w + 1, 2) [m]; (0, 2) for who stays home."""
    if not len(flight.starts):
        return np.empty((0, 2))
    return np.concatenate([flight.starts[:, :2], flight.poses(flight.length)[:, :2]])
