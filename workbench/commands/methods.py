"""`workbench methods`: list the methods of placement and of moving costs."""

from __future__ import annotations

import json
from typing import Any

import click

from workbench.options import JSON


@click.command("methods")
@JSON
def command(as_json: bool) -> None:
    """List the methods of `place` (task locations) and of `costs` (moving costs), with their options and defaults.

    Those of other packages are named, but not imported; solvers of routes are listed by `workbench solvers`.
    """
    from formulations.moving_cost.registry import METHODS as COSTS
    from formulations.task_location.registry import METHODS as PLACES

    found: dict[str, dict[str, Any]] = {
        kind: {
            name: {"about": about, "options": registry.defaults(name) if name in registry.built_in else {}}
            for name, (_, about) in registry.targets().items()
        }
        for kind, registry in (("place", PLACES), ("costs", COSTS))
    }
    if as_json:
        click.echo(json.dumps(found, indent=1, default=str))
        return
    for kind, methods in found.items():
        click.echo(f"workbench {kind} --method ...")
        for name, method in methods.items():
            click.echo(f"  {name}: {method['about']}")
            for key, value in method["options"].items():
                click.echo(f"      {key} = {json.dumps(value, default=str)}")
