"""Stage 4, routes: the min-max multi-depot multiple TSP (sub-problem 3) by a registered solver, in its own process.

Where endurance does not suffice for all tasks on every lap, turns included (`workbench.mission.turns`), those that fit
and tell most are selected first, and the solver routes these (`workbench.mission.selection`). Then a lower bound is
sought, so that the routes carry a gap: no tours can be better by more.

Products: routes.sol, run.json, tours.csv (what each tour takes and costs along its reference path), bound.json (the
bounds found, the best of them and the gap to it), where tasks are left out selection.json, where headings are planned
with the routes headings.json (`workbench.mission.coupled`) and, where the wind is an ensemble of forecasts,
ensemble.json (with `[routes] risk` also what routes chosen without it would take: `workbench.risk`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd
from msgspec import structs

from formulations.routing.short_bounds import short_bounds
from formulations.selection.part import only
from instances import Instance, Routes, check_routes
from instances.disk import write_aside
from instances.environment.wind_changing import ChangingWind
from instances.environment.wind_forecast import Forecast
from instances.errors import InputError
from instances.files import read_routes, write_routes
from instances.paths import Paths
from instances.scenario import Scenario
from instances.scenario_folder import kept_scenario
from instances.tour_figures import TourFigures, tour_figures
from instances.wind_ensemble import Ensemble, spread
from reports.record import Run
from reports.tolerances import RELATIVE_ROUNDING
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.mission.costs import kept_costs
from workbench.mission.laps import limits_of
from workbench.mission.settings import Mission
from workbench.mission.turns import TurnCosts
from workbench.problems.routing import ROUTING

if TYPE_CHECKING:
    from workbench.mission.selection import Chosen
    from workbench.risk import LeastRisk

SELECTION_FILE = "selection.json"
ENSEMBLE_FILE = "ensemble.json"
TRIES = 5
"""Times that tours are routed, at most, until their turns fit within endurance, too."""


class Routed(NamedTuple):
    """Routes within endurance: their run; the tasks chosen, where not all fit; of an ensemble, those of least risk."""

    run: Run
    selection: Chosen | None
    least: LeastRisk | None


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    own = structs.asdict(mission.routes)
    if mission.routes.risk is None:
        del own["risk"]  # products of missions without it stay
    flown = mission.flight
    if flown.coupled:
        own |= {"coupled": [mission.speed, flown.turning_radius, flown.border_clearance]}
    if flown.endurance is None and flown.laps == 1 and mission.scenario.fleet.endurance is None:
        return own
    own |= {"turns": [mission.speed, flown.turning_radius, flown.border_clearance]}
    return own | {"endurance": flown.endurance, "laps": flown.laps, "place": structs.asdict(mission.place)}


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write the routes."""
    if mission.flight.coupled:
        from workbench.mission.coupled import route_coupled  # here: most missions need none of it

        return route_coupled(mission, folders, out, tell)
    instance, paths = kept_costs(folders["costs"])
    scenario = kept_scenario(folders["environment"])
    tell(f"{mission.routes.solver} for {mission.routes.time_limit:g} s")
    routed = _routed(mission, scenario, instance, paths, tell)
    found, chosen = routed.run, routed.selection
    assert found.objective is not None
    visited = sorted(task for route in found.own["routes"] for task in route)
    part = instance if chosen is None else only(instance, visited)
    certified = certificate(found, short_bounds(part, found.objective, mission.routes.bound_time_limit))
    if chosen is not None:
        write_aside(out / SELECTION_FILE, chosen.text)
    write_routes(found.own["routes"], instance, out / "routes.sol", all_tasks=chosen is None)
    write_aside(out / "run.json", found.to_json())
    write_aside(out / "bound.json", json.dumps(certified))
    routes = kept_routes(out, instance)
    rows = tour_figures(paths, routes, instance.n_tasks, scenario.wind, scenario.speed)
    over = spread(paths, routes, instance.n_tasks, scenario.wind, scenario.speed)
    if over is not None:
        without = {}
        if routed.least is not None:
            without = {"risk": mission.routes.risk, "without": routed.least.alone[1].to_json()}
        write_aside(out / ENSEMBLE_FILE, json.dumps(over.to_json() | without))
    write_aside(out / "tours.csv", pd.DataFrame([asdict(row) for row in rows]).to_csv(index=False))
    notes = [*([chosen.said] if chosen else []), *([over.words] if over else [])]
    return "; ".join([_said(found, certified, rows, scenario), *notes])


