"""Native instance files: JSON, or JSON compressed by gzip.

``schema`` (1), ``name``, ``n_tasks``, ``n_depots``, ``cost`` [s] as rows or as a named metric
(`instances.metrics`), ``coordinates`` [m] (n+m pairs, or null), ``provenance`` (free); where UAVs, times or states
differ, ``travel`` with ``cost`` [s] (class, knot, state, state; null where a class cannot fly a leg), ``classes``,
``departures`` [s] and ``nodes``, and then ``cost`` is its least and may be left out; ``endurance`` [s] (m numbers, null
where unlimited). Floats are written with
the shortest digits that read back as the same float64; the same instance gives the same bytes.
"""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from instances.arrays import Floats
from instances.disk import read_unpacked, write_aside
from instances.documents import json_of, text_of
from instances.errors import InputError, naming, shown, suggestion
from instances.formats.format import Format
from instances.instance import MAX_NODES, Instance, check_size
from instances.metrics import metric_cost
from instances.travel import Travel

SCHEMA = 1
"""Version of the format that is written, and the newest that is read."""

KEYS = ("schema", "name", "n_tasks", "n_depots", "cost", "coordinates", "provenance", "travel", "endurance")
"""Every key of a file; the last four may be left out, and where there is ``travel`` also ``cost``."""

TRAVEL_KEYS = ("cost", "classes", "departures", "nodes")
"""Every key of ``travel``; the last two may be left out."""

ROWS_UP_TO = 300
"""Nodes up to which costs are written as rows, for other readers' sake; beyond, by metric where they have one."""


def read_native(path: Path) -> Instance:
    """Read a native file; InputError names the file, the field and the value that cannot be used."""
    content = read_unpacked(path)
    with naming(path):
        apart = _costs_apart(content)
        if apart is None:
            return instance_of(json_of(text_of(content)))
        rest, cost = apart
        return instance_of({**json_of(text_of(rest)), "cost": cost})


def write_native(instance: Instance, path: Path) -> None:
    """Write a native file, compressed where `path` ends in ``.gz``."""
    with naming(path):
        content = document_text(instance).encode("ascii")
    write_aside(path, gzip.compress(content, mtime=0) if path.name.lower().endswith(".gz") else content)


def instance_of(document: Any) -> Instance:
    """Return the Instance a parsed native file describes; InputError names the field and the value."""
    if not isinstance(document, dict):
        raise InputError(f"must hold a JSON object, got {type(document).__name__}")
    _check_schema(document.get("schema"))
    for key in document:
        if key not in KEYS:
            raise InputError(f"unknown key {shown(key)}{suggestion(key, KEYS)}")
    for key in ("name", "n_tasks", "n_depots", "cost"):
        if key not in document and not (key == "cost" and "travel" in document):
            raise InputError(f"the key '{key}' is missing")
    for key in ("n_tasks", "n_depots"):
        if not isinstance(document[key], int) or isinstance(document[key], bool) or document[key] < 1:
            raise InputError(f"{key} must be a whole number of at least 1, got {shown(document[key])}")
    check_size(document["n_tasks"], document["n_depots"])
    nodes = document["n_tasks"] + document["n_depots"]
    coordinates = document.get("coordinates")
    if coordinates is not None:
        coordinates = _rows(coordinates, "coordinates", nodes, 2)
    provenance = document.get("provenance", {})
    if not isinstance(provenance, dict):
        raise InputError(f"provenance must be an object, got {shown(provenance)}")
    travel = travel_of(document["travel"]) if document.get("travel") is not None else None
    cost = document.get("cost")
    if cost is None and travel is not None:
        matrix = travel.least()
    elif isinstance(cost, dict):
        if coordinates is not None and not np.isfinite(coordinates).all():
            raise InputError("coordinates must be finite")
        provenance = {**provenance, "metric": cost}
        matrix = metric_cost(cost, coordinates)
    else:
        matrix = _rows(cost, "cost", nodes, nodes)
    size = document["n_tasks"], document["n_depots"]
    limits = _endurance(document.get("endurance"), size[1])
    return Instance(document["name"], matrix, *size, coordinates, provenance, travel, limits)


def travel_of(document: Any) -> Travel:
    """Return the Travel of a parsed ``travel`` object; InputError names the field and the value."""
    if not isinstance(document, dict):
        raise InputError(f"travel must be an object, got {shown(document)}")
    for key in document:
        if key not in TRAVEL_KEYS:
            raise InputError(f"unknown key travel.{shown(key)}{suggestion(key, TRAVEL_KEYS)}")
    for key in TRAVEL_KEYS[:2]:
        if key not in document:
            raise InputError(f"the key 'travel.{key}' is missing")
    cost = document["cost"]
    departures = document.get("departures", [0.0])
    return Travel(
        _travel_cost(cost),
        _list(document["classes"], "travel.classes"),
        _numbers(departures, "travel.departures"),
        _list(document.get("nodes", []), "travel.nodes"),
    )


def _travel_cost(value: Any) -> Floats:
    """Return (G, Q, S, S) numbers, +inf for null."""
    if not isinstance(value, list) or not all(isinstance(knots, list) for knots in value):
        raise InputError(f"travel.cost must be lists of numbers, class by class and knot by knot, got {shown(value)}")
    states = len(value[0][0]) if value and value[0] and isinstance(value[0][0], list) else 0
    classes = []
    for g, knots in enumerate(value):
        if len(knots) != len(value[0]):
            raise InputError(f"travel.cost[{g}] has {len(knots)} knots, must have {len(value[0])}")
        for q, rows in enumerate(knots):
            unknown = isinstance(rows, list) and all(isinstance(row, list) for row in rows)
            finite = [[np.inf if entry is None else entry for entry in row] for row in rows] if unknown else rows
            classes.append(_rows(finite, f"travel.cost[{g}][{q}]", states, states))
    return np.array(classes).reshape(len(value), len(value[0]) if value else 0, states, states)


