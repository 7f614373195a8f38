"""Kinds of values: what a stored column may hold, so that nothing behind the reader need look at shapes or types again.

A store is files that anybody may have written or damaged. What is not of its kind is refused with the file; a line of
text, which tables and figures show, becomes one printable line on the way.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple, TypeGuard

import msgspec
from msgspec import UNSET, Meta, UnsetType

from instances.declared.types import about
from instances.errors import one_line

LONGEST_LINE = 1000
"""Characters kept of a name or sentence."""
LARGEST = sys.float_info.max
LARGEST_WHOLE = 2**63 - 1
MOST_TASKS = 2**31 - 1

Finite = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
Amount = Annotated[float, Meta(ge=0, le=LARGEST)]
Limit = Annotated[float, Meta(gt=0, le=LARGEST)]
Whole = Annotated[int, Meta(ge=-LARGEST_WHOLE, le=LARGEST_WHOLE)]
Task = Annotated[int, Meta(ge=-MOST_TASKS, le=MOST_TASKS)]
Size = Annotated[int, Meta(ge=0, le=MOST_TASKS)]


class Item(msgspec.Struct, frozen=True, kw_only=True):
    """What was solved, and more by problem."""

    name: Annotated[str, about("of what was solved")]
    digest: Annotated[str, about("of its arrays")]
    n_tasks: Annotated[Size | None, about("number of tasks n")] = None
    n_depots: Annotated[Size | None, about("number of depots and UAVs m")] = None
    asymmetry: Annotated[Amount | None, about("mean |c_ij − c_ji| / (c_ij + c_ji)")] = None
    best_known: Annotated[Amount | None, about("best known value of its set", "s")] = None
    family: Annotated[str | None, about("generator family or set")] = None


class Paths(msgspec.Struct, frozen=True, kw_only=True):
    """Polylines held end to end, or nothing."""

    offsets: Annotated[list[Whole] | UnsetType, about("where each path begins in points")] = UNSET
    points: Annotated[list[tuple[Finite, Finite]] | UnsetType, about("of all paths, end to end", "m")] = UNSET

    def __post_init__(self) -> None:
        if (self.offsets is UNSET) != (self.points is UNSET):
            raise ValueError("must have both offsets and points, or neither")


class Kind(NamedTuple):
    """The type of a value, what stands where it is missing, what it is kept as, and what its type does not say.

    fault : what is wrong with a value of the type, or "". rule : what the type checks and its JSON Schema lacks.
    """

    type: Any
    missing: Callable[[], Any] = lambda: None
    keep: Callable[[Any], Any] = lambda value: value
    fault: Callable[[Any], str] = lambda value: ""
    rule: Mapping[str, Any] | None = None


def is_number(value: object) -> TypeGuard[float]:
    """Return whether `value` is a finite number that a float can hold; true and false are none."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) <= sys.float_info.max  # also of whole numbers too large for a float; False for NaN


def _line(value: str) -> str:
    return one_line(value, LONGEST_LINE)


def _item(value: dict[str, Any]) -> dict[str, Any]:
    sizes = {"n_tasks": None, "n_depots": None}
    return sizes | {key: _line(entry) if isinstance(entry, str) else entry for key, entry in value.items()}


def _not_square(value: list[list[float]]) -> str:
    square = all(len(row) == len(value) for row in value)
    return "" if square else "must be as many lists of finite numbers as each holds numbers"


def _not_readings(value: list[list[float]]) -> str:
    fours = all(len(row) == 4 and row[0] >= 0 and row[1] >= 1 for row in value)
    return "" if fours else "must be rows of a UAV, a number from 1, x and y"


KINDS = {
    "line": Kind(str, str, _line),
    "text": Kind(str, str),
    "number": Kind(Finite | None),
    "finite": Kind(Finite),
    "amount": Kind(Amount | None),
    "limit": Kind(Limit),
    "whole": Kind(Whole),
    "flag": Kind(bool, bool),
    "table": Kind(dict[str, Any], dict),
    "figures": Kind(dict[str, Finite], dict),
    "numbers": Kind(list[Finite]),
    "points": Kind(list[tuple[Finite, Finite]]),
    "polylines": Kind(list[list[tuple[Finite, Finite]]]),
    "readings": Kind(list[list[Finite]], list, fault=_not_readings),
    "matrix": Kind(list[list[Finite]], fault=_not_square),
    "paths": Kind(Paths, dict, rule={"dependentRequired": {"offsets": ["points"], "points": ["offsets"]}}),
    "routes": Kind(list[list[Task]]),
    "trace": Kind(list[tuple[Amount, Finite | None, Finite | None]], list),
    "item": Kind(Item, dict, _item),
}
"""Kind of a column → what its values are."""
