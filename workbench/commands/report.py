"""`workbench report`: make pages and tables from stored runs; compare with an older store."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from instances.errors import InputError
from workbench.options import COLUMNS, JSON

FILE = click.Path(path_type=Path, dir_okay=False)


@click.command("report")
@click.argument("folders", metavar="RUNS-DIR...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", type=FILE, help="The page (.html).")
@click.option("--csv", type=FILE, help="A row a run; texts that begin like a formula (= + - @) get an apostrophe.")
@click.option("--raw-csv", is_flag=True, help="With --csv: all texts as they are.")
@click.option("--latex", type=FILE, help="Summary and instances as LaTeX tables.")
@click.option("--markdown", type=FILE, help="Summary and instances as Markdown tables.")
@click.option("--parquet", type=FILE, help="A row a run.")
@click.option(
    "--figures",
    metavar="FOLDER",
    type=click.Path(path_type=Path, file_okay=False),
    help="Every figure as PDF and SVG, its values as CSV: FOLDER/KEY.pdf and so on.",
)
@click.option("--against", type=click.Path(path_type=Path), help="An older store: better, worse or unchanged?")
@click.option("--fail-on-regression", is_flag=True, help="With --against: exit code 1 where something got worse.")
@COLUMNS
@JSON
@click.pass_context
def command(
    context: click.Context,
    /,
    folders: tuple[Path, ...],
    out: Path | None,
    csv: Path | None,
    raw_csv: bool,
    fail_on_regression: bool,
    columns: list[str],
    as_json: bool,
    **more: Any,
) -> None:
    """Report on the runs of one store or several merged, without running anything; prints the summary.

    Each problem has a page and a table of its own: where the stores hold several, OUT-placement.html and
    CSV-placement.csv lie beside those of routing runs. Exit code 1 where files are damaged (they are named and left
    out), and where --against finds nothing in common.

    \b
    Examples:
      workbench report runs/quick --out report.html --csv results.csv
      workbench report runs/quick --columns gap_found,time,memory
      workbench report runs/new --against runs/old --fail-on-regression
    """
    from reports import numbers
    from reports.stores import problems_in
    from workbench.jobs.problem import Outputs
    from workbench.publish import publish, refuse_columns, tell, told
    from workbench.settings import check_target
    from workbench.terminal import print_json, say

    if fail_on_regression and more["against"] is None:
        raise InputError("--fail-on-regression: needs --against OLD")
    outputs = {flag: path for flag, path in more.items() if path}
    for path in (out, csv, *(outputs[flag] for flag in outputs if flag not in ("against", "figures"))):
        check_target(path)
    refuse_columns(problems_in(*folders), columns)
    published = publish(folders, Outputs(out, csv, outputs, raw_csv))
    if as_json:
        named = ("damaged", "regressed", "comparable")
        print_json(told(published) | {name: getattr(published, name) for name in named})
    else:
        tell(published, columns)
    for sentence in published.problems:
        say(sentence, err=True)
    if published.damaged:
        say(f"{numbers.counted(published.damaged, 'damaged file')} left out", err=True)
    failed = not published.comparable or (fail_on_regression and published.regressed)
    context.exit(1 if published.damaged or failed else 0)
