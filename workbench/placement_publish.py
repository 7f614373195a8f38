"""What is written about stored placement runs: a page, a CSV and a table for the terminal. Nothing is run."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from rich import box
from rich.console import Console
from rich.table import Table

from instances.disk import write_aside
from instances.errors import InputError
from reports.placement_page import HEADINGS, placement_summary, summary_cells, write_placement_page
from reports.placement_store import PlacementStore, placement_contradictions, read_placements


@dataclass(frozen=True)
class Published:
    """What became of the placement runs of some stores.

    written : files. warnings : what could not be read. false : what contradicts itself. failed : runs without a
    placement. routing : whether the stores hold routing runs as well.
    """

    written: list[Path]
    warnings: list[str]
    false: list[str]
    failed: int
    routing: bool


def publish_placements(
    folders: Sequence[Path], out: Path | None, csv: Path | None, others: Sequence[str] = ()
) -> Published | None:
    """Print the summary and write the page `out` and the table `csv`; None where the stores hold no placement.

    In stores that hold routing runs as well, those two names are theirs, and ``-placement`` is added to ours.
    others : flags that only mean something for routing runs; InputError where there are none.
    """
    store = read_placements(*folders)
    if not store.problems:
        return None
    if others and not store.routing:
        raise InputError(f"{others[0]}: is about routing runs; a store of task locations alone has --out and --csv")
    page, table = (_beside(path) if path and store.routing else path for path in (out, csv))
    frame = write_placement_page(store.runs, page, _title(folders, store))
    if table is not None:
        write_aside(table, frame.to_csv(index=False))
    if len(frame):
        _print(frame)
    false = [sentence for _, sentence in placement_contradictions(store.runs)]
    failed = int(frame["mutual_information"].isna().sum())
    return Published([path for path in (table, page) if path], store.warnings, false, failed, store.routing)


def _beside(path: Path) -> Path:
    return path.with_name(f"{path.stem}-placement{path.suffix}")


def _title(folders: Sequence[Path], store: PlacementStore) -> str:
    """Return a title with the study's name, where one store of placements alone says it, else the folders'."""
    names = [folder.resolve().name for folder in folders]
    if len(folders) == 1 and not store.routing:
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            names = [str(json.loads((folders[0] / "study.json").read_bytes())["study"]["name"])]
    return f"Task locations: {', '.join(names)}"


def _print(frame: pd.DataFrame) -> None:
    table = Table(box=box.SIMPLE_HEAD)
    for words in HEADINGS.values():
        table.add_column(words, justify="left" if words in ("Problem", "Method") else "right")
    for cells in summary_cells(placement_summary(frame)):
        table.add_row(*cells)
    console = Console()
    Console(width=None if console.is_terminal else max(console.width, 160)).print(table)
