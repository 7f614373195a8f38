"""`workbench watch`: a local page of a study as it runs."""

from __future__ import annotations

import os
from pathlib import Path

import click

from workbench.options import JSON, Whole
from workbench.terminal import print_json

NICE = 10
"""How far the page stands back behind the runs it watches."""


@click.command("watch")
@click.argument("folder", metavar="RUNS-DIR", type=click.Path(path_type=Path))
@click.option("--port", type=Whole(0, 65535), default=0, help="Port on 127.0.0.1.  [default: any that is free]")
@JSON
def command(folder: Path, port: int, as_json: bool) -> None:
    """Serve a page about the study in RUNS-DIR that updates itself, on 127.0.0.1 alone, until Ctrl-C.

    It runs beside `compare`, on what lies in the folder: nothing is locked or written, nobody can change anything by
    it. To see it from another machine: ssh -L 8000:127.0.0.1:8000 HOST, with --port 8000.

    \b
    Examples:
      workbench watch runs/demo
      workbench watch runs/demo --port 8000
    """
    from workbench.watching.server import PageServer
    from workbench.watching.standing import Observer

    with PageServer(Observer(folder), port) as server:
        if as_json:
            print_json({"address": server.url, "folder": folder})
        else:
            click.echo(server.url)
        os.nice(NICE)
        server.serve_forever()
