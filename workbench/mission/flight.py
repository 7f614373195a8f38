"""Stage 5, flight: Dubins tours along the reference paths (sub-problem 4), checked, and exported for ground control.

Products: flights.json, flown.csv (a pose every 0.2 s, z above mean sea level), reference.csv, flight-check.csv,
spacing.json (how many turning radii tasks lie apart), laps.json where tours are flown more than once or turned and,
where the mission has an origin, what `workbench.mission.export` writes.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from msgspec import structs
from shapely.geometry import Polygon

from formulations.mapping.clock import clocked
from formulations.mapping.flight import Flight, plan_flight
from formulations.mapping.flight_check import FlightCheck, check_flight
from formulations.mapping.heights import Heights, heights_of
from formulations.mapping.planned import planned_flight
from instances import Instance, Routes
from instances.arrays import Floats
from instances.disk import read_json, write_aside
from instances.environment.terrain import Terrain
from instances.environment.wind_changing import ChangingWind
from instances.errors import InputError
from instances.moving_cost import CostKind
from instances.paths import Paths
from instances.paths_clocked import at_their_times
from instances.routes import ENDURANCE_ROUNDING
from instances.scenario import Scenario
from instances.scenario_folder import kept_scenario, kept_terrain
from workbench.mission.costs import kept_costs
from workbench.mission.coupled import HEADINGS_FILE, kept_plan
from workbench.mission.export import export, tours_of
from workbench.mission.laps import LAPS_FILE, Laps, directed, limits_of
from workbench.mission.place import zones_of
from workbench.mission.polish import Judge, polished_plan
from workbench.mission.routes import kept_routes
from workbench.mission.safety import refuse_beyond_borders, refuse_near_ground, room_to_fly
from workbench.mission.settings import Mission
from workbench.mission.spacing import SPACING_FILE, spacing_of
from workbench.mission.turns import TurnCosts, refuse_beyond_endurance

TRACK_STEP = 0.2
"""Time between the poses of a track [s]."""
LONGEST_TOUR = 1e6
"""Longest tour [s] whose track is written."""
MOST_SAMPLES = 20_000
"""More measurements have a covariance of more than 3 GB."""


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    origin = None if mission.origin is None else asdict(mission.origin)
    own = {
        "speed": mission.speed,
        "period": mission.sensing.period,
        "origin": origin,
        "vehicle": asdict(mission.vehicle),
        "map": structs.asdict(mission.map) if mission.map.tau is not None else None,
    }
    polish = {"polish": structs.asdict(mission.place)} if mission.place.polish else {}
    return structs.asdict(mission.flight) | own | polish


@dataclass(frozen=True, eq=False)
class Fleet:
    """Flights of all UAVs, their reference paths leg by leg, and what was measured on each."""

    flights: list[Flight]
    legs: list[list[Floats]]
    checks: list[FlightCheck]


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write the flights."""
    scenario = kept_scenario(folders["environment"])
    instance, paths = kept_costs(folders["costs"])
    routes = kept_routes(folders["routes"], instance)
    if mission.flight.coupled:
        fleet, laps = fly_coupled(mission, scenario, instance, folders["routes"]), Laps(())
    else:
        fleet, laps = fly_laps(mission, scenario, instance, paths, routes)
    ground, told = kept_terrain(folders["environment"]), list(laps.said())
    if mission.place.polish:
        instance, fleet, said = _polished(Judge(mission, scenario, ground), instance, routes, fleet, out, tell)
        told.append(said)
    if isinstance(scenario.wind, ChangingWind):
        told += _by_clock(mission, scenario, instance, fleet.flights)
    refuse_beyond_borders(mission, scenario, instance, routes, fleet.flights)
    if (
        TurnCosts(mission, scenario, instance, paths, limits_of(mission, instance)).counted
        and not mission.flight.coupled
    ):
        refuse_beyond_endurance(scenario, fleet.flights, limits_of(mission, instance))
    heights = heights_flown(mission, fleet.flights, ground)
    refuse_near_ground(mission, fleet.flights, heights)
    longest = max(flight.duration for flight in fleet.flights)
    if mission.sensing.period > longest:
        raise InputError(
            f"sensing.period = {mission.sensing.period:g} s is longer than the longest tour ({longest:.0f} s), "
            "so nothing would be measured"
        )
    samples = sum(flight.duration for flight in fleet.flights) / mission.sensing.period
    if samples > MOST_SAMPLES:
        raise InputError(
            f"sensing.period = {mission.sensing.period:g} s makes {samples:.3g} samples of these tours; the map can "
            f"take {MOST_SAMPLES}"
        )
    flown = write_flights(fleet.flights, fleet.checks, heights, out)
    spacing = spacing_of(mission, scenario, instance.n_tasks)
    write_aside(out / SPACING_FILE, json.dumps(spacing))
    if not laps.plain or laps.sd is not None:
        write_aside(out / LAPS_FILE, json.dumps(laps.to_json()))
    write_aside(out / "reference.csv", _reference_frame(fleet.legs).to_csv(index=False))
    if mission.origin is not None:
        turns = mission.flight.coupled
        tours = tours_of(scenario.name, instance, routes, fleet.flights, heights, known=ground is not None, turns=turns)
        frame = mission.altitude.frame.value
        export(tours, flown, scenario, mission.origin, out, frame=frame, vehicle=mission.vehicle)
    apart = f"tasks are {spacing['ratio']:.3g} turning radii apart: {spacing['advice']}"
    return "; ".join([_said(fleet.checks), *told, _said_of_heights(heights, ground), apart])


