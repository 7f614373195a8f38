"""Re-planning of a mission in flight, from the plan at take-off, which the flight stage made and exported.

Each plan is within the endurance of each UAV, counted along the track, turns included; where the mission gives none, no
UAV spends more than the longest tour at take-off. What may be flown is said by the rules that the mission's flights are
refused by: of borders and zones for what is still to be flown, of heights for the whole flight from the depot on.

Products, in the folder of the map: replans.json, and flights.json, flown.csv and flight-check.csv as they were flown in
the end; there the reference path is the polyline of the waypoints that were flown. Where the mission has an origin,
what `workbench.mission.export` writes, too, but for lost UAVs and for flights that passed what is closed now.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from formulations.kernel import SquaredExponential
from formulations.mapping.flight import Flight
from formulations.mapping.flight_check import FlightCheck, check_flight
from formulations.mapping.heights import Heights
from formulations.mapping.map_model import MapModel
from formulations.mapping.survey import Drifting, Field
from formulations.replanning.aloft import Allowed, Aloft, World
from formulations.replanning.in_flight import Event, drawn, fly_replanned
from formulations.replanning.replan import Planner, Replan
from formulations.replanning.spending import track_cost
from formulations.replanning.ways import Ways
from formulations.task_location.criterion import Convention
from formulations.task_location.variance_reduction import NAME
from instances.arrays import Floats
from instances.disk import read_text, write_aside
from instances.environment.terrain import Terrain
from instances.errors import InputError
from instances.scenario import Scenario
from instances.scenario_folder import kept_scenario, kept_terrain
from reports.numbers import counted
from workbench.mission.baselines import beyond, too_low
from workbench.mission.belief import belief_of, known_tau, map_kernel
from workbench.mission.events import scenarios_after, words_of
from workbench.mission.export import export, tour_of
from workbench.mission.flight import heights_flown, kept_flights, write_flights
from workbench.mission.place import criterion_of, kept_off, widened, zones_of
from workbench.mission.safety import room_to_fly
from workbench.mission.settings import Mission
from workbench.mission.turns import measure_of


@dataclass(frozen=True, eq=False)
class Flown:
    """Flights as they were flown in the end, the fleet that flew them, and the re-plans."""

    flights: list[Flight]
    fleet: Aloft
    replans: list[Replan]


class Replanning:
    """Flies a mission from take-off; `folders` are those of its stages."""

    def __init__(self, mission: Mission, folders: dict[str, Path]) -> None:
        self.mission = mission
        self.scenario, self.ground = kept_scenario(folders["environment"]), kept_terrain(folders["environment"])
        self.plan = kept_flights(folders["flight"])
        self.tasks = _tasks(folders["flight"], self.scenario.depots)
        self.world = world_of(mission, self.scenario, self.ground)
        self.events = [
            Event(event.time, words_of(event), event.uav, None if event.kind == "lost-uav" else self._world(after))
            for event, after in scenarios_after(mission, self.scenario)
        ]
        belief = belief_of(mission, folders["environment"])
        wanted = criterion_of(mission, self.scenario.region).under(Convention.BOTH_NOISY)
        self.planner = Planner(
            MapModel(map_kernel(mission, SquaredExponential), tau=known_tau(mission)),
            mission.sensing.noise_sd,
            mission.sensing.period,
            wanted.tests,
            wanted.tests,
            wanted.weights,
            wanted.weights,
            mission.place.criterion == NAME,
            replace(belief.offered, kernels=(SquaredExponential,)),
            polish=mission.place.polish,
        )
        costs = np.array([track_cost(flight, self.world.measure) for flight in self.plan])
        given = self.scenario.fleet.endurance
        endurance = np.full(len(costs), math.inf) if given is None else given
        endurance = np.minimum(endurance, mission.flight.endurance or math.inf)
        self.budgets: Floats = np.where(np.isfinite(endurance), endurance, costs.max())
        self.endurance_given = bool(np.isfinite(endurance).all())

    def _world(self, scenario: Scenario) -> World:
        return world_of(self.mission, scenario, self.ground)

    def flown(self, field: Field | Drifting, seed: int) -> Flown:
        """Fly and re-plan over `field`, the noise drawn by `seed`."""
        fleet = Aloft(list(self.plan), list(self.tasks), self.scenario.depots, self.budgets)
        every = self.mission.replan.every or 0
        read = drawn(field, self.planner.noise_sd, self.planner.period, seed)
        flights, made = fly_replanned(fleet, read, self.planner, self.world, every=every, events=self.events)
        if max(flight.duration for flight in flights) < self.planner.period:
            raise InputError("replan.event: all UAVs are lost before anything is measured")
        return Flown(flights, fleet, made)

    def write(self, flown: Flown, out: Path) -> str:
        """Write the products; return what was changed, in words."""
        heights = heights_flown(self.mission, flown.flights, self.ground)
        tracks = write_flights(flown.flights, self._checks(flown), heights, out)
        self._export(flown, heights, tracks, out)
        landed = max(flight.duration for flight in flown.flights)
        told: dict[str, Any] = {
            "every": self.mission.replan.every,
            "budgets": self.budgets.tolist(),
            "endurance_given": self.endurance_given,
            "late": [f"{event.words} at {event.time:g} s" for event in self.events if event.time >= landed],
            "replans": [_row(replan) for replan in flown.replans],
        }
        write_aside(out / "replans.json", json.dumps(told, indent=1))
        accepted = sum(replan.accepted for replan in flown.replans)
        late = "".join(f"; after the last landing: {words}" for words in told["late"])
        return f"{counted(len(flown.replans), 're-plan')}, {accepted} accepted{late}"

    def _export(self, flown: Flown, heights: Mapping[int, Heights], tracks: pd.DataFrame, out: Path) -> None:
        """Write the flights as flown in the end for ground control, those that may be flown so again."""
        mission, landed = self.mission, max(flight.duration for flight in flown.flights)
        if mission.origin is None:
            return
        now = self.scenario
        for event, after in scenarios_after(mission, self.scenario):
            now = after if event.time < landed else now
        without = dict.fromkeys(sorted(flown.fleet.lost), "no plan: it is lost")
        for k in heights.keys() - flown.fleet.lost:
            if why := beyond(mission, now, flown.flights[k]):
                without[k] = f"no plan: flown again, it would {why}"
        name, known = self.scenario.name, self.ground is not None
        tours = {
            k: tour_of(f"{name} UAV {k}, as flown", flown.flights[k], own, {}, known=known)
            for k, own in heights.items()
            if k not in without
        }
        frame = mission.altitude.frame.value
        export(tours, tracks, now, mission.origin, out, frame=frame, vehicle=mission.vehicle, without=without)

    def _checks(self, flown: Flown) -> list[FlightCheck]:
        scenario, fleet = self.scenario, flown.fleet
        return [
            check_flight(
                flight, [_line(flight)], np.empty((0, 2)) if k in fleet.lost else tasks, scenario.region,
                zones_of(scenario),
            )
            for k, (flight, tasks) in enumerate(zip(flown.flights, fleet.tasks, strict=True))
        ]  # fmt: skip


def world_of(mission: Mission, scenario: Scenario, ground: Terrain | None) -> World:
    """Return what holds for flights of a mission while `scenario` does."""
    free = widened(scenario, mission.clearance).free
    sites = kept_off(free, scenario.region, mission.clearance) or free
    ways = Ways(free, measure_of(scenario))
    return World(ways, sites, room_to_fly(mission, scenario), rules_of(mission, scenario, ground))


def rules_of(mission: Mission, scenario: Scenario, ground: Terrain | None) -> Allowed:
    """Return what says why nobody may fly on so, by the rules that a mission's own flights are refused by."""

    def allowed(flights: Sequence[Flight], rests: Sequence[Flight]) -> str:
        for uav, (flight, rest) in enumerate(zip(flights, rests, strict=True)):
            if rest.length == 0.0:
                continue
            why = beyond(mission, scenario, rest)
            if why := why or too_low(mission, mission.altitude_at(flight.fastest), ground, flight):
                return f"UAV {uav} would {why}"
        return ""

    return allowed


