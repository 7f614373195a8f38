"""Publish: what a finished study leaves behind: a table for the terminal, results.csv and report.html."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from rich import box
from rich.console import Console
from rich.table import Table

from reports.metrics import summary
from reports.page import write_page
from reports.stores import read_stores
from reports.tables import SUMMARY_COLUMNS, cells, shown, write_csv


def publish(folder: Path) -> list[str]:
    """Print the summary per solver on stdout, write ``results.csv`` and ``report.html`` in `folder`.

    Return what could not be read in the store, a sentence each.
    """
    stores = read_stores(folder)
    print_summary(stores.runs)
    write_csv(stores.runs, folder / "results.csv")
    write_page(stores, folder / "report.html")
    return stores.warnings


def print_summary(runs: pd.DataFrame) -> None:
    """Print the summary per solver as a table on stdout."""
    if runs.empty:
        return
    found = summary(runs)
    columns = shown(SUMMARY_COLUMNS, found)
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("Solver", no_wrap=True)
    for column in columns:
        table.add_column(column.heading, justify="right")
    for name, row in zip(found.index, cells(columns, found), strict=True):
        table.add_row(str(name), *row)
    console = Console()
    Console(width=max(console.width, 160) if not console.is_terminal else None).print(table)
