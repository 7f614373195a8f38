"""What stands in a study's tables, checked: each function raises InputError that names the key and the value."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

from instances.errors import InputError, suggestion


def seeds_from(value: Any, where: str = "seeds") -> tuple[int, ...]:
    """Return seeds: so many from 0, or those listed."""
    if isinstance(value, int) and not isinstance(value, bool):
        if value < 1:
            raise InputError(f"{where}: must be at least 1, got {value}")
        return tuple(range(value))
    return tuple(typed(seed, int, where) for seed in listed(value))


def grid(table: dict[str, Any]) -> list[dict[str, Any]]:
    """Return every combination of the lists in `table`; what is no list is a list of one."""
    return [dict(zip(table, values, strict=True)) for values in itertools.product(*map(listed, table.values()))]


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
            raise InputError(f"{where}: unknown key '{key}'{suggestion(key, known)} (known: {', '.join(known)})")


def typed(value: Any, kind: Any, where: str) -> Any:
    """Return `value` where it is of `kind`; true and false are no numbers."""
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        wanted = {str: "a text", int: "a whole number", dict: "a table"}.get(kind, "a number")
        raise InputError(f"{where}: must be {wanted}, got {value!r}")
    return value
