"""`workbench init`: a commented template that runs."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import click

from instances.disk import write_aside
from instances.errors import InputError
from workbench.options import JSON
from workbench.terminal import print_json

KINDS = {"study": ".toml", "scenario": ".toml", "mission": ".toml", "solver": ".py"}
"""What there is a template of → the ending of its file."""


@click.command("init")
@click.argument("kind", type=click.Choice(list(KINDS)))
@click.argument("path", metavar="[FILE]", required=False, type=click.Path(path_type=Path))
@JSON
def command(kind: str, path: Path | None, as_json: bool) -> None:
    """Write a commented template that runs as it is: of a study, a scenario, a mission or a solver of your own.

    Its first lines say how to run it. FILE is by default my_KIND with the ending of that kind; a file that is there
    already is never overwritten.

    \b
    Examples:
      workbench init study
      workbench init mission survey.toml
    """
    target = path or Path(f"my_{kind}{KINDS[kind]}")
    if target.suffix != KINDS[kind]:
        raise InputError(f"{target}: a {kind} is a file with the ending {KINDS[kind]}")
    if kind == "solver" and not target.stem.isidentifier():
        raise InputError(f"{target}: the name of a module must be letters, digits and underscores")
    if target.exists():
        raise InputError(f"{target}: is there already and is not overwritten")
    write_aside(target, template(kind, target.stem))
    if as_json:
        print_json({"kind": kind, "file": target})
    else:
        click.echo(str(target))


def template(kind: str, name: str) -> str:
    """Return the template of a kind for a file of this name."""
    if kind == "mission":
        from workbench.mission.template import template as every_key

        return every_key()
    text = (files("workbench") / "templates" / f"{kind}{KINDS[kind]}").read_text(encoding="utf-8")
    return text.replace("{name}", name)
