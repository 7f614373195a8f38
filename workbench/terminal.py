"""Tables for people on a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text


def print_table(headings: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> None:
    """Print a table on stdout; its first `words` columns are words, set left and not wrapped, the others numbers."""
    table = Table(box=box.SIMPLE_HEAD)
    for number, heading in enumerate(headings):
        table.add_column(Text(heading), justify="left" if number < words else "right", no_wrap=number < words)
    for row in rows:
        table.add_row(*map(Text, row))  # what stands in square brackets is no markup
    console = Console()
    Console(width=None if console.is_terminal else max(console.width, 160)).print(table)
