"""`workbench families`: list instance families and their parameters."""

from __future__ import annotations

import json
from typing import Any

import click

from workbench.options import JSON


@click.command("families")
@JSON
def command(as_json: bool) -> None:
    """List the generator families with their parameters and defaults.

    Those of other packages are named, but not imported.
    """
    from instances.families import FAMILIES

    abouts = {name: about for name, (_, about) in FAMILIES.targets().items()}
    if as_json:
        found = {name: {"about": about, "parameters": _parameters(name)} for name, about in abouts.items()}
        click.echo(json.dumps(found, indent=1))
        return
    for name, about in abouts.items():
        click.echo(f"{name}: {about}")
        for parameter, p in _parameters(name).items():
            unit = f" [{p['unit']}]" if p["unit"] else ""
            choices = f" ({', '.join(p['choices'])})" if p["choices"] else ""
            click.echo(f"    {parameter} = {json.dumps(p['default'])}{unit}: {p['meaning']}{choices}")


def _parameters(name: str) -> dict[str, dict[str, Any]]:
    from instances.families import FAMILIES

    return {
        p.name: {"default": p.default, "unit": p.unit, "meaning": p.meaning, "choices": list(p.choices)}
        for p in (FAMILIES.load(name).parameters if name in FAMILIES.built_in else ())
    }
