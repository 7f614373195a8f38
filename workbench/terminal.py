"""What people read on a terminal: sentences and tables, in which no text from a file can do more than be read."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import click

from instances.errors import one_line

LONGEST_SENTENCE = 5000
"""Characters of one sentence."""


def say(sentence: str, *, err: bool = False) -> None:
    """Print `sentence` as one line, control characters and what else is not printable escaped."""
    click.echo(one_line(sentence, LONGEST_SENTENCE), err=err)


def print_table(headings: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> None:
    """Print a table on stdout; its first `words` columns are words, set left and not wrapped, the others numbers."""
    from rich import box  # here: most commands print no table
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    def text(cell: str) -> Text:
        return Text(one_line(cell, LONGEST_SENTENCE))  # in which [brackets] are no markup

    table = Table(box=box.SIMPLE_HEAD)
    for number, heading in enumerate(headings):
        table.add_column(text(heading), justify="left" if number < words else "right", no_wrap=number < words)
    for row in rows:
        table.add_row(*map(text, row))
    console = Console()
    Console(width=None if console.is_terminal else max(console.width, 200)).print(table)
