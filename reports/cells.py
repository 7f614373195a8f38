"""Cells: one entry of a table on the page, with what it sorts by and how it is marked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pandas as pd

from reports import numbers
from reports.figures.style import styles


def cell(text: Any, sort: Any = None, *, best: bool = False, style: Any = None) -> dict[str, Any]:
    """Return one cell: its text, the number it sorts by (None: its text), whether it is the best of its column."""
    return {"text": str(text), "sort": sort, "best": best, "style": style}


def number_cell(write: Any, value: Any, *, best: bool = False) -> dict[str, Any]:
    """Return a cell of a number; a missing one sorts last."""
    missing = value is None or value is pd.NA or value != value
    return cell(numbers.NOTHING if missing else write(value), "" if missing else _sortable(value), best=best)


def _sortable(value: Any) -> float:
    return 1e300 if math.isinf(value) else float(value)


def method_cell(method: str, methods: Sequence[str]) -> dict[str, Any]:
    """Return a cell that names a method beside the line it has in every figure."""
    look = styles(methods)[method]
    dashes = " ".join(f"{2 * length:g}" for length in look.dash[1]) if len(look.dash) == 2 else ""
    return cell(method, style=(look.colour, dashes))
