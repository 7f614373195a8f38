"""`workbench solve --risk`: routes chosen by what they take over an ensemble of forecasts.

The search knows the one forecast that the costs are of; its routes for `SEEDS` seeds are flown in every member, and
those of the least mean, conditional value at risk or greatest makespan are taken. Nothing is proved about others.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import click

from instances import Instance
from instances.errors import InputError
from instances.files import write_routes
from instances.wind_ensemble import Spread
from reports.record import Run
from workbench.commands.solve_told import as_object, as_text
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.problems.routing import ROUTING
from workbench.terminal import say, say_lines
from workbench.tours import spread_beside

SEEDS = 5


def run_by_risk(instance: Instance, job: Job, risk: str, *, as_json: bool, out: Path | None, beside: Path) -> bool:
    """Run the job for several seeds, print and write the routes of least risk, and return whether there are any."""
    found: list[tuple[Run, Spread]] = []
    for seed in range(job.seed, job.seed + SEEDS):
        result = run(ROUTING, replace(job, seed=seed), instance)
        routes = result.own["routes"]
        if routes is None:
            continue
        spread = spread_beside(beside, instance, routes)
        if spread is None:
            raise InputError(f"{beside}: --risk needs an ensemble: a scenario beside it whose [wind] has members")
        say(f"seed {seed}: longest tour {result.objective:.6g} s, {risk} {getattr(spread, risk):.6g} s", err=True)
        found.append((result, spread))
    if not found:
        say("no routes were found")
        return False
    best, spread = min(found, key=lambda each: getattr(each[1], risk))
    if out:
        write_routes(best.own["routes"], instance, out)
    if as_json:
        click.echo(json.dumps(as_object(best, instance) | {"ensemble": spread.to_json()}))
    else:
        say_lines("\n".join([as_text(best, instance), f"of {len(found)} seeds the least {risk}: {spread.words}"]))
    return True