def _tasks(folder: Path, depots: Floats) -> list[Floats]:
    """Return the tasks (k, 2) [m] of each UAV at take-off: where polish moved them, or else the ends of its legs."""
    polished = folder / "polished.csv"
    if polished.exists():
        table = pd.read_csv(io.StringIO(read_text(polished)))
        kept = table[table["task"] >= 0]
    else:
        table = pd.read_csv(io.StringIO(read_text(folder / "reference.csv")))
        kept = table.groupby(["uav", "leg"], as_index=False).last().drop_duplicates(["uav", "x", "y"])  # of all laps
    places = [kept.loc[kept["uav"] == k, ["x", "y"]].to_numpy(dtype=float) for k in range(len(depots))]
    home = 1e-3  # to which files are rounded
    return [own[np.abs(own - depot).max(axis=1) > home] for own, depot in zip(places, depots, strict=True)]


def _line(flight: Flight) -> Floats:
    """Return the waypoints that were flown, and the end, (k, 2) [m]."""
    if not len(flight.starts):
        return np.empty((0, 2))
    return np.concatenate([flight.starts[:, :2], flight.poses(flight.length)[:, :2]])


def _row(replan: Replan) -> dict[str, Any]:
    """Return a re-plan as JSON values; sd_before and sd_after are null where no such plan may be flown."""
    kernel = replan.model.kernel
    before, after = (None if math.isnan(value) else math.sqrt(value) for value in (replan.before, replan.after))
    return {
        "time": replan.time,
        "reason": replan.reason,
        "samples": replan.samples,
        "signal_sd": kernel.signal_sd,
        "length_scales": list(kernel.length_scales),
        "sd_before": before,
        "sd_after": after,
        "accepted": replan.accepted,
        "why": replan.why,
        "tried": [[count, words] for count, words in replan.tried],
        "left_before": [flight.length for flight in replan.old],
        "left_after": [flight.length for flight in replan.new],
        "elapsed": round(replan.elapsed, 3),
        **({"tau": replan.model.tau} if replan.model.tau < math.inf else {}),
    }
