"""Summaries: tables about stored runs, told to people as texts and to programs as values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from workbench.terminal import ALL, TextTable, plain, print_table, say

if TYPE_CHECKING:
    import pandas as pd

    from reports.columns import Column


@dataclass(frozen=True)
class Summary:
    """A table of `columns` of `frame`, by the name of what it is about.

    words : so many of the first columns say what a row is. first : keys of the columns that people want first.
    """

    name: str
    columns: Sequence[Column]
    frame: pd.DataFrame
    words: int = 1
    first: Sequence[str] = ()

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows as JSON values by the keys of the columns, in SI units; what is missing is None."""
        keys = [column.key for column in self.columns]
        return [plain({key: row[key] for key in keys}) for row in self.frame.to_dict("records")]

    def table(self) -> TextTable:
        """Return the rows as texts, each unit in its heading."""
        from reports.columns import texts

        told = zip(*texts(self.columns, self.frame), strict=True)
        headed = [column.with_unit(words) for column, words in zip(self.columns, told, strict=True)]
        headings, cells = [column.heading for column, _ in headed], [words for _, words in headed]
        left = [column.key for column in self.columns if column.is_text]
        keys = [column.key for column in self.columns]
        return TextTable(keys, headings, list(zip(*cells, strict=True)), self.words, self.first, left)


def print_summaries(summaries: Sequence[Summary], names: Sequence[str] = ()) -> None:
    """Print tables on stdout, each with those of the columns `names` that it has."""
    tables = [summary.table() for summary in summaries]
    for table in tables:
        print_table(table, [name for name in names if name in (ALL, *table.keys)])
    if without := [name for name in names if not any(name in (ALL, *table.keys) for table in tables)]:
        say(f"nothing to show of {', '.join(without)}")
