"""Grids: every combination of what a study's tables list."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

from instances.errors import InputError, shown

MOST_RUNS = 1_000_000
"""Runs of a study, and combinations of what one of its tables lists; asked before any is made."""


def grid(table: Mapping[str, Any], where: str) -> list[dict[str, Any]]:
    """Return every combination of the lists in `table`; what is no list is a list of one."""
    lists = [value if isinstance(value, list) else [value] for value in table.values()]
    return [dict(zip(table, values, strict=True)) for values in combined(lists, where)]


def combined(lists: Sequence[Sequence[Any]], where: str) -> list[tuple[Any, ...]]:
    """Return every combination of one of each list; InputError where there are too many."""
    count = math.prod(map(len, lists))
    if count > MOST_RUNS:
        raise InputError(f"{where}: its lists have {shown(count)} combinations, more than {MOST_RUNS}")
    return list(itertools.product(*lists))
