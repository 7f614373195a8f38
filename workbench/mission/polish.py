"""Path polish of a mission: waypoints moved for what is sensed along the tours, flown and judged before and after.

The endurance of each UAV bounds what its flight costs, turns included. Where none is given, no UAV flies further than
the longest tour that was planned, so that the mission takes no longer.

Products, in the folder of the flights: polish.json (√J before and after, the bound that no tours as long as the
longest pass, and of each UAV the costs and the budget), polished.csv (waypoints: uav, x, y [m], and the task each was,
or -1), unpolished.json (the flights as they were, as in flights.json) and unpolished.csv (their reference paths).
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from shapely.geometry import Polygon

from formulations.average_variance import AverageVariance
from formulations.mapping.flight import STRAY_RADII, Flight, plan_flight, reference_waypoints
from formulations.path_bound import path_bound
from formulations.polish.path_polish import PolishProblem, polish, split
from formulations.polish.straight_legs import StraightLegs
from formulations.replanning.spending import track_cost
from formulations.task_location.criterion import Convention
from instances import Instance, Routes
from instances.arrays import Floats
from instances.disk import write_aside
from instances.environment.region import Region
from instances.environment.terrain import Terrain
from instances.scenario import Scenario
from workbench.mission.belief import known_tau
from workbench.mission.place import criterion_of, kept_off, widened
from workbench.mission.safety import room_to_fly
from workbench.mission.settings import Mission
from workbench.mission.turns import measure_of

LEAST_SPACING = 6.0
"""Turning radii between waypoints at least, where legs are split: nearer ones cannot be flown over without loops."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What polish made of a plan: flights, their reference paths leg by leg, and nodes, tasks where they now are."""

    flights: list[Flight]
    legs: list[list[Floats]]
    places: Floats
    said: str


class Judge:
    """What flights of a mission cost, whether they may be flown, and what they leave unknown."""

    def __init__(self, mission: Mission, scenario: Scenario, ground: Terrain | None) -> None:
        self.mission, self.scenario, self.ground = mission, scenario, ground
        self.free = widened(scenario, mission.clearance).free
        criterion = criterion_of(mission, self.free).under(Convention.BOTH_NOISY)
        self.unknown = AverageVariance(
            criterion.kernel, criterion.noise_sd, criterion.tests, criterion.weights, tau=known_tau(mission)
        )
        self.measure = measure_of(scenario)
        windy = None if scenario.wind is None else self.measure
        self.legs = StraightLegs.of(windy, scenario.region, scenario.speed, mission.speed)

    @property
    def room(self) -> Region:
        """Where legs are to stay: clear of zones but for how far waypoints stray from a reference path."""
        stray = STRAY_RADII * self.mission.flight.turning_radius
        wide = self.free.polygon.buffer(stray).intersection(self.scenario.free.polygon)
        return Region(wide) if isinstance(wide, Polygon) else self.free

    @property
    def inner(self) -> Region:
        """Where waypoints are to be, with room for turns."""
        return kept_off(self.free, self.scenario.region, self.mission.clearance) or self.free

    def flight(self, path: Floats) -> Flight:
        """Return the flight along a closed path (w + 1, 2) [m], or of a UAV that stays home."""
        from workbench.mission.flight import in_wind

        reference = [path] if len(path) > 1 else []
        room = room_to_fly(self.mission, self.scenario)
        radius = self.mission.flight.turning_radius
        return in_wind(plan_flight(reference, speed=self.mission.speed, radius=radius, within=room), self.scenario)

    def cost(self, flight: Flight) -> float:
        """Return what a flight costs [s], its turns included."""
        return track_cost(flight, self.measure)

    def flown(self, uav: int, path: Floats) -> tuple[float, bool]:
        """Return what the flight of `uav` along `path` costs [s], and whether it may be flown."""
        from workbench.mission.baselines import unflyable

        flight = self.flight(path)
        return self.cost(flight), not unflyable(self.mission, self.scenario, self.ground, [flight])

    def left(self, flights: list[Flight]) -> tuple[float, int]:
        """Return √J, the root mean square sd that the samples of `flights` leave, and how many these are."""
        measured = zip(*(flight.measurements(self.mission.sensing.period) for flight in flights), strict=True)
        times, samples = (np.concatenate(each) for each in measured)
        return math.sqrt(self.unknown.value(samples, times)), len(samples)

    def least(self, flights: list[Flight]) -> float:
        """Return a √J that no tours from the depots pass, none longer than the longest of `flights`.

        Where the field drifts it takes readings as fresh, which tell more.
        """
        unknown = replace(self.unknown, tau=math.inf)
        period, depots = self.mission.sensing.period, self.scenario.depots
        if any(flight.clock is not None for flight in flights):  # of uneven speed: by number alone
            most = max(len(flight.measurements(period)[0]) for flight in flights)
            return math.sqrt(unknown.lower_bound(most * len(depots)))
        longest = max(flight.length for flight in flights)
        bound = path_bound(unknown, self.scenario.region, depots, longest, period * self.mission.speed)
        return math.sqrt(bound)


