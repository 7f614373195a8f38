"""What is read on a terminal: sentences and tables for people, JSON for programs.

No text from a file can do more there than be read, and no value is ever cut to fit a table.
"""

from __future__ import annotations

import json
import math
import os
import sys
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import click

from instances.errors import InputError, one_line, suggestion

LONGEST_SENTENCE = 5000
"""Characters of one sentence."""
HEADING_LINES = 3
"""Lines a heading may take."""
BETWEEN = 3
"""Spaces between two columns of a table."""
ALL = "all"
"""What ``--columns`` takes for every column."""


def width(*, err: bool = False) -> int | None:
    """Return the columns there are: COLUMNS where that is set, else the terminal's; None in a pipe or a file."""
    given = os.environ.get("COLUMNS", "")
    if given.isascii() and given.isdigit() and int(given) > 0:
        return int(given)
    stream = sys.stderr if err else sys.stdout
    return os.get_terminal_size(stream.fileno()).columns if stream.isatty() else None


def say(sentence: str, *, err: bool = False, longest: int = LONGEST_SENTENCE) -> None:
    """Print `sentence` as one line, control characters and what else is not printable escaped.

    It is wrapped between words where the terminal is narrower.
    """
    line, room = one_line(sentence, longest), width(err=err)
    fits = room is None or len(line) <= room
    click.echo(line if fits else "\n".join(wrapped(line, room or 0)), err=err)


def say_lines(text: str) -> None:
    """Print the lines of `text`, each as `say` does, however long."""
    for line in text.splitlines():
        say(line, longest=sys.maxsize)


def wrapped(line: str, room: int) -> list[str]:
    """Return `line` in lines of at most `room` characters where its words allow it, all but the first set in."""
    inset = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.wrap(line, room, subsequent_indent=inset, break_long_words=False, break_on_hyphens=False) or [line]


def print_json(value: Any) -> None:
    """Print one JSON text on stdout; a number that is not finite becomes null, anything unknown its text."""
    click.echo(json.dumps(plain(value), allow_nan=False))


def plain(value: Any) -> Any:
    """Return `value` as JSON knows it."""
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(each) for each in value]
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, str | int) else str(value)


@dataclass(frozen=True)
class TextTable:
    """A table for people: the keys of its columns, their headings, and rows of texts.

    words : so many of the first columns say what a row is; they are never left out. first : keys of the columns that
    are left out last where not all fit. left : keys of further columns of words, set left.
    """

    keys: Sequence[str]
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 1
    first: Sequence[str] = ()
    left: Sequence[str] = ()

    def chosen(self, names: Sequence[str]) -> list[str]:
        """Return the keys asked for by ``--columns``, those that say what a row is in front; InputError for others."""
        if ALL in names:
            return list(self.keys)
        refuse_unknown_columns(names, self.keys)
        return [*self.keys[: self.words], *(name for name in names if name not in self.keys[: self.words])]


def refuse_unknown_columns(names: Iterable[str], known: Sequence[str]) -> None:
    """Raise InputError, with the near miss, for the first of `names` that is no column."""
    for name in names:
        if name not in known and name != ALL:
            raise InputError(
                f"--columns: there is no column '{name}'{suggestion(name, known)} (known: {', '.join(known)}; or {ALL})"
            )


def print_table(table: TextTable, names: Sequence[str] = ()) -> None:
    """Print `table` on stdout.

    Without `names`, columns that do not fit the terminal are left out and said below; the columns of `names` are
    printed whatever the width, in several tables below each other where one would be too wide.
    """
    room = width()
    if names:
        for keys in _stacked(table, table.chosen(names), room):
            _print(table, keys, room)
        return
    kept = _fitting(table, room)
    _print(table, kept, room)
    dropped = [key for key in table.keys if key not in kept]
    if dropped:
        say(f"left out at {room} columns: {', '.join(dropped)}; --columns NAME,... or --columns {ALL} shows them")


def _fitting(table: TextTable, room: int | None) -> list[str]:
    """Return the keys of the columns that fit `room`, those of `first` tried first, in the table's order."""
    if room is None:
        return list(table.keys)
    order = [*table.keys[: table.words], *(key for key in table.first if key in table.keys)]
    order += [key for key in table.keys if key not in order]
    kept = order[: table.words]
    for key in order[table.words :]:
        if _total(table, [*kept, key], room) <= room:
            kept.append(key)
    return [key for key in table.keys if key in kept]


def _stacked(table: TextTable, keys: Sequence[str], room: int | None) -> list[list[str]]:
    """Return `keys` in groups that fit `room` each, every group led by the columns that say what a row is."""
    lead = list(keys[: table.words])
    groups = [list(lead)]
    for key in keys[table.words :]:
        if room is not None and len(groups[-1]) > len(lead) and _total(table, [*groups[-1], key], room) > room:
            groups.append(list(lead))
        groups[-1].append(key)
    return groups


def _total(table: TextTable, keys: Sequence[str], room: int | None) -> int:
    return sum(_needed(table, key, room) for key in keys) + BETWEEN * (len(keys) - 1)


def _needed(table: TextTable, key: str, room: int | None) -> int:
    """Return the width of a column: of its longest text, and of a heading in at most HEADING_LINES lines.

    Where the terminal has an end, words go over several lines rather than take more than half of it.
    """
    from rich.cells import cell_len

    at = table.keys.index(key)
    needed = max((cell_len(_clean(row[at])) for row in table.rows), default=1)
    heading = _clean(table.headings[at])
    if room is None:
        return max(needed, cell_len(heading))
    if at < table.words or key in table.left:
        needed = min(needed, max(12, (room // 2 - BETWEEN) // (table.words if at < table.words else 1)))
    needed = max(needed, *map(cell_len, heading.split(" ")))
    while len(_heading(heading, needed)) > HEADING_LINES:
        needed += 1
    return needed


def _heading(heading: str, room: int) -> list[str]:
    return textwrap.wrap(heading, room, break_long_words=False, break_on_hyphens=False)


def _clean(cell: str) -> str:
    return one_line(cell, LONGEST_SENTENCE)


def _print(table: TextTable, keys: Sequence[str], room: int | None) -> None:
    from rich import box  # here: most commands print no table
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    if room is not None and _total(table, keys, None) <= room:
        room = None  # headings on one line each
    printed = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    places = [table.keys.index(key) for key in keys]
    for key, at in zip(keys, places, strict=True):
        needed = _needed(table, key, room)
        printed.add_column(
            Text("\n".join(_heading(_clean(table.headings[at]), needed))),  # Text: in which [brackets] are no markup
            width=needed,
            justify="left" if at < table.words or key in table.left else "right",
            vertical="top",
            overflow="fold",
        )
    for row in table.rows:
        printed.add_row(*(Text(_clean(row[at])) for at in places))
    total = sum(_needed(table, key, room) + BETWEEN for key in keys)
    click.echo()
    Console(width=max(total, room or 0)).print(printed)
