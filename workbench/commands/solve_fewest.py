"""`workbench solve --fewest --limit L`: how many UAVs a makespan takes."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import click

from formulations.limits import Limits
from formulations.routing.fewest_uavs import FewestUavs, fewest_uavs
from formulations.routing.recorder import RecordedSolver
from formulations.routing.registry import make_solver
from instances import Instance, tour_costs
from instances.errors import InputError, shown
from instances.files import write_routes
from workbench.jobs.job import Job
from workbench.terminal import say, say_lines


def run_fewest(
    instance: Instance,
    limit: float,
    job: Job,
    *,
    as_json: bool,
    out: Path | None,
) -> bool:
    """Ask, tell every step on stderr, write what was asked for, and return whether routes were found."""
    method = make_solver(job.method, job.options)
    if not isinstance(method, RecordedSolver):
        raise InputError(f"--solver: {shown(job.method)} cannot be ended at its first routes, which --fewest needs")
    began = time.perf_counter()
    limits = Limits(job.time_limit, job.threads, job.iterations)
    found = fewest_uavs(instance, limit, method, limits=limits, seed=job.seed, observe=_tell)
    if out is not None and found.routes is not None:
        write_routes(found.routes, instance, out)
    told = _told(instance, found) | {"solver": job.method, "elapsed": time.perf_counter() - began}
    if as_json:
        click.echo(json.dumps(told))
    else:
        say_lines(_text(told))
    return found.routes is not None


def _tell(at_least: int, fewest: int | None) -> None:
    say(f"UAVs needed: at least {at_least}, {'unknown' if fewest is None else fewest} suffice", err=True)


def _told(instance: Instance, found: FewestUavs) -> dict[str, Any]:
    costs = None if found.routes is None else tour_costs(instance, found.routes).tolist()
    return {
        "instance": instance.name,
        "digest": instance.digest,
        "status": str(found.status),
        "limit": found.limit,
        "fewest": found.fewest,
        "at_least": found.at_least,
        "uavs": list(found.uavs),
        "objective": None if costs is None else max(costs),
        "tour_costs": costs,
        "routes": found.routes,
        "decided": found.decided,
    }


def _text(told: dict[str, Any]) -> str:
    limit, m = f"{told['limit']:.6g} s", told["fewest"]
    proved = "no fewer can" if told["status"] == "OPTIMAL" else f"at least {told['at_least']} are needed"
    if told["status"] == "INFEASIBLE":
        first = f"not even all UAVs can fly all tasks within {limit}"
    elif m is None:
        first = f"no routes found; {proved} for {limit}"
    else:
        first = f"{m} UAV{'s' if m > 1 else ''} can fly all tasks within {limit}; {proved}"
    lines = [f"{told['status']}: {first}, {told['elapsed']:.2f} s"]
    routes, costs = told["routes"] or (), told["tour_costs"] or ()
    lines += [f"UAV {k}: {costs[k]:.6g} s, tasks {' '.join(map(str, routes[k]))}" for k in told["uavs"]]
    return "\n".join(lines)
