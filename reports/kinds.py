"""Kinds of values: what a stored column may hold, so that nothing behind the reader need look at shapes or types again.

A store is files that anybody may have written or damaged. What is not of its kind is refused with the file; a line of
text, which tables and figures show, becomes one printable line on the way.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from itertools import chain
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from instances.errors import one_line

LONGEST_LINE = 1000
"""Characters kept of a name or sentence."""
LARGEST_WHOLE = 2**63 - 1
MOST_TASKS = 2**31 - 1


class Kind(NamedTuple):
    """What checks a value, what it must be in words, what stands where it is missing, and what it is kept as."""

    check: Callable[[Any], bool]
    words: str
    missing: Callable[[], Any] = lambda: None
    keep: Callable[[Any], Any] = lambda value: value


def is_number(value: object) -> TypeGuard[float]:
    """Return whether `value` is a finite number that a float can hold; true and false are none."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) <= sys.float_info.max  # also of whole numbers too large for a float; False for NaN


def _is_amount(value: object) -> bool:
    return value is None or (is_number(value) and value >= 0)


def _is_whole(value: object, largest: int = LARGEST_WHOLE) -> bool:
    return type(value) is int and abs(value) <= largest


def _is_numbers(value: object, *shape: int | None) -> bool:
    """Return whether `value` holds finite numbers in lists of these lengths (None: any), or is an empty list."""
    if not isinstance(value, list):
        return False
    try:
        array = np.array(value)
    except (ValueError, OverflowError):  # lists of different lengths
        return False
    if not array.size:
        return len(shape) == 1 or not value
    fits = array.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, array.shape, strict=True))
    return fits and array.dtype.kind in "iuf" and bool(np.isfinite(array).all())


def _is_matrix(value: object) -> bool:
    return _is_numbers(value, None, None) and all(len(row) == len(value) for row in value)  # type: ignore[attr-defined, arg-type]


def _is_routes(value: object) -> bool:
    return isinstance(value, list) and all(
        isinstance(route, list) and all(_is_whole(task, MOST_TASKS) for task in route) for route in value
    )


def _is_trace(value: object) -> bool:
    if not isinstance(value, list) or not all(isinstance(point, list) and len(point) == 3 for point in value):
        return False
    if not value:
        return True
    if not set(map(type, chain.from_iterable(value))) <= {int, float, type(None)}:
        return False
    try:
        points = np.array(value, dtype=np.float64)  # null becomes NaN
    except OverflowError:
        return False
    return bool((np.isfinite(points[:, 0]) & (points[:, 0] >= 0)).all() and not np.isinf(points).any())


def _is_item(value: object) -> bool:
    if not isinstance(value, dict) or not all(isinstance(value.get(key), str) for key in ("name", "digest")):
        return False
    sizes = (value.get("n_tasks"), value.get("n_depots"))
    return (
        all(size is None or (_is_whole(size, MOST_TASKS) and size >= 0) for size in sizes)
        and all(map(_is_amount, (value.get("asymmetry"), value.get("best_known"))))
        and isinstance(value.get("family", ""), (str, type(None)))
    )


def _item(value: dict[str, Any]) -> dict[str, Any]:
    sizes = {"n_tasks": None, "n_depots": None}
    return sizes | {key: _line(entry) if isinstance(entry, str) else entry for key, entry in value.items()}


def _line(value: str) -> str:
    return one_line(value, LONGEST_LINE)


def _is_figures(value: object) -> bool:
    return isinstance(value, dict) and all(map(is_number, value.values()))


def _is_paths(value: object) -> bool:
    if value == {}:
        return True
    return (
        isinstance(value, dict)
        and _is_numbers(value.get("offsets"), None)
        and all(_is_whole(offset) for offset in value["offsets"])
        and _is_numbers(value.get("points"), None, 2)
    )


KINDS = {
    "line": Kind(lambda value: isinstance(value, str), "a text", str, _line),
    "text": Kind(lambda value: isinstance(value, str), "a text", str),
    "number": Kind(lambda value: value is None or is_number(value), "a finite number or null"),
    "finite": Kind(is_number, "a finite number"),
    "amount": Kind(_is_amount, "a finite number of at least 0, or null"),
    "limit": Kind(lambda value: is_number(value) and value > 0, "a finite number above 0"),
    "whole": Kind(_is_whole, "a whole number of at most 19 digits"),
    "flag": Kind(lambda value: isinstance(value, bool), "true or false", bool),
    "table": Kind(lambda value: isinstance(value, dict), "a table or null", dict),
    "figures": Kind(_is_figures, "a table of finite numbers, or null", dict),
    "numbers": Kind(lambda value: _is_numbers(value, None), "a list of finite numbers, or null"),
    "points": Kind(lambda value: _is_numbers(value, None, 2), "a list of [x, y], or null"),
    "matrix": Kind(_is_matrix, "as many lists of finite numbers as each holds numbers, or null"),
    "paths": Kind(_is_paths, "a table of offsets, a list of whole numbers, and points, a list of [x, y]", dict),
    "routes": Kind(_is_routes, "a list of lists of task numbers, or null"),
    "trace": Kind(_is_trace, "a list of [elapsed, objective or null, bound or null]", list),
    "item": Kind(_is_item, "a table with the texts name and digest, and numbers", dict, _item),
}
"""Kind of a column → what its values are."""
