"""Stage 4, routes: the min-max multi-depot multiple TSP (sub-problem 3) by a registered solver, in its own process.

Then a lower bound is sought, so that the routes carry a gap: no tours can be better by more.

Products: routes.sol, run.json, tours.csv (what each tour takes and costs along its reference path), bound.json (the
bounds found, the best of them and the gap to it).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from formulations.routing.short_bounds import short_bounds
from instances import Instance
from instances.disk import write_aside
from instances.errors import InputError
from instances.files import read_routes, write_routes
from instances.scenario_folder import kept_scenario
from instances.tour_figures import tour_figures
from reports.record import Run
from reports.tolerances import RELATIVE_ROUNDING
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.mission.costs import kept_costs
from workbench.mission.settings import Mission
from workbench.problems.routing import ROUTING


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    return asdict(mission.routes)


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write the routes."""
    instance, paths = kept_costs(folders["costs"])
    scenario = kept_scenario(folders["environment"])
    tell(f"{mission.routes.solver} for {mission.routes.time_limit:g} s")
    found = solve(mission, instance, mission.routes.time_limit, mission.routes.seed)
    assert found.objective is not None
    bounds = short_bounds(instance, found.objective, mission.routes.bound_time_limit)
    write_routes(found.own["routes"], instance, out / "routes.sol")
    write_aside(out / "run.json", found.to_json())
    certified = certificate(found, bounds)
    write_aside(out / "bound.json", json.dumps(certified))
    routes = read_routes(out / "routes.sol", instance)
    rows = tour_figures(paths, routes, instance.n_tasks, scenario.wind, scenario.speed)
    write_aside(out / "tours.csv", pd.DataFrame([asdict(row) for row in rows]).to_csv(index=False))
    tours = ", ".join(f"{c:.1f}" for c in found.own["tour_costs"])
    longest = {name: max(getattr(row, name) for row in rows) for name in ("flight_time", "energy", "calm")}
    return (
        f"{found.status} by {found.label}, longest tour {found.objective:.2f} s (tours {tours} s, {scenario.cost}), at "
        f"most {certified['gap']:.1%} above any possible (bound {certified['bound']:.2f} s by {certified['by']}); at "
        f"most {longest['flight_time']:.1f} s of flight at airspeed {scenario.speed:g} m/s, an energy cost of "
        f"{longest['energy']:.1f} s at that ground speed, {longest['calm']:.1f} s in calm air"
    )


def solve(mission: Mission, instance: Instance, time_limit: float, seed: int) -> Run:
    """Return a run of the mission's solver with routes; InputError where it found none."""
    wanted = mission.routes
    job = Job("", wanted.solver, wanted.options, seed, time_limit, wanted.threads)
    found = run(ROUTING, job, instance)
    if found.own["routes"] is None:
        raise InputError(f"routes.solver: {wanted.solver} found no routes ({found.status}: {found.message})")
    return found


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