def polished_plan(
    judge: Judge, instance: Instance, routes: Routes, before: tuple[list[Flight], list[list[Floats]]], out: Path,
    tell: Callable[[str], None],
) -> Plan:  # fmt: skip
    """Return the plan `before` (flights and their legs) polished, and write the products; as it was if no better."""
    assert instance.coordinates is not None
    mission, (flights, legs) = judge.mission, before
    tell("moving waypoints for what is sensed along the paths")
    began = time.perf_counter()
    costs = np.array([judge.cost(flight) for flight in flights])
    endurance = np.minimum(instance.limits, mission.flight.endurance or np.inf)
    budgets = np.where(np.isfinite(endurance), endurance, costs.max())
    radius = mission.flight.turning_radius
    spacing = max(0.5 * min(judge.unknown.kernel.length_scales), LEAST_SPACING * radius)
    given = [split(_waypoints(each, STRAY_RADII * radius), spacing) for each in legs]
    problem = PolishProblem(
        judge.unknown, judge.legs, mission.sensing.period, given, budgets, judge.room, judge.inner, judge.flown
    )
    found = polish(problem, spacing=spacing)
    then = [judge.flight(p) if moved else f for p, moved, f in zip(found.paths, found.moved, flights, strict=True)]
    (rms_before, samples), (rms_after, now) = judge.left(flights), judge.left(then)
    paths = found.paths
    if not rms_after < rms_before:
        then, paths, rms_after, now = flights, given, rms_before, samples
    after = np.array([judge.cost(flight) for flight in then])
    places, tasks = _places(instance, routes, given, paths)
    told = {
        "rms_sd_before": rms_before,
        "rms_sd_after": rms_after,
        "bound": judge.least(then),
        "samples_before": samples,
        "samples_after": now,
        "costs_before": costs.tolist(),
        "costs_after": after.tolist(),
        "budgets": budgets.tolist(),
        "endurance_given": np.isfinite(endurance).tolist(),
        "lengths_before": [flight.length for flight in flights],
        "lengths_after": [flight.length for flight in then],
        "elapsed": round(time.perf_counter() - began, 3),
    }
    write_aside(out / "polish.json", json.dumps(told, indent=1))
    write_aside(out / "unpolished.json", json.dumps([flight.to_json() for flight in flights]))
    write_aside(out / "unpolished.csv", _frame(given).to_csv(index=False))
    write_aside(out / "polished.csv", _frame(paths).assign(task=np.concatenate(tasks)).to_csv(index=False))
    return Plan(then, [_pairs(path) for path in paths], places, said_of(told))


def said_of(told: dict[str, object]) -> str:
    """Return what polish gained, in words."""
    before, after, bound = (float(str(told[name])) for name in ("rms_sd_before", "rms_sd_after", "bound"))
    return (
        f"path polish: root mean square sd promised at the test points {before:.3g} → {after:.3g} "
        f"({after / before - 1:+.0%}; no tours from the depots, none longer than the longest of these, leave less than "
        f"{bound:.3g})"
    )


def _waypoints(legs: list[Floats], stray: float) -> Floats:
    """Return the waypoints of a closed reference path and its end, (w + 1, 2) [m]; none for a UAV that stays home."""
    if not legs:
        return np.empty((0, 2))
    waypoints, _ = reference_waypoints(legs, stray)
    return np.concatenate([waypoints, waypoints[:1]])


def _places(
    instance: Instance, routes: Routes, given: list[Floats], paths: list[Floats]
) -> tuple[Floats, list[list[int]]]:
    """Return the nodes with tasks where the paths now pass them, and of each waypoint the task it was, or -1."""
    assert instance.coordinates is not None
    places, tasks = np.array(instance.coordinates), [[-1] * len(path) for path in paths]
    for k, route in enumerate(routes):
        for task in route:
            at = int(np.argmin(np.hypot(*(given[k] - instance.coordinates[task]).T)))
            places[task], tasks[k][at] = paths[k][at], task
    return places, tasks


def _pairs(path: Floats) -> list[Floats]:
    return [path[i : i + 2] for i in range(len(path) - 1)]


def _frame(paths: list[Floats]) -> pd.DataFrame:
    uav = np.repeat(np.arange(len(paths)), [len(path) for path in paths])
    x, y = np.concatenate(paths).T
    return pd.DataFrame({"uav": uav, "x": x.round(3), "y": y.round(3)})
