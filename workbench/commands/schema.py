"""`workbench schema`: the JSON Schema of a file format, made from the code that validates it."""

from __future__ import annotations

import json
from pathlib import Path

import click

from instances.disk import write_aside
from instances.errors import InputError

KINDS = ("study", "scenario", "mission", "instance", "run", "all")


@click.command("schema")
@click.argument("kind", type=click.Choice(KINDS))
@click.option("--out", type=click.Path(path_type=Path), help="File to write, or with `all` the folder of all five.")
@click.option("--markdown", is_flag=True, help="Every key as tables for people instead, in Markdown.")
def command(kind: str, out: Path | None, markdown: bool) -> None:
    """Print the JSON Schema of a file format, made from the declarations that validate such files.

    Editors that know JSON Schema complete keys with it and mark what is wrong, in TOML files too. It is draft 2020-12.

    \b
    Examples:
      workbench schema scenario
      workbench schema mission --markdown
      workbench schema all --out schemas
    """
    from workbench.formats import FORMATS, json_schema
    from workbench.formats import markdown as tables

    def text(name: str) -> str:
        return tables(name) if markdown else json.dumps(json_schema(name), indent=1, ensure_ascii=False) + "\n"

    if kind != "all":
        if out is None:
            click.echo(text(kind), nl=False)
        else:
            write_aside(out, text(kind))
        return
    if out is None:
        raise InputError("schema: all five are written into a folder: give --out FOLDER")
    out.mkdir(parents=True, exist_ok=True)
    for name in FORMATS:
        write_aside(out / f"{name}.{'md' if markdown else 'schema.json'}", text(name))
