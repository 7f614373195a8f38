"""Publishing, the same for every problem: the page, the table, the summaries, and whose code made the runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from reports.record import code_note
from workbench.jobs.problem import Outputs, Published
from workbench.summary import Summary

if TYPE_CHECKING:
    import pandas as pd


def published(
    outputs: Outputs,
    table: pd.DataFrame,
    codes: Iterable[str],
    summaries: Callable[[], Sequence[Summary]],
    problems: Sequence[str],
    damaged: list[str],
    write_page: Callable[[Path | None, Path | None], object] | None = None,
    notes: Sequence[str] = (),
) -> Published:
    """Write what `outputs` asks for about stored runs and return what came of it.

    table : a row a run; without rows there are no summaries. codes : the code that made each run. problems : what is
    wrong with the runs, a sentence each. damaged : the same of what could not be read. write_page : takes the page's
    file and the figures' folder, None where not asked for, and may find more that is damaged; None where it is written.
    notes : what else a reader must know, a sentence each.
    """
    from reports.csv_text import write_csv  # here: pandas takes its time

    figures = outputs.extra.get("figures")
    if write_page is not None and (outputs.page is not None or figures is not None):
        write_page(outputs.page, figures)
    if outputs.table is not None:
        write_csv(table, outputs.table, raw=outputs.raw_table)
    return Published(
        written=[path for path in (outputs.table, outputs.page) if path],
        problems=[*damaged, *problems],
        damaged=len(damaged),
        summaries=list(summaries()) if len(table) else [],
        notes=[note for note in (code_note(codes), *notes) if note],
    )


def without(what: str, failed: pd.Series[bool]) -> list[str]:
    """Return how many runs `failed`, a sentence, or nothing where none did; what : what they ended without."""
    return [f"{failed.sum()} runs ended without {what}"] if failed.any() else []
