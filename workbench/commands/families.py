"""`workbench families`: list instance families and their parameters."""

from __future__ import annotations

import json

import click


@click.command("families")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(as_json: bool) -> None:
    """List the generator families with their parameters and defaults."""
    from workbench.making import families

    found = families()
    if as_json:
        click.echo(json.dumps(found, indent=1))
        return
    for name, family in found.items():
        click.echo(f"{name}: {family['about']}")
        for key, parameter in family["parameters"].items():
            unit = f" [{parameter['unit']}]" if parameter["unit"] else ""
            choices = f" ({', '.join(parameter['choices'])})" if parameter["choices"] else ""
            click.echo(f"    {key} = {json.dumps(parameter['default'])}{unit}: {parameter['meaning']}{choices}")
