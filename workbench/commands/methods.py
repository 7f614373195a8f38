"""`workbench methods`: list the methods of placement, of moving costs, of selection and of surveys."""

from __future__ import annotations

from itertools import chain
from typing import Any

import click

from instances.errors import InputError, shown, suggestion
from workbench.completing import METHODS
from workbench.listing import described, print_described
from workbench.options import JSON
from workbench.terminal import print_json, say

HEADINGS = {"survey": 'workbench compare, problem = "survey"'}
"""What has no command of its own."""


@click.command("methods")
@click.argument("names", metavar="[METHODS]...", nargs=-1, shell_complete=METHODS)
@JSON
def command(names: tuple[str, ...], as_json: bool) -> None:
    """List METHODS (by default all) of `place`, `costs`, `select` and of survey studies with their options.

    An option is told with its default, what it means and, in brackets, what it can be. Those of other packages are
    named, but not imported; solvers of routes are listed by `workbench solvers`.

    \b
    Examples:
      workbench methods
      workbench methods nlp refined
      workbench place --tasks 12 --method nlp --option starts=4
    """
    from formulations.moving_cost.registry import METHODS as COSTS
    from formulations.selection.registry import METHODS as SELECTIONS
    from formulations.surveying.registry import PLANNERS
    from formulations.task_location.registry import METHODS as PLACES

    kinds: dict[str, Any] = {"place": PLACES, "costs": COSTS, "select": SELECTIONS, "survey": PLANNERS}
    known = set(chain.from_iterable(registry.targets() for registry in kinds.values()))
    for name in names:
        if name not in known:
            raise InputError(f"unknown method {shown(name)}{suggestion(name, known)} (workbench methods lists them)")
    found = {
        kind: {
            name: described(registry, name, about, named=False)
            for name, (_, about) in registry.targets().items()
            if not names or name in names
        }
        for kind, registry in kinds.items()
    }
    if as_json:
        print_json(found)
        return
    for kind, methods in found.items():
        if methods:
            say(HEADINGS.get(kind, f"workbench {kind} --method ..."))
        for name, told in methods.items():
            print_described(name, told, "  ")
