"""Lists: long tables of plain rows. Without JavaScript all rows are there; the page's script filters and sorts them,
shows few at a time and opens one in a panel.

There may be ten thousand rows, so they are written as leanly as HTML allows: cells and rows without end tags, and what
stands on the left by a class of the table (``l1``: its first column).
"""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd
from markupsafe import Markup, escape

from reports.columns import Column


def listing(key: str, columns: Sequence[Column], rows: pd.DataFrame) -> Markup:
    """Return the list `key` of `rows`, a row each, as a table of `columns`."""
    left = " ".join(f"l{number}" for number, column in enumerate(columns, 1) if column.is_text)
    made = [_column(column, rows[column.key]) for column in columns]
    heads = Markup("").join(head for head, _ in made)
    body = Markup("\n<tr>").join(map(Markup("").join, zip(*(cells for _, cells in made), strict=True)))
    return Markup(
        '<div class="list" id="{key}"><div class="scroll"><table id="{key}-table" class="{left}">\n'
        "<thead><tr>{heads}</tr></thead>\n<tbody>\n<tr>{body}\n</tbody></table></div></div>"
    ).format(key=key, left=left, heads=heads, body=body)


def _column(column: Column, values: pd.Series) -> tuple[Markup, list[Markup]]:
    """Return the heading and the cells of a column."""
    head, words = column.with_unit([column.text(value) for value in values])
    facts = {"data-key": head.key, "data-unit": head.unit, "title": head.meaning, "class": "left" * head.is_text}
    said = Markup("").join(Markup(' {}="{}"').format(name, value) for name, value in facts.items() if value)
    cells = [
        Markup(f'<td class="{mark}">' if mark else "<td>") + escape(word)
        for word, mark in zip(words, column.marks(values), strict=True)
    ]
    return Markup('<th scope="col"{}>{}</th>').format(said, head.heading), cells
