"""Rows: what others state about a result, a row each, read from CSV, Parquet or a ``.sol`` and checked for its form.

| column | | what |
|---|---|---|
| instance | needed | name or digest of an instance of the store, or an instance file, relative to the table |
| solver | needed | name of the program, its version and settings included |
| elapsed | needed | wall clock of the solve [s] |
| time_limit | needed | wall clock it was allowed [s] |
| seed, threads | 0, 1 | |
| machine | elsewhere | where it ran, in words |
| routes | | ``[[tasks of the first UAV], …]``, the text of a ``.sol``, or the name of a ``.sol`` file |
| objective | | the longest tour it claims [s] |
| bound | | the lower bound it claims [s] |

Others print numbers with few digits, so a number is taken for what was rounded to it: 1234.57 may have been anything
within 0.005 of it.
"""

from __future__ import annotations

import csv
import importlib.util
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from formulations.limits import LARGEST_SEED, LONGEST, MOST_THREADS
from instances.disk import check_file, read_text
from instances.errors import InputError, one_line, shown, suggestion

NEEDED = ("instance", "solver", "elapsed", "time_limit")
COLUMNS = (*NEEDED, "seed", "threads", "machine", "routes", "objective", "bound")
ENDINGS = (".csv", ".parquet", ".sol")
LONGEST_NAME = 200
"""Characters of the name of a solver, instance or machine."""


@dataclass(frozen=True)
class Stated:
    """A number as others state it: `value`, and half a unit of its last digit."""

    value: float
    rounding: float


def stated(number: Decimal) -> Stated:
    """Return a number with the rounding that its digits leave open."""
    return Stated(float(number), 0.5 * 10.0 ** int(number.as_tuple().exponent))


@dataclass(frozen=True)
class Row:
    """One result: times in seconds, routes as they are written. `where`: file and row, for sentences."""

    where: str
    instance: str
    solver: str
    seed: int
    time_limit: float
    elapsed: float
    threads: int
    machine: str
    routes: Any
    objective: Stated | None
    bound: Stated | None


def read_rows(path: Path, settled: Mapping[str, Any]) -> list[Row]:
    """Return the rows of the table at `path`, or the one that a ``.sol`` is.

    settled : column → its value in every row, for what the table has no column for. InputError names file, row,
    column and value of what cannot be used; rows are counted as a spreadsheet does, the heading of a CSV being row 1.
    """
    kind = path.suffix.lower()
    if kind not in ENDINGS:
        raise InputError(f"{path}: must end in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")
    if kind == ".sol":
        columns: list[str] = ["routes"]
        cells: list[tuple[str, dict[str, Any]]] = [(str(path), {"routes": path.name, "instance": path.stem})]
    else:
        columns, found = (_csv if kind == ".csv" else _parquet)(path)
        cells = [(f"{path}: row {number}", row) for number, row in found]
    _refuse_columns(path, columns, settled)
    if not cells:
        raise InputError(f"{path}: holds no row")
    return [_row(where, row | dict(settled)) for where, row in cells]


def _refuse_columns(path: Path, columns: list[str], settled: Mapping[str, Any]) -> None:
    for number, name in enumerate(columns):
        if name not in COLUMNS:
            raise InputError(
                f"{path}: unknown column {shown(name)}{suggestion(str(name), COLUMNS)} (known: {', '.join(COLUMNS)})"
            )
        if name in columns[:number]:
            raise InputError(f"{path}: column '{name}' is there twice")
        if name in settled and path.suffix.lower() != ".sol":
            raise InputError(f"--{name.replace('_', '-')}: {path} has a column '{name}' of its own")
    for name in NEEDED:
        if name not in columns and name not in settled and not (name == "instance" and path.suffix.lower() == ".sol"):
            raise InputError(f"{path}: has no '{name}'; give --{name.replace('_', '-')} or a column of that name")


