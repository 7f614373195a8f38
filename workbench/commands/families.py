"""`workbench families`: list instance families and their parameters."""

from __future__ import annotations

import json

import click


@click.command("families")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(as_json: bool) -> None:
    """List the generator families with their parameters and defaults."""
    from instances.families import FAMILIES

    found = {
        name: {
            "about": about,
            "parameters": {
                p.name: {"default": p.default, "unit": p.unit, "meaning": p.meaning, "choices": list(p.choices)}
                for p in FAMILIES.load(name).parameters
            },
        }
        for name, (_, about) in FAMILIES.targets().items()
    }
    if as_json:
        click.echo(json.dumps(found, indent=1))
        return
    for name, family in found.items():
        click.echo(f"{name}: {family['about']}")
        for p in FAMILIES.load(name).parameters:
            unit = f" [{p.unit}]" if p.unit else ""
            choices = f" ({', '.join(p.choices)})" if p.choices else ""
            click.echo(f"    {p.name} = {json.dumps(p.default)}{unit}: {p.meaning}{choices}")
