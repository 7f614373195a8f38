"""Blocks: what the sections of a page are made of. All text in them is plain and is escaped by the template."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from reports import numbers
from reports.columns import Column
from reports.figures.style import styles
from reports.figures.svg import Drawn


@dataclass(frozen=True)
class Note:
    """A paragraph set apart: `tone` is soft or calm, `key` its anchor."""

    text: str
    tone: str = "soft"
    key: str = ""


@dataclass(frozen=True)
class Lines:
    """A list of sentences."""

    lines: Sequence[str]


@dataclass(frozen=True)
class Facts:
    """Terms, each with its text; `large` for the few numbers that a page is about."""

    rows: Sequence[tuple[str, str]]
    large: bool = False


@dataclass(frozen=True)
class Source:
    """Text as it stands in a file."""

    text: str


@dataclass(frozen=True)
class Cell:
    """One entry of a table: text, the number it sorts by (None: its text), a mark (best, bad), a method's line."""

    text: str
    sort: float | None = None
    mark: str = ""
    line: tuple[str, str] | None = None


@dataclass(frozen=True)
class Table:
    """A table that sorts by a click on a heading; with the columns' meanings folded below, where they are stated."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    key: str = ""

    @property
    def help(self) -> list[Folded]:
        """What the columns mean."""
        return column_help(self.columns)


@dataclass(frozen=True)
class Folded:
    """Blocks that are seen when asked for, and in print."""

    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Beside:
    """Blocks side by side where the screen is wide enough."""

    blocks: Sequence[Block]


@dataclass(frozen=True)
class Section:
    """A titled part of the page.

    key : its anchor; without one it is a part of another section. short : its name in the navigation, if not `title`.
    tone : alarm or alarm quiet; such a section is not in the navigation.
    """

    title: str
    blocks: Sequence[Block]
    key: str = ""
    short: str = ""
    tone: str = ""


Block = str | Markup | list["Block"] | Note | Lines | Facts | Source | Table | Folded | Beside | Section | Drawn
"""A plain text is a paragraph, a list keeps its blocks together, Markup goes into the page as it is."""


def figures_in(blocks: Iterable[Block]) -> list[Drawn]:
    """Return the figures among `blocks` and inside them, in reading order."""
    found = list[Drawn]()
    for block in blocks:
        if isinstance(block, Drawn):
            found.append(block)
        elif isinstance(block, Section | Beside | Folded | list):
            found += figures_in(block if isinstance(block, list) else block.blocks)
    return found


def column_help(columns: Iterable[Column]) -> list[Folded]:
    """Return the meanings of `columns` in one folded block; in none where no column states one."""
    rows = [(c.heading, c.meaning) for c in columns if c.meaning]
    return [Folded("What the columns mean", [Facts(rows)])] if rows else []


def table_of(
    frame: pd.DataFrame,
    columns: Sequence[Column],
    *,
    caption: str = "",
    key: str = "",
    methods: Iterable[str] = (),
    rivals: Iterable[bool] | None = None,
) -> Table:
    """Return `frame` as a table of `columns`; a cell that names one of `methods` has its line from the figures.

    rivals : which rows can be the best of a column, a truth value a row: those that can be compared; else all.
    """
    lines = {method: line_of(method, methods) for method in methods}
    ranked = np.ones(len(frame), dtype=bool) if rivals is None else np.array(list(rivals), dtype=bool)
    heads, cells = [], []
    for column in columns:
        made = [cell(column, value, lines) for value in frame[column.key]]
        head, words = column.with_unit([one.text for one in made])
        marks = np.full(len(frame), "", dtype=object)
        marks[ranked] = column.marks(frame[column.key][ranked])
        heads.append(head)
        cells.append([replace(one, text=text, mark=mark) for one, text, mark in zip(made, words, marks, strict=True)])
    return Table(heads, [list(row) for row in zip(*cells, strict=True)], caption, key)


def cell(column: Column, value: Any, lines: dict[str, tuple[str, str]] | None = None) -> Cell:
    """Return the cell of `value`; a missing one sorts last."""
    text = column.text(value)
    if column.is_text or numbers.missing(value):
        return Cell(text, line=(lines or {}).get(text))
    return Cell(text, sort=max(-1e300, min(float(value), 1e300)))


def line_of(method: str, methods: Iterable[str]) -> tuple[str, str]:
    """Return colour and dashes of the line that `method` has in every figure of `methods`."""
    look = styles(methods)[method]
    return look.colour, " ".join(f"{2 * length:g}" for length in look.dash[1]) if len(look.dash) == 2 else ""