def _routed(
    mission: Mission, scenario: Scenario, instance: Instance, paths: Paths, tell: Callable[[str], None]
) -> Routed:
    """Return routes whose turns, too, fit within endurance; InputError where there are none."""
    laps = mission.flight.laps if isinstance(mission.flight.laps, int) else 1
    limits = limits_of(mission, instance) / laps
    if laps > 1 and instance.endurance is not None:
        instance = replace(instance, endurance=limits)
    turns = TurnCosts(mission, scenario, instance, paths, limits)
    least: LeastRisk | None = None
    if mission.routes.risk is None:
        whole = attempt(mission, instance, mission.routes.time_limit, mission.routes.seed)
    else:
        limited = instance if np.isinf(limits).all() else replace(instance, endurance=limits)
        least = _of_least_risk(mission, limited, scenario, paths, tell)
        whole = least.best[0]
    for _ in range(TRIES):
        found, selection = whole, None
        if not flies_all(replace(instance, endurance=limits), whole):
            if "time" in instance.axes:
                raise InputError(
                    "flight.endurance: no routes past all tasks within it were found, and to choose among tasks the "
                    "wind must stay: give more, or fewer tasks"
                )
            from workbench.mission.selection import route_what_fits  # here: most missions need none of it

            found, selection = route_what_fits(mission, instance, limits, tell)
        if not turns.counted or (limits == (limits := turns.left_for_legs(found.own["routes"], limits))).all():
            break
    return Routed(found, selection, least)


def _said(found: Run, certified: dict[str, Any], rows: Sequence[TourFigures], scenario: Scenario) -> str:
    """Return what the screen says of the routes: their tours, how good they are, and what they take of time."""
    tours = ", ".join(f"{c:.1f}" for c in found.own["tour_costs"])
    longest = {name: max(getattr(row, name) for row in rows) for name in ("flight_time", "energy", "calm")}
    energy = f"an energy cost of {longest['energy']:.1f} s at that ground speed, "
    by_clock = isinstance(scenario.wind, ChangingWind)
    return (
        f"{found.status} by {found.label}, longest tour {found.objective:.2f} s (tours {tours} s, {scenario.cost}), at "
        f"most {certified['gap']:.1%} above any possible (bound {certified['bound']:.2f} s by {certified['by']}); at "
        f"most {longest['flight_time']:.1f} s of flight at airspeed {scenario.speed:g} m/s, "
        f"{'' if by_clock else energy}{longest['calm']:.1f} s in calm air"
    )


def _of_least_risk(
    mission: Mission, instance: Instance, scenario: Scenario, paths: Paths, tell: Callable[[str], None]
) -> LeastRisk:
    """Return the routes of least risk over the ensemble; InputError where there are none, or no ensemble."""
    from workbench.risk import least_risk  # here: most missions need none of it

    assert isinstance(scenario.wind, Forecast)  # see `check_mission`
    risk = str(mission.routes.risk)
    found = least_risk(instance, _job(mission), risk, Ensemble(paths, scenario.wind, scenario.speed), tell)
    if found is None:
        raise InputError(f"routes.solver: {mission.routes.solver} found no routes that could be judged by their {risk}")
    return found


def flies_all(instance: Instance, found: Run) -> bool:
    """Say whether a run's routes are ones that the UAVs of `instance` can fly; InputError where it had to have some."""
    routes = found.own["routes"]
    if routes is None and instance.endurance is None:
        raise InputError(f"routes.solver: {found.label} found no routes ({found.status}: {found.message})")
    return routes is not None and not check_routes(instance, routes)


def solve(mission: Mission, instance: Instance, time_limit: float, seed: int) -> Run:
    """Return a run of the mission's solver with routes; InputError where it found none."""
    found = attempt(mission, instance, time_limit, seed)
    if found.own["routes"] is None:
        raise InputError(f"routes.solver: {mission.routes.solver} found no routes ({found.status}: {found.message})")
    return found


def attempt(mission: Mission, instance: Instance, time_limit: float, seed: int, start: Routes | None = None) -> Run:
    """Return a run of the mission's solver, with or without routes."""
    job = replace(_job(mission), seed=seed, time_limit=time_limit)
    return run(ROUTING, job, instance, start=start)


def _job(mission: Mission) -> Job:
    """Return the job of the mission's solver."""
    wanted = mission.routes
    return Job("", wanted.solver, wanted.options, wanted.seed, wanted.time_limit, wanted.threads)


def certificate(found: Run, bounds: dict[str, float]) -> dict[str, Any]:
    """Return objective, best bound, its name, the gap and all bounds; InputError where one contradicts the routes."""
    assert found.objective is not None
    known = bounds | ({found.label: found.bound} if found.bound is not None else {})
    by = max(known, key=lambda name: known[name])
    bound, objective = known[by], found.objective
    if bound > objective * (1 + RELATIVE_ROUNDING):
        raise InputError(f"routes: {by} claims that no tours are below {bound!r} s, but {objective!r} s were flown")
    gap = max(0.0, objective - bound) / objective if objective > 0 else 0.0
    return {"objective": objective, "bound": bound, "by": by, "gap": gap, "bounds": known}


def kept_routes(folder: Path, instance: Instance) -> Routes:
    """Read the routes this stage wrote; where it made a selection, they leave tasks out."""
    return read_routes(folder / "routes.sol", instance, all_tasks=not (folder / SELECTION_FILE).exists())