def _csv(path: Path) -> tuple[list[str], Iterator[tuple[int, dict[str, Any]]]]:
    lines = csv.reader(io.StringIO(read_text(path).removeprefix("\ufeff"), newline=""), strict=True)
    try:
        columns = [name.strip() for name in next(lines, [])]
        rows = [(number, row) for number, row in enumerate(lines, 2) if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise InputError(f"{path}: is no CSV ({error})") from None
    for number, row in rows:
        if len(row) != len(columns):
            raise InputError(f"{path}: row {number}: has {len(row)} cells under {len(columns)} headings")
    return columns, ((number, dict(zip(columns, row, strict=True))) for number, row in rows)


def _parquet(path: Path) -> tuple[list[str], Iterator[tuple[int, dict[str, Any]]]]:
    if importlib.util.find_spec("pyarrow") is None:
        raise InputError(f"{path}: reading Parquet needs pyarrow, which is not installed (pip install pyarrow)")
    import pyarrow as pa
    import pyarrow.parquet

    check_file(path)
    try:
        table = pyarrow.parquet.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise InputError(f"{path}: is no Parquet file ({one_line(str(error), LONGEST_NAME)})") from None
    return table.column_names, iter(enumerate(table.to_pylist(), 1))


def _row(where: str, cells: Mapping[str, Any]) -> Row:
    given = {name: value for name, value in cells.items() if not _empty(value)}
    for name in NEEDED:
        if name not in given:
            raise InputError(f"{where}: '{name}' is empty")
    row = Row(
        where=where,
        instance=_text(where, "instance", given["instance"]),
        solver=_text(where, "solver", given["solver"]),
        seed=_whole(where, "seed", given.get("seed", 0), 0, LARGEST_SEED),
        time_limit=_seconds(where, "time_limit", given["time_limit"], 1e-9),
        elapsed=_seconds(where, "elapsed", given["elapsed"], 0.0),
        threads=_whole(where, "threads", given.get("threads", 1), 1, MOST_THREADS),
        machine=_text(where, "machine", given.get("machine", "elsewhere")),
        routes=given.get("routes"),
        objective=_number(where, "objective", given["objective"]) if "objective" in given else None,
        bound=_number(where, "bound", given["bound"]) if "bound" in given else None,
    )
    if row.routes is None and row.objective is None and row.bound is None:
        raise InputError(f"{where}: states neither routes nor an objective nor a bound")
    return row


def _empty(value: Any) -> bool:
    return value is None or (isinstance(value, str) and not value.strip()) or value != value


def _text(where: str, name: str, value: Any) -> str:
    text = value.strip() if isinstance(value, str) else ""
    if not (0 < len(text) <= LONGEST_NAME and text.isprintable()):
        raise InputError(
            f"{where}: {name} must be one printable line of at most {LONGEST_NAME} characters, got {shown(value)}"
        )
    return text


def _decimal(value: Any) -> Decimal | None:
    """Return the number a cell holds, with the digits it is written with; None where it holds none."""
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        return None
    try:
        number = Decimal(value.strip() if isinstance(value, str) else repr(value).removesuffix(".0"))
    except InvalidOperation:
        return None
    return number if number.is_finite() and math.isfinite(float(number)) else None


def _seconds(where: str, name: str, value: Any, least: float) -> float:
    number = _decimal(value)
    if number is None or not least <= number <= LONGEST:
        wanted = "of at least 0" if least == 0 else "above 0"
        raise InputError(f"{where}: {name} must be a number of seconds {wanted}, got {shown(value)}")
    return float(number)


def _whole(where: str, name: str, value: Any, least: int, most: int) -> int:
    number = _decimal(value)
    if number is None or number != number.to_integral_value() or not least <= number <= most:
        raise InputError(f"{where}: {name} must be a whole number from {least} to {most}, got {shown(value)}")
    return int(number)


def _number(where: str, name: str, value: Any) -> Stated:
    number = _decimal(value)
    if number is None:
        raise InputError(f"{where}: {name} must be a number of seconds, got {shown(value)}")
    return stated(number)
