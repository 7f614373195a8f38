"""`workbench schema`: the JSON Schema of a file format, made from the code that validates it."""

from __future__ import annotations

import json
from pathlib import Path

import click

from instances.disk import write_aside
from instances.errors import InputError
from workbench.options import JSON
from workbench.settings import make_folder
from workbench.terminal import print_json

KINDS = ("study", "scenario", "mission", "instance", "run", "all")


@click.command("schema")
@click.argument("kind", type=click.Choice(KINDS))
@click.option("--out", type=click.Path(path_type=Path), help="File to write, or with `all` the folder of all five.")
@click.option("--markdown", is_flag=True, help="Every key as tables for people instead, in Markdown.")
@JSON
def command(kind: str, out: Path | None, markdown: bool, as_json: bool) -> None:
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

    if kind == "all" and out is None and not as_json:
        raise InputError("schema: all five are written into a folder: give --out FOLDER")
    names = list(FORMATS) if kind == "all" else [kind]
    texts = {
        name: tables(name) if markdown else json.dumps(json_schema(name), indent=1, ensure_ascii=False) + "\n"
        for name in names
    }
    files = {} if out is None else dict.fromkeys(names, out)
    if kind == "all" and out is not None:
        make_folder(out)
        files = {name: out / f"{name}.{'md' if markdown else 'schema.json'}" for name in names}
    for name, file in files.items():
        write_aside(file, texts[name])
    if as_json:
        print_json({"schemas": {name: json_schema(name) for name in names}, "files": list(files.values())})
    elif out is None:
        click.echo(texts[kind], nl=False)
