"""`workbench mission`: the paper's whole chain, from an environment to a map and a report."""

from __future__ import annotations

import time
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.completing import STAGE
from workbench.options import JSON
from workbench.terminal import print_json, say

if TYPE_CHECKING:
    from workbench.mission.template import Described


class MissionCommand(click.Command):
    """A command whose help ends with every key of a mission file."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each key with an example, what it takes and what it means."""
        from workbench.mission.template import described

        for table, keys in groupby(described(), key=lambda key: key.table):
            with formatter.section(f"Keys of [{table}]" if table else "Keys of MISSION.toml"):
                formatter.write_dl([(key.lines[0], _said(key)) for key in keys], 44)


def _said(key: Described) -> str:
    """Return what a key means and takes, and what goes with its example."""
    more = f", with {'; '.join(key.lines[1:])}" if len(key.lines) > 1 else ""
    return f"{key.meaning} ({key.wanted}){more}"


def _print_template(context: click.Context, parameter: click.Parameter, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        from workbench.mission.template import template

        click.echo(template(), nl=False)
        context.exit()


@click.command("mission", cls=MissionCommand)
@click.argument("mission_file", metavar="[MISSION.toml | NAME]", default="paper", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder of the products.")
@click.option(
    "--stage",
    metavar="STAGE",
    shell_complete=STAGE,
    help="Run only this stage, from the stored products of those before it.",
)
@click.option(
    "--from", "force_from", metavar="STAGE", shell_complete=STAGE, help="Make this stage and all after it again."
)
@click.option(
    "--template",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_template,
    help="Print a MISSION.toml with every key, commented, and exit.",
)
@click.option("--no-plugins", is_flag=True, help="Refuse a mission that names code which is not built in.")
@JSON
def command(
    mission_file: Path, out: Path, stage: str | None, force_from: str | None, no_plugins: bool, as_json: bool
) -> None:
    """Run a whole mission: environment, place, costs, routes, flight, map, compare, report.

    NAME is a mission that comes with the workbench: paper, the paper's numerical example, which is the default; or lee,
    in a wind worth planning for. Each stage keeps its products in its own folder below OUT and
    is skipped where they are up to date; the page is OUT/report.html.

    A mission that would fly beyond the region's border, into a no-fly zone or nearer to the ground than
    flight.clearance is refused (exit code 2).

    A method named module:Class is code: MISSION.toml can run whatever lies on Python's path, in a child process;
    --no-plugins refuses it.

    \b
    Examples:
      workbench mission --out runs/paper
      workbench mission lee --out runs/lee
      workbench mission mission.toml --out runs/mine --from routes
    """
    from instances.errors import InputError
    from workbench.mission.file import read_mission, shipped_missions
    from workbench.mission.fitting import refuse_plugins
    from workbench.mission.pipeline import run_mission

    if stage is not None and force_from is not None:
        raise InputError("mission: --stage and --from answer different questions; give one of them")
    began = time.perf_counter()
    mission = read_mission(shipped_missions().get(str(mission_file), mission_file))
    if no_plugins:
        refuse_plugins(mission)
    made = run_mission(mission, out, only=stage, force_from=force_from, tell=lambda words: say(words, err=True))
    elapsed, page = time.perf_counter() - began, out / "report.html"
    if as_json:
        print_json({"folder": out, "report": page if page.exists() else None, "elapsed": elapsed, "stages": made})
    else:
        click.echo(f"{page} ({elapsed:.0f} s)")
