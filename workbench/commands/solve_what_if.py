"""`workbench solve --what-if`: what an extra UAV or battery is worth."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import click

from formulations.routing.what_if import changes, gain
from instances import Instance, as_routes
from reports.record import Run
from workbench.jobs.job import Job, folder_of
from workbench.jobs.runner import run
from workbench.problems.routing import ROUTING
from workbench.terminal import say, say_lines


def run_what_if(instance: Instance, job: Job, *, as_json: bool) -> bool:
    """Run the job, and on each change to the fleet; print what each is worth; return whether there were routes."""
    base = run(ROUTING, job, instance)
    known = None if base.own["routes"] is None else as_routes(base.own["routes"])
    told = []
    for change in changes(instance):
        again = replace(job, folder=folder_of(change.instance))
        found = run(ROUTING, again, change.instance, start=None if known is None else change.start(known))
        least, most = gain((base.objective, base.bound), (found.objective, found.bound))
        told.append({"change": change.words, "uav": change.uav} | _of(found) | {"gain_least": least, "gain_most": most})
        say(_line(told[-1], base.objective), err=True)
    about = {"instance": instance.name, "digest": instance.digest, "solver": base.solver}
    everything = about | _of(base) | {"changes": told}
    if as_json:
        click.echo(json.dumps(everything))
    else:
        longest = "no routes" if base.objective is None else f"longest tour {base.objective:.6g} s"
        say_lines("\n".join([f"as it is: {base.status}, {longest}", *(_line(row, base.objective) for row in told)]))
    return base.objective is not None


def _of(found: Run) -> dict[str, Any]:
    return {name: getattr(found, name) for name in ("status", "objective", "bound", "elapsed")}


def _line(row: dict[str, Any], before: float | None) -> str:
    if row["objective"] is None:
        return f"{row['change']}: {row['status']}, no routes"
    if before is None:
        return f"{row['change']}: {row['status']}, longest tour {row['objective']:.6g} s, where there were no routes"
    shorter = before - row["objective"]
    share = f" ({shorter / before:.1%})" if before > 0 else ""
    known = f"proved: {row['gain_least']:.6g} to {row['gain_most']:.6g} s"
    return f"{row['change']}: longest tour {row['objective']:.6g} s, {shorter:.6g} s{share} shorter ({known})"
