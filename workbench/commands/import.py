"""`workbench import`: results of others' programs as foreign runs of a store."""

# ruff: noqa: N999 - the command is called so, and nobody imports it by a statement

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from workbench.options import JSON, SECONDS, SEED, THREADS, Whole


@click.command("import")
@click.argument("results", type=click.Path(path_type=Path))
@click.option("--into", required=True, metavar="RUNS-DIR", type=click.Path(path_type=Path), help="Store of the runs.")
@click.option("--instance", help="Name or digest of an instance in RUNS-DIR, or a file.")
@click.option("--solver", help="Name of the program that found it.")
@click.option("--elapsed", help="Seconds it took.")
@click.option("--time-limit", type=SECONDS, help="Seconds it was allowed.")
@click.option("--seed", type=SEED, help="Its seed.  [default: 0]")
@click.option("--threads", type=THREADS, help="Its threads.  [default: 1]")
@click.option("--machine", help="Where it ran, in words.  [default: elsewhere]")
@click.option(
    "--first-task", type=Whole(0, 1), default=0, show_default=True, help="Number of the first task in lists of tasks."
)
@JSON
@click.pass_context
def command(
    context: click.Context, /, results: Path, into: Path, first_task: int, as_json: bool, **settled: Any
) -> None:
    """Import RESULTS (.csv, .parquet, or one .sol) of other programs into a store, all rows or none.

    \b
    Columns of a table (an option gives what it has no column for):
      instance    name or digest of an instance in RUNS-DIR, or a file
      solver      name of the program
      elapsed     seconds it took
      time_limit  seconds it was allowed
      seed, threads, machine
      routes      [[tasks of the first UAV], ...], text or file of a .sol
      objective, bound   the longest tour and lower bound it claims [s]

    Routes are checked and costed as those of every solver; a claim they do not bear out is stored as ERROR, and the
    exit code is 1. What is imported carries a † wherever it is named: its times were measured elsewhere. A value
    without routes is kept as claimed and is not ranked; a bound is a claim that routes of all solvers may refute.

    \b
    Examples:
      workbench import lkh.csv --into runs/mine
      workbench import a.sol --into b --solver LKH --elapsed 9 --time-limit 60
      workbench report runs/mine --out report.html
    """
    from reports.numbers import counted
    from workbench.importing.rows import read_rows
    from workbench.importing.storing import judged, put_all
    from workbench.jobs.store import Store
    from workbench.terminal import print_json, say

    rows = read_rows(results, {name: value for name, value in settled.items() if value is not None})
    store = Store(into)
    found = judged(rows, store, results.parent, first_task)
    replaced = put_all(store, found)
    runs = [run for _, run, _ in found.values()]
    wrong = [f"{row.where}: {run.message}" for row, run, _ in found.values() if run.status == "ERROR"]
    unproved = sum(run.own["routes"] is None and run.status != "ERROR" for run in runs)
    for sentence in wrong:
        say(sentence, err=True)
    if as_json:
        told = {"imported": len(runs), "replaced": replaced, "without_routes": unproved, "wrong": wrong}
        print_json(told | {"files": list(found)})
    else:
        parts = [f"{counted(len(runs), 'run')} imported into {into}"]
        parts += [f"{replaced} in place of earlier ones"] if replaced else []
        parts += [f"{unproved} without routes, kept as claimed"] if unproved else []
        say(", ".join([*parts, *([f"{len(wrong)} wrong"] if wrong else [])]))
    context.exit(1 if wrong else 0)
