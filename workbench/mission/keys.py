"""Keys of a mission file's tables: each says what it means and what values it takes, for people and as a test.

Every maker takes `meaning`, a line for people, and `example`, a value to show where the default shows none.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import field, fields
from typing import Any, TypeVar

from formulations.limits import LARGEST_SEED
from instances.errors import InputError, shown, suggestion
from instances.registry import LARGEST

T = TypeVar("T")

SMALLEST = 1e-100
"""The square of a smaller positive number is 0 in float64."""
MOST = 10_000
"""Of whatever is counted, unless the key says otherwise."""


def _key(
    default: Any,
    wanted: str,
    fits: Callable[[Any], bool],
    read: Callable[[Any], Any] = lambda v: v,
    *,
    meaning: str = "",
    example: Any = None,
) -> Any:
    """Return a dataclass field whose metadata says what it means, what it takes and how that is read."""
    shows = default if example is None and default not in (None, {}) else example
    metadata = {"wanted": wanted, "fits": fits, "read": read, "meaning": meaning, "example": shows}
    if isinstance(default, (list, dict)):
        return field(default_factory=lambda: type(default)(default), metadata=metadata)
    return field(default=default, metadata=metadata)


def positive(default: float | None, unit: str = "", most: float = LARGEST, **about: Any) -> Any:
    """Return a key for a positive number of at most `most`."""
    return _key(
        default, f"a positive number{_in(unit)}", lambda v: is_number(v) and SMALLEST <= v <= most, float, **about
    )


def not_negative(default: float | None, unit: str = "", **about: Any) -> Any:
    """Return a key for a number of at least 0."""
    return _key(default, f"a number of at least 0{_in(unit)}", lambda v: is_number(v) and v >= 0, float, **about)


def one_or_two(default: float, unit: str, **about: Any) -> Any:
    """Return a key for a positive number, or two of them, along x and y."""

    def fits(value: Any) -> bool:
        parts = value if isinstance(value, list) and len(value) == 2 else [value]
        return all(is_number(v) and v >= SMALLEST for v in parts)

    def read(value: Any) -> Any:
        return [float(v) for v in value] if isinstance(value, list) else float(value)

    return _key(default, f"a positive number{_in(unit)} or two of them", fits, read, **about)


def count(default: int, least: int, most: int = MOST, **about: Any) -> Any:
    """Return a key for a whole number from `least` to `most`."""
    return _key(
        default, f"a whole number from {least} to {most}", lambda v: type(v) is int and least <= v <= most, **about
    )


def seed(**about: Any) -> Any:
    """Return a key for a seed."""
    return count(0, 0, LARGEST_SEED, **about)


def counts(default: list[int], **about: Any) -> Any:
    """Return a key for two whole numbers from 1 to 1000."""

    def fits(value: Any) -> bool:
        return isinstance(value, list) and len(value) == 2 and all(type(v) is int and 1 <= v <= 1000 for v in value)

    return _key(default, "two whole numbers from 1 to 1000", fits, **about)


def text(default: str | None, **about: Any) -> Any:
    """Return a key for a text that is not empty."""
    return _key(default, "a text", lambda v: isinstance(v, str) and v != "", **about)


def one_of(default: str, known: Collection[str], **about: Any) -> Any:
    """Return a key for one of the `known` texts."""
    return _key(default, f"one of {', '.join(known)}", lambda v: isinstance(v, str) and v in known, **about)


def texts(default: list[str], **about: Any) -> Any:
    """Return a key for a list of texts."""
    return _key(
        default, "a list of texts", lambda v: isinstance(v, list) and all(isinstance(item, str) for item in v), **about
    )


def switch(default: bool, **about: Any) -> Any:
    """Return a key for true or false."""
    return _key(default, "true or false", lambda v: isinstance(v, bool), **about)


def options(**about: Any) -> Any:
    """Return a key for a method's options."""
    return _key({}, "a table", lambda v: isinstance(v, dict), **about)


def settings_of(cls: type[T], table: Any, name: str) -> T:
    """Return the settings in a table; InputError names the key, the value and what it should be."""
    if not isinstance(table, Mapping):
        raise InputError(f"[{name}] must be a table, got {shown(table)}")
    known = {f.name: f.metadata for f in fields(cls)}  # type: ignore[arg-type]
    for key, value in table.items():
        if key not in known:
            raise InputError(f"[{name}]: unknown key {shown(key)}{suggestion(key, known)} (known: {', '.join(known)})")
        if not known[key]["fits"](value):
            raise InputError(f"{name}.{key} must be {known[key]['wanted']}, got {shown(value)}")
    return cls(**{key: known[key]["read"](value) for key, value in table.items()})


def is_number(value: Any) -> bool:
    """Return whether `value` is a number whose square is finite."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= LARGEST


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""