def _by_clock(mission: Mission, scenario: Scenario, instance: Instance, flights: Sequence[Flight]) -> list[str]:
    """Return what the clock of flights in a wind that changes says; raises where it is wrong or beyond endurance."""
    from workbench.mission.clock import held, refuse_beyond_endurance, refuse_wrong_clocks  # here: it needs this file

    differ = refuse_wrong_clocks(scenario, flights)
    refuse_beyond_endurance(flights, limits_of(mission, instance))
    outlasted = held(scenario, max(flight.duration for flight in flights))
    return [f"clocks of two integrations within {differ:.2%}", *([outlasted] if outlasted else [])]


def write_flights(
    flights: Sequence[Flight], checks: Sequence[FlightCheck], heights: Mapping[int, Heights], out: Path
) -> pd.DataFrame:
    """Write flights.json, flown.csv and flight-check.csv; return the tracks (`track_frame`)."""
    write_aside(out / "flights.json", json.dumps([flight.to_json() for flight in flights]))
    flown = track_frame(flights)
    z = [heights[int(str(k))].at(flights[int(str(k))].travelled(track["time"])) for k, track in flown.groupby("uav")]
    write_aside(out / "flown.csv", flown.assign(z=np.concatenate(z).round(2)).to_csv(index=False))
    rows = [
        {"uav": k, **asdict(check), **_height_columns(heights.get(k)), "duration": flight.duration}
        for k, (check, flight) in enumerate(zip(checks, flights, strict=True))
    ]
    write_aside(out / "flight-check.csv", pd.DataFrame(rows).to_csv(index=False))
    return flown


def heights_flown(mission: Mission, flights: Sequence[Flight], ground: Terrain | None) -> dict[int, Heights]:
    """Return the heights of each UAV that flies, by its number."""
    return {k: heights_of(f, mission.altitude_at(f.fastest), ground) for k, f in enumerate(flights) if f.length > 0}


def fly_laps(
    mission: Mission, scenario: Scenario, instance: Instance, paths: Paths, routes: Routes
) -> tuple[Fleet, Laps]:
    """Return the flights on all laps, and the laps."""
    room = room_to_fly(mission, scenario)
    once = fly(mission, scenario, instance, paths, routes, room)
    laps = directed(mission, scenario, instance, routes, once.flights)
    return (once if laps.plain else fly(mission, scenario, instance, paths, routes, room, laps)), laps


def _polished(
    judge: Judge, instance: Instance, routes: Routes, fleet: Fleet, out: Path, tell: Callable[[str], None]
) -> tuple[Instance, Fleet, str]:
    """Return the instance with its tasks moved, the flights through them, and what they are worth, in words."""
    plan = polished_plan(judge, instance, routes, (fleet.flights, fleet.legs), out, tell)
    zones = zones_of(judge.scenario)
    checks = [
        check_flight(flight, legs, plan.places[list(route)], judge.scenario.region, zones)
        for flight, legs, route in zip(plan.flights, plan.legs, routes, strict=True)
    ]
    return replace(instance, coordinates=plan.places), Fleet(plan.flights, plan.legs, checks), plan.said


def fly(
    mission: Mission,
    scenario: Scenario,
    instance: Instance,
    paths: Paths,
    routes: Routes,
    within: Polygon | None = None,
    laps: Laps | None = None,
) -> Fleet:
    """Return the flights along the reference paths of `routes`, their turns `within` a polygon where they can be.

    laps : how often each route is flown and which way round, once and as it is unless given.
    """
    assert instance.coordinates is not None
    flights, legs, checks = [], [], []
    ways = [[route] for route in routes] if laps is None else laps.tours(routes)
    nodes = [_stops(instance.n_tasks + k, tours) for k, tours in enumerate(ways)]
    if isinstance(scenario.wind, ChangingWind):
        paths = at_their_times(paths, nodes, scenario.wind, mission.speed)
    for tours, stops in zip(ways, nodes, strict=True):
        reference = [paths.between(i, j) for i, j in pairwise(stops)]
        flight = plan_flight(reference, speed=mission.speed, radius=mission.flight.turning_radius, within=within)
        flight = in_wind(flight, scenario)
        if flight.duration > LONGEST_TOUR:
            raise InputError(f"flight.speed = {mission.speed:g} m/s: a tour would last {flight.duration:.3g} s")
        flights.append(flight)
        legs.append(reference)
        tasks = instance.coordinates[sorted({task for tour in tours for task in tour})]
        checks.append(check_flight(flight, reference, tasks, scenario.region, zones_of(scenario)))
    return Fleet(flights, legs, checks)


