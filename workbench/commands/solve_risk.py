"""`workbench solve --risk`: the routes of least risk over an ensemble (`workbench.risk`), printed and written."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import click

from instances import Instance
from instances.errors import InputError
from instances.files import write_routes
from instances.wind_ensemble import Ensemble
from workbench.commands.solve_told import as_object, as_text
from workbench.jobs.job import Job
from workbench.risk import least_risk
from workbench.terminal import say, say_lines
from workbench.tours import planned_beside


def run_by_risk(instance: Instance, job: Job, risk: str, *, as_json: bool, out: Path | None, beside: Path) -> bool:
    """Search, print and write the routes of least risk, within the job's limit in all; return whether there are any."""
    if "window" in instance.axes:
        raise InputError(f"{beside}: --risk flies members from take-off at once, and travel.window lets UAVs wait")
    found = least_risk(instance, job, risk, _ensemble(instance, beside), partial(say, err=True))
    if found is None:
        say("no routes were found")
        return False
    (best, over), (_, chosen) = found.best, found.chosen
    if out:
        write_routes(best.own["routes"], instance, out)
    if as_json:
        click.echo(json.dumps(as_object(best, instance) | {"ensemble": over.to_json(), "chosen": chosen.to_json()}))
    else:
        first = f"of {found.seeds} seeds the least {risk}: {getattr(chosen, risk):.6g} s; with the search "
        say_lines("\n".join([as_text(best, instance), f"{first}{getattr(over, risk):.6g} s: {over.words}"]))
    return True


def _ensemble(instance: Instance, beside: Path) -> Ensemble:
    """Return the paths beside an instance, their wind that has members, and the speed; InputError without."""
    ensemble = Ensemble.of(*planned_beside(beside, instance))
    if ensemble is None:
        raise InputError(f"{beside}: --risk needs an ensemble: a scenario beside it whose [wind] has members")
    return ensemble
