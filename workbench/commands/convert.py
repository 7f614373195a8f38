"""`workbench convert`: translate between file formats."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.options import JSON
from workbench.terminal import print_json


@click.command("convert")
@click.argument("source", metavar="IN", type=click.Path(path_type=Path))
@click.argument("target", metavar="OUT", type=click.Path(path_type=Path))
@JSON
def command(source: Path, target: Path, as_json: bool) -> None:
    """Read the instance IN and write it as OUT; the endings name the formats.

    \b
    Examples:
      workbench convert berlin52.mtsp berlin52.json
      workbench convert a.json a.vrp
    """
    from instances.files import read_instance, write_instance

    instance = read_instance(source)
    write_instance(instance, target)
    if as_json:
        print_json({"source": source, "file": target, **instance.about()})