def fly_coupled(mission: Mission, scenario: Scenario, instance: Instance, planned: Path) -> Fleet:
    """Return the flights with the headings in the folder `planned`; their references are the tracks that were planned.

    InputError where a flight takes longer than its plan.
    """
    assert instance.coordinates is not None
    plan = kept_plan(planned, instance, mission, scenario)
    flights, legs, checks = [], [], []
    for uav, (route, headings) in enumerate(zip(plan.routes, plan.headings, strict=True)):
        flight, reference = planned_flight(plan.places(instance, uav), headings, plan.turns)
        if not flight.duration <= plan.times[uav] * (1 + ENDURANCE_ROUNDING):
            raise InputError(
                f"{planned / HEADINGS_FILE}: UAV {uav} flies {flight.duration!r} s, {plan.times[uav]!r} s are planned"
            )
        flights.append(flight)
        legs.append(reference)
        tasks = instance.coordinates[list(route)]
        checks.append(check_flight(flight, reference, tasks, scenario.region, zones_of(scenario)))
    return Fleet(flights, legs, checks)


def _stops(depot: int, tours: Sequence[Sequence[int]]) -> list[int]:
    """Return the nodes of a UAV's laps, from its depot to its depot; none where it stays home."""
    flown = [tour for tour in tours if tour]
    return [depot, *(stop for tour in flown for stop in (*tour, depot))] if flown else []


def in_wind(flight: Flight, scenario: Scenario) -> Flight:
    """Return `flight` as it is flown: at constant airspeed where the scenario plans by time, else over ground."""
    return flight if scenario.cost is CostKind.ENERGY or scenario.wind is None else clocked(flight, scenario.wind)


def track_frame(flights: Sequence[Flight]) -> pd.DataFrame:
    """Return a pose every TRACK_STEP of every UAV: columns uav, time [s], x [m], y [m], heading [rad]."""
    frames = []
    for k, flight in enumerate(flights):
        if flight.length == 0.0:
            continue
        times, poses = flight.track(TRACK_STEP)
        x, y, heading = poses.T
        frames.append(pd.DataFrame({"uav": k, "time": times, "x": x, "y": y, "heading": heading}).round(4))
    return pd.concat(frames, ignore_index=True)


def _reference_frame(legs: list[list[Floats]]) -> pd.DataFrame:
    rows = [
        (k, number, x, y)
        for k, reference in enumerate(legs)
        for number, leg in enumerate(reference)
        for x, y in leg.round(3).tolist()
    ]
    return pd.DataFrame(rows, columns=["uav", "leg", "x", "y"])


def _said(checks: list[FlightCheck]) -> str:
    flying = [check for check in checks if check.length > 0]
    total = sum(check.length for check in flying)
    near = max(0.0, min(check.margin for check in flying))
    return (
        f"{len(flying)} tours, {total / 1e3:.1f} km in all, the longest {max(c.length for c in flying) / 1e3:.1f} km; "
        f"every task passed within {max(c.task_distance for c in flying):.2g} m, turns of at least "
        f"{min(c.least_radius for c in flying):.1f} m, at least {near:.1f} m from borders"
    )


def _height_columns(heights: Heights | None) -> dict[str, float]:
    """Return least height above the ground, ground at the depot, lowest and highest of the track; 0 at home."""
    if heights is None:
        return dict.fromkeys(("clearance", "home", "lowest", "highest"), 0.0)
    return {
        "clearance": heights.clearance,
        "home": float(heights.ground[0]),
        "lowest": float(heights.track.min()),
        "highest": float(heights.track.max()),
    }


def _said_of_heights(heights: Mapping[int, Heights], ground: Terrain | None) -> str:
    least = min(each.clearance for each in heights.values())
    highest = max(float((each.track - each.ground).max()) for each in heights.values())
    flat = ", taken as flat at 0 m above mean sea level: no terrain is given" if ground is None else ""
    return f"{least:.0f} to {highest:.0f} m above the ground{flat}"


def kept_flights(folder: Path) -> list[Flight]:
    """Read the flights this stage wrote."""
    path = folder / "flights.json"
    flights = read_json(path)
    try:
        return [Flight.from_json(data) for data in flights]
    except (LookupError, TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{path}: holds no flights ({error})") from None
