"""`workbench convert`: translate between file formats."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("convert")
@click.argument("source", metavar="IN", type=click.Path(path_type=Path))
@click.argument("target", metavar="OUT", type=click.Path(path_type=Path))
def command(source: Path, target: Path) -> None:
    """Read the instance IN and write it as OUT; the endings name the formats."""
    from instances.files import read_instance, write_instance

    write_instance(read_instance(source), target)
