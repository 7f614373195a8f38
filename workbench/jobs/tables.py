"""What stands in a study's tables, checked: each function raises InputError that names the key and the value."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

from instances.errors import InputError, shown, suggestion
from instances.registry import LARGEST, LARGEST_WHOLE, in_range

MOST_RUNS = 1_000_000
"""Runs of a study, and combinations of what one of its tables lists; asked before any is made."""


def seeds_from(value: Any, where: str = "seeds") -> tuple[int, ...]:
    """Return seeds: so many from 0, or those listed."""
    if isinstance(value, int) and not isinstance(value, bool):
        if not 1 <= value <= MOST_RUNS:
            raise InputError(f"{where}: must be from 1 to {MOST_RUNS}, got {shown(value)}")
        return tuple(range(value))
    seeds = tuple(typed(seed, int, where) for seed in listed(value))
    for seed in seeds:
        if seed < 0:
            raise InputError(f"{where}: must be 0 or more, got {shown(seed)}")
    return seeds


def grid(table: dict[str, Any], where: str) -> list[dict[str, Any]]:
    """Return every combination of the lists in `table`; what is no list is a list of one."""
    return [dict(zip(table, values, strict=True)) for values in combined([*map(listed, table.values())], where)]


def combined(lists: Sequence[Sequence[Any]], where: str) -> list[tuple[Any, ...]]:
    """Return every combination of one of each list; InputError where there are too many."""
    count = math.prod(map(len, lists))
    if count > MOST_RUNS:
        raise InputError(f"{where}: its lists have {shown(count)} combinations, more than {MOST_RUNS}")
    return list(itertools.product(*lists))


def listed(value: Any) -> list[Any]:
    """Return `value` as a list: itself, or the only thing in it."""
    return value if isinstance(value, list) else [value]


def counts_from(value: Any, where: str) -> list[int]:
    """Return one number or several, each at least 1."""
    counts = [typed(count, int, where) for count in listed(value)]
    for count in counts:
        if count < 1:
            raise InputError(f"{where}: must be at least 1, got {count}")
    return counts


def tables_of(data: Mapping[str, Any], key: str) -> list[dict[str, Any]]:
    """Return the tables headed ``[[key]]``."""
    tables = data.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise InputError(f"study: {key} must be tables, each headed [[{key}]]")
    return tables


def known_keys(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    """Refuse a key that is not `known`, with the near miss."""
    for key in table:
        if key not in known:
            raise InputError(f"{where}: unknown key {shown(key)}{suggestion(key, known)} (known: {', '.join(known)})")


def typed(value: Any, kind: Any, where: str) -> Any:
    """Return `value` where it is of `kind`; numbers are finite, true and false are none."""
    fits = isinstance(value, kind) and (kind is bool or not isinstance(value, bool))
    if not fits or (isinstance(value, (int, float)) and not in_range(value)):
        wanted = {str: "a text", int: "a whole number", dict: "a table"}.get(kind, "a number")
        more = f" of at most {LARGEST_WHOLE if isinstance(value, int) else LARGEST:g}" if fits else ""
        raise InputError(f"{where}: must be {wanted}{more}, got {shown(value)}")
    return value
