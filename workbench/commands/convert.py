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
    ending          what                                      in   out
    .json .json.gz  everything an instance holds              yes  yes
    .tsp            TSPLIB, costs alike in both directions    yes  yes
    .atsp           TSPLIB, costs that differ by direction    yes  yes
    .mtsp           LKH-3, which itself takes one depot       yes  yes
    .vrp            VRPLIB, several depots as in PyVRP        yes  yes
    .mdm            TSPLIB with UAVs counted at each depot    yes  no
    .txt            team orienteering: prizes and tmax        yes  no

    TSPLIB's relatives hold whole numbers: other costs are scaled, COMMENT says by how much, and reading undoes it. What
    a reader leaves out (capacities, demands, time windows) it says on stderr and in the provenance; what a format has
    no place for (UAVs that differ, endurance) is refused. Routes (.sol, .tour) number nodes as the files written here.

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
