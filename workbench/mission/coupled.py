"""Routes and headings planned together: stage 4 of a mission with `[flight] coupled`.

The nodes become states, headings at tasks and depots; a leg costs the time of its Dubins path, in a uniform wind that
of the path through the air that drifts with it, and cannot be flown where it would leave the region, enter a no-fly
zone or come nearer to either than flight.border_clearance. The mission's solver routes for the paths of stage 3 first,
which ignores turns, and its routes are given the best headings among many candidates, refined continuously. These are
states, too, and from those routes on it then routes over states. What it finds is refined likewise, and the better plan
is flown as it is.

Products beside those of `workbench.mission.routes`: headings.json (of each UAV the air headings [rad] at depot, tasks
and depot, its flight time [s], and the longest tour of each of the two plans).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from shapely.geometry import Polygon

from formulations.mapping.planned import planned_flight
from formulations.moving_cost.turns.headings import headings
from formulations.moving_cost.turns.refinement import refine
from formulations.moving_cost.turns.scenario import HeadingOptions, between_headings, steady_wind
from formulations.moving_cost.turns.tracks import legs_inside
from formulations.moving_cost.turns.travel import Turns
from formulations.routing.short_bounds import short_bounds
from formulations.routing.state_bounds import heading_bounds
from instances import Instance, Routes
from instances.arrays import Floats, Ints
from instances.disk import read_json, write_aside
from instances.errors import InputError
from instances.files import write_routes
from instances.fleet import Fleet
from instances.scenario import Scenario
from instances.scenario_folder import kept_scenario
from instances.tour_figures import line_figures
from reports.record import Run
from workbench.mission.costs import kept_costs
from workbench.mission.routes import attempt, certificate, kept_routes
from workbench.mission.safety import room_to_fly
from workbench.mission.settings import Mission

HEADINGS_FILE = "headings.json"
MANY = 60
"""More tasks have fewer headings each: legs between all states are drawn, to see which leave the region."""
FEW_STATES, MORE_STATES = HeadingOptions(8, 1, depots="own"), HeadingOptions(12, 2, depots="own")
"""Headings that routes are searched over, for many tasks and for fewer."""
FINER = 32
"""Uniform headings a stop that the routes found are given, beside those of the search and the sights along a tour."""


@dataclass(frozen=True, eq=False)
class HeadingPlan:
    """Routes, and of each UAV the headings [rad] at its stops and its flight time [s]."""

    turns: Turns
    routes: Routes
    headings: tuple[Floats, ...]
    times: tuple[float, ...]

    def places(self, instance: Instance, uav: int) -> Floats:
        """Return where a UAV takes off, its tasks and where it lands (w, 2) [m]; none where it stays home."""
        assert instance.coordinates is not None
        depot, route = instance.n_tasks + uav, self.routes[uav]
        return instance.coordinates[[depot, *route, depot] if route else []].reshape(-1, 2)

    def known(self, instance: Instance) -> tuple[Ints, Floats]:
        """Return the nodes (k,) that are flown over, and the heading of each [rad], (k,)."""
        n = instance.n_tasks
        nodes = [node for uav, route in enumerate(self.routes) if route for node in (n + uav, *route, n + uav)]
        return np.array(nodes, dtype=np.int64), np.concatenate(self.headings)


def turns_of_mission(mission: Mission, scenario: Scenario) -> Turns:
    """Return how the UAVs of a mission turn, at which speed and in which wind."""
    return Turns(mission.flight.turning_radius, mission.speed, steady_wind(scenario))


def route_coupled(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write routes and headings."""
    plain, _ = kept_costs(folders["costs"])
    scenario = kept_scenario(folders["environment"])
    turns, room = turns_of_mission(mission, scenario), room_to_fly(mission, scenario)
    if room is None:
        raise InputError(
            f"flight.border_clearance = {mission.flight.border_clearance:g} m leaves no one piece to fly in"
        )
    states, runs, plans = _planned(mission, scenario, plain, (turns, room), tell)
    found, wanted = runs["coupled"], mission.routes
    longest = {name: max(plan.times) for name, plan in plans.items()}
    by = min(longest, key=lambda name: longest[name], default="")
    if not by or not np.isfinite(longest[by]):
        raise InputError(
            f"flight.coupled: {wanted.solver} found no routes whose Dubins legs, turns of flight.turning_radius = "
            f"{turns.radius:g} m included, all stay in the region and out of no-fly zones ({found.status}: "
            f"{found.message}); leave flight.coupled out: then legs are planned around zones"
        )
    plan = plans[by]
    bounds = _bounds(plain, states, turns, longest[by], wanted.bound_time_limit)
    certified = certificate(replace(found, objective=longest[by], bound=None), bounds)
    write_routes(plan.routes, plain, out / "routes.sol")
    write_aside(out / "run.json", runs[by].to_json())
    write_aside(out / "bound.json", json.dumps(certified))
    write_aside(out / HEADINGS_FILE, json.dumps(_to_json(plan, longest, by)))
    _write_figures(scenario, plain, plan, out)
    tours = ", ".join(f"{time:.1f}" for time in plan.times)
    return (
        f"routes and headings by {found.label} ({by} plan): longest tour {longest[by]:.2f} s of flight, turns included "
        f"(tours {tours} s), at most {certified['gap']:.1%} above any possible (bound {certified['bound']:.2f} s by "
        f"{certified['by']}); {_worth(longest)}"
    )


