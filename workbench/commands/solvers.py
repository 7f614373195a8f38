"""`workbench solvers`: list solvers and their options."""

from __future__ import annotations

import json
from typing import Any

import click

from workbench.options import JSON


@click.command("solvers")
@JSON
def command(as_json: bool) -> None:
    """List the solvers with their options and defaults, and why one is not available.

    Those of other packages are named, but not imported.
    """
    from formulations.routing.registry import SOLVERS

    found = {name: _described(name, about) for name, (_, about) in SOLVERS.targets().items()}
    if as_json:
        click.echo(json.dumps(found, indent=1, default=str))
        return
    for name, solver in found.items():
        proof = ", proves" if solver["proves"] else ""
        click.echo(f"{name}: {solver['about']}{proof}")
        if solver["unavailable"]:
            click.echo(f"    not available: {solver['unavailable']}")
        for key, value in solver["options"].items():
            click.echo(f"    {key} = {json.dumps(value, default=str)}")


def _described(name: str, about: str) -> dict[str, Any]:
    from formulations.routing.registry import SOLVERS

    reason = SOLVERS.why_unavailable(name) if name in SOLVERS.built_in else None
    if reason or name not in SOLVERS.built_in:
        return {"about": about, "proves": None, "options": {}, "unavailable": reason}
    proves = bool(SOLVERS.load(name).proves)
    return {"about": about, "proves": proves, "options": SOLVERS.defaults(name), "unavailable": None}
