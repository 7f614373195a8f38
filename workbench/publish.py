"""Publish: what a finished study leaves behind: a table for the terminal, results.csv and report.html."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pandas as pd
from rich import box
from rich.console import Console
from rich.table import Table

from reports.compare import Comparison
from reports.metrics import summary
from reports.page import write_report
from reports.tables import SUMMARY_COLUMNS, cells, shown, write_csv


def publish(folder: Path) -> list[str]:
    """Print the summary per solver on stdout, write ``results.csv`` and ``report.html`` in `folder`.

    Return what could not be read in the store and what contradicts itself there, a sentence each.
    """
    report = write_report([folder], folder / "report.html")
    write_csv(report.runs, folder / "results.csv")
    print_summary(report.runs)
    false = report.contradictions[["instance", "method", "seed", "sentence"]].itertuples(index=False)
    return [*report.warnings, *(f"{instance} {method} seed {seed}: {told}" for instance, method, seed, told in false)]


def print_summary(runs: pd.DataFrame) -> None:
    """Print the summary per solver as a table on stdout."""
    if runs.empty:
        return
    found = summary(runs)
    columns = shown(SUMMARY_COLUMNS, found)
    _print(["Solver", *(column.heading for column in columns)], zip(found.index, cells(columns, found), strict=True))


def print_comparison(comparison: Comparison) -> None:
    """Print what became of each method against the older store, on stdout."""
    counts = ["instances", "better", "worse", "unchanged"]
    rows = [
        (f"{row['method']}, {row['measure']}", [*(str(row[name]) for name in counts), str(row["verdict"])])
        for row in comparison.methods.to_dict("records")
    ]
    _print(["Against the older store", *counts, "verdict"], rows)
    for sentence in [*comparison.regressions, *comparison.remarks]:
        print(sentence)


def _print(headings: list[str], rows: Iterable[tuple[object, list[str]]]) -> None:
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column(headings[0], no_wrap=True)
    for heading in headings[1:]:
        table.add_column(heading, justify="right")
    for name, cells_of_row in rows:
        table.add_row(str(name), *cells_of_row)
    console = Console()
    Console(width=None if console.is_terminal else max(console.width, 160)).print(table)