def _planned(
    mission: Mission, scenario: Scenario, plain: Instance, flown: tuple[Turns, Polygon], tell: Callable[[str], None]
) -> tuple[Instance, dict[str, Run], dict[str, HeadingPlan]]:
    """Return the instance between headings, and runs and, of those with routes, plans, "decoupled" and "coupled"."""
    wanted, plans, also = mission.routes, {}, None
    tell(f"{wanted.solver} for {wanted.time_limit:g} s without turns")
    straight = attempt(mission, plain, wanted.time_limit, wanted.seed)
    start = straight.own["routes"]
    if start is not None:
        plans["decoupled"] = with_headings(plain, start, *flown)
        if np.isfinite(plans["decoupled"].times).all():
            also = plans["decoupled"].known(plain)
    states = _states(scenario, plain, *flown, also)
    tell(f"{wanted.solver} for {wanted.time_limit:g} s over headings")
    found = attempt(mission, states, wanted.time_limit, wanted.seed, None if also is None else start)
    if found.own["routes"] is not None:
        plans["coupled"] = with_headings(plain, found.own["routes"], *flown)
    return states, {"decoupled": straight, "coupled": found}, plans


def _states(
    scenario: Scenario, plain: Instance, turns: Turns, room: Polygon, also: tuple[Ints, Floats] | None
) -> Instance:
    """Return the instance between headings that routes are searched over, `also` among them."""
    assert plain.coordinates is not None
    n, m = plain.n_tasks, plain.n_depots
    fleet = Fleet(turning_radii=np.full(m, turns.radius))
    flown = replace(scenario, tasks=plain.coordinates[:n], n_tasks=n, speed=turns.speed, fleet=fleet)
    return between_headings(flown, FEW_STATES if n > MANY else MORE_STATES, room, also)


def with_headings(plain: Instance, routes: Routes, turns: Turns, room: Polygon) -> HeadingPlan:
    """Return routes with the best headings found; a tour that cannot be flown takes infinitely long."""
    assert plain.coordinates is not None
    options = FEW_STATES if plain.n_tasks > MANY else MORE_STATES
    searched = headings(
        plain.coordinates,
        plain.n_tasks,
        uniform=options.uniform,
        sights=options.sights,
        free_depots=False,
        drift=turns.drift,
    )
    chosen, times = [], []
    for uav, route in enumerate(routes):
        depot = plain.n_tasks + uav
        stops = [depot, *route, depot] if route else []
        if not stops:
            chosen.append(np.empty(0))
            times.append(0.0)
            continue
        places = plain.coordinates[stops]
        own = headings(places, len(places), uniform=FINER, sights=2, tangents=2, drift=turns.drift)
        candidates = [np.union1d(searched.of(stop), own.of(at)) for at, stop in enumerate(stops)]
        best = refine(candidates, legs_inside(places, turns, room))
        chosen.append(best.headings)
        times.append(best.cost)
    return HeadingPlan(turns, tuple(tuple(route) for route in routes), tuple(chosen), tuple(times))


def _bounds(plain: Instance, states: Instance, turns: Turns, upper: float, time_limit: float) -> dict[str, float]:
    """Return bounds [s] for all headings: of straight legs and, in calm air, of sectors."""
    assert plain.coordinates is not None
    times = turns.straight_times(plain.coordinates)
    lines = Instance("straight", times, plain.n_tasks, plain.n_depots, plain.coordinates)
    bounds = short_bounds(lines, upper, time_limit)
    for count, bound in heading_bounds(states, upper, time_limit):
        bounds[f"{count} sectors"] = bound
    return bounds


def _write_figures(scenario: Scenario, plain: Instance, plan: HeadingPlan, out: Path) -> None:
    rows = []
    for uav, own in enumerate(plan.headings):
        _, legs = planned_flight(plan.places(plain, uav), own, plan.turns)
        line = np.concatenate(legs) if legs else np.zeros((1, 2))
        rows.append(line_figures(line, uav, len(plan.routes[uav]), scenario.wind, plan.turns.speed))
    write_aside(out / "tours.csv", pd.DataFrame([asdict(row) for row in rows]).to_csv(index=False))


def _worth(longest: dict[str, float]) -> str:
    """Return what planning headings with the routes is worth, in words."""
    if "decoupled" not in longest or not np.isfinite(longest["decoupled"]):
        return "routes planned without turns cannot be flown as they are"
    worth = 1 - min(longest.values()) / longest["decoupled"]
    return f"planning routes without turns would take {longest['decoupled']:.2f} s ({worth:.1%} are saved)"


def _to_json(plan: HeadingPlan, longest: dict[str, float], by: str) -> dict[str, Any]:
    finite = {name: time if np.isfinite(time) else None for name, time in longest.items()}
    return {
        "headings": [own.tolist() for own in plan.headings],
        "times": list(plan.times),
        "longest": finite,
        "by": by,
    }


def kept_plan(folder: Path, instance: Instance, mission: Mission, scenario: Scenario) -> HeadingPlan:
    """Read the plan this stage wrote; InputError where it is none."""
    path, routes = folder / HEADINGS_FILE, kept_routes(folder, instance)
    said = read_json(path)
    try:
        own = tuple(np.array(each, dtype=float) for each in said["headings"])
        times = tuple(float(time) for time in said["times"])
    except (LookupError, TypeError, ValueError) as error:
        raise InputError(f"{path}: holds no headings ({error})") from None
    if [len(each) for each in own] != _stops(routes) or not all(np.isfinite(each).all() for each in own):
        raise InputError(f"{path}: headings must be numbers, one for each stop of routes.sol")
    if len(times) != len(own):
        raise InputError(f"{path}: times must be {len(own)} numbers")
    return HeadingPlan(turns_of_mission(mission, scenario), routes, own, times)


def _stops(routes: Sequence[Sequence[int]]) -> list[int]:
    return [len(route) + 2 if route else 0 for route in routes]
