"""`workbench solvers`: list solvers and their options."""

from __future__ import annotations

import click

from workbench.completing import SOLVER
from workbench.listing import asked_for, described, print_described
from workbench.options import JSON
from workbench.terminal import print_json


@click.command("solvers")
@click.argument("names", metavar="[SOLVERS]...", nargs=-1, shell_complete=SOLVER)
@JSON
def command(names: tuple[str, ...], as_json: bool) -> None:
    """List SOLVERS (by default all) with their options, and why one is not available.

    An option is told with its default, what it means and, in brackets, what it can be. Those of other packages are
    imported only where you name them.

    \b
    Examples:
      workbench solvers
      workbench solvers memetic ga
      workbench solve INSTANCE --solver ga --option population=100
    """
    from formulations.routing.registry import SOLVERS

    found = {}
    for name, about in asked_for(SOLVERS, names).items():
        told = described(SOLVERS, name, about, named=bool(names))
        known = told["unavailable"] is None and (names or name in SOLVERS.built_in)
        found[name] = told | {"proves": bool(SOLVERS.load(name).proves) if known else None}
    if as_json:
        print_json(found)
        return
    for name, told in found.items():
        print_described(name, told | {"about": told["about"] + (", proves" if told["proves"] else "")})
