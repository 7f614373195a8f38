"""`workbench families`: list instance families and their parameters."""

from __future__ import annotations

import json
import math
from typing import Any

import click

from workbench.completing import FAMILY
from workbench.listing import asked_for
from workbench.options import JSON
from workbench.terminal import print_json, say


@click.command("families")
@click.argument("names", metavar="[FAMILIES]...", nargs=-1, shell_complete=FAMILY)
@JSON
def command(names: tuple[str, ...], as_json: bool) -> None:
    """List the generator FAMILIES (by default all) with their parameters.

    A parameter is told with its default, its unit, what it means and, in brackets, what it can be. Those of other
    packages are imported only where you name them.

    \b
    Examples:
      workbench families
      workbench families wind-vortices
      workbench generate wind-vortices --tasks 12 --set vortices=2
    """
    from instances.families import FAMILIES

    found: dict[str, dict[str, Any]] = {
        name: {"about": about, "parameters": _parameters(name) if names or name in FAMILIES.built_in else {}}
        for name, about in asked_for(FAMILIES, names).items()
    }
    if as_json:
        print_json(found)
        return
    for name, family in found.items():
        say(f"{name}: {family['about']}")
        for parameter, p in family["parameters"].items():
            unit = f" [{p['unit']}]" if p["unit"] else ""
            least = "" if p["at_least"] is None else f" (at least {p['at_least']:g})"
            values = f" ({', '.join(p['choices'])})" if p["choices"] else least
            say(f"    {parameter} = {json.dumps(p['default'])}{unit}: {p['meaning']}{values}")


def _parameters(name: str) -> dict[str, dict[str, Any]]:
    from instances.families import FAMILIES

    return {
        p.name: {
            "default": p.default,
            "unit": p.unit,
            "meaning": p.meaning,
            "choices": list(p.choices),
            "at_least": p.at_least if math.isfinite(p.at_least) else None,
        }
        for p in FAMILIES.load(name).parameters
    }
