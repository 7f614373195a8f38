"""Stage 4, routes: the min-max multi-depot multiple TSP (sub-problem 3) by a registered solver, in its own process.

Products: routes.sol, run.json.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from instances import Instance
from instances.disk import write_aside
from instances.errors import InputError
from instances.files import write_routes
from reports.record import Run
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
    instance, _ = kept_costs(folders["costs"])
    tell(f"{mission.routes.solver} for {mission.routes.time_limit:g} s")
    found = solve(mission, instance, mission.routes.time_limit, mission.routes.seed)
    write_routes(found.own["routes"], instance, out / "routes.sol")
    write_aside(out / "run.json", found.to_json())
    tours = ", ".join(f"{c:.1f}" for c in found.own["tour_costs"])
    return f"{found.status} by {found.label}, longest tour {found.objective:.2f} s (tours {tours} s)"


def solve(mission: Mission, instance: Instance, time_limit: float, seed: int) -> Run:
    """Return a run of the mission's solver with routes; InputError where it found none."""
    wanted = mission.routes
    job = Job("", wanted.solver, wanted.options, seed, time_limit, wanted.threads)
    found = run(ROUTING, job, instance)
    if found.own["routes"] is None:
        raise InputError(f"routes.solver: {wanted.solver} found no routes ({found.status}: {found.message})")
    return found