def _endurance(value: Any, n_depots: int) -> Floats | None:
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != n_depots:
        raise InputError(f"endurance must be a list of n_depots = {n_depots} numbers [s] or null, got {shown(value)}")
    return _numbers([np.inf if each is None else each for each in value], "endurance")


def _numbers(value: Any, label: str) -> Floats:
    return _rows([_list(value, label)], label, 1, len(value))[0]


def _list(value: Any, label: str) -> Any:
    if not isinstance(value, list):
        raise InputError(f"{label} must be a list of numbers, got {shown(value)}")
    return value


def document_text(instance: Instance) -> str:
    """Return the native file of `instance` as text, a row of numbers a line."""
    coordinates = "null" if instance.coordinates is None else _row_lines(instance.coordinates)
    metric = instance.provenance.get("metric")
    by_metric = (
        instance.n_nodes > ROWS_UP_TO
        and isinstance(metric, dict)
        and np.array_equal(metric_cost(metric, instance.coordinates), instance.cost)
    )
    parts = {
        "schema": str(SCHEMA),
        "name": json.dumps(instance.name),
        "n_tasks": str(int(instance.n_tasks)),
        "n_depots": str(int(instance.n_depots)),
        "cost": _json(metric) if by_metric else _row_lines(instance.cost),
        "coordinates": coordinates,
        "provenance": _json(dict(instance.provenance)),
    }
    if instance.travel is not None:
        parts["travel"] = _travel_text(instance.travel)
    if instance.endurance is not None:
        parts["endurance"] = json.dumps(_nulls(instance.endurance))
    return "{\n" + ",\n".join(f'"{key}": {value}' for key, value in parts.items()) + "\n}\n"


def _check_schema(schema: Any) -> None:
    if isinstance(schema, bool) or not isinstance(schema, int) or schema < 1:
        raise InputError(f"schema must be a whole number from 1 to {SCHEMA}, got {shown(schema)}")
    if schema > SCHEMA:
        raise InputError(f"schema {shown(schema)} is of a newer version; this one reads up to {SCHEMA}")


def _costs_apart(content: bytes | bytearray) -> tuple[bytes | bytearray, Floats] | None:
    """Return the file with null in place of its costs, and these; None where they are not a square most of it.

    Row by row this takes a third of the time and a quarter of the memory of the whole document as Python's numbers.
    What is wrong with the file is left to those who say so.
    """
    try:
        raw = memoryview(msgspec.json.decode(content, type=dict[str, msgspec.Raw])["cost"])
        if 2 * len(raw) <= len(content):  # so that it is found once below
            return None
        rows = msgspec.json.decode(raw, type=list[msgspec.Raw])
        size = len(rows)
        cost = np.empty((size, size)) if size <= MAX_NODES else np.empty((0, 0))
        for i, row in enumerate(rows):
            numbers = msgspec.json.decode(row, type=list[float])
            if len(numbers) != len(cost):
                return None
            cost[i] = numbers
    except (KeyError, ValueError, RecursionError, msgspec.MsgspecError):  # ValueError: keys that are no UTF-8
        return None
    before, _, after = content.rpartition(raw)
    return before + b"null" + after, cost


def _rows(value: Any, label: str, count: int, width: int) -> Floats:
    """Return `count` rows of `width` numbers; json has told numbers, texts and truth values apart: so do we."""
    if isinstance(value, np.ndarray) and value.shape == (count, width):
        return value
    if not isinstance(value, (list, np.ndarray)):
        raise InputError(f"{label} must be a list of rows, got {shown(value)}")
    if len(value) != count:
        raise InputError(f"{label} has {len(value)} rows, must have n_tasks + n_depots = {shown(count)}")
    for i, row in enumerate(value):
        if not isinstance(row, list):
            raise InputError(f"{label}[{i}] must be a list of numbers, got {shown(row)}")
        if len(row) != width:
            raise InputError(f"{label}[{i}] has {len(row)} entries, must have {width}")
        if not {*map(type, row)} <= {int, float}:
            j = next(j for j, entry in enumerate(row) if type(entry) not in (int, float))
            raise InputError(f"{label}[{i}][{j}] must be a number, got {shown(row[j])}")
    try:
        return np.array(value, dtype=np.float64)
    except OverflowError:
        raise InputError(f"{label} holds a number too large for float64") from None


def _row_lines(array: Floats) -> str:
    return "[\n" + ",\n".join(json.dumps(row, separators=(",", ":")) for row in array.tolist()) + "\n]"


def _travel_text(travel: Travel) -> str:
    """Return ``travel`` as text, a row of numbers a line."""
    knots = (
        ["[\n" + ",\n".join(json.dumps(_nulls(row)) for row in rows) + "\n]" for rows in each] for each in travel.cost
    )
    cost = ",\n".join("[" + ",\n".join(each) + "]" for each in knots)
    rest = {name: json.dumps(getattr(travel, name).tolist()) for name in TRAVEL_KEYS[1:]}
    return "{" + f'"cost": [{cost}],\n' + ",\n".join(f'"{name}": {text}' for name, text in rest.items()) + "}"


def _nulls(row: Floats) -> list[float | None]:
    return [number if np.isfinite(number) else None for number in row.tolist()]


def _json(value: Any) -> str:
    try:
        return json.dumps(value, allow_nan=False, default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"provenance cannot be written as JSON ({error})") from None


def _plain(value: Any) -> Any:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not a JSON value")


NATIVE = Format(read_native, write_native)
