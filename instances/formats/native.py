"""Native instance files: JSON, or JSON compressed by gzip.

Its keys are declared in `instances.declared.instance`. Floats are written with the shortest digits that read back as
the same float64; the same instance gives the same bytes.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from instances.arrays import Floats
from instances.declared.instance import SCHEMA, InstanceTable, MetricTable, TravelTable
from instances.declared.reading import read_declared
from instances.disk import read_unpacked, write_aside
from instances.documents import json_of, text_of
from instances.errors import InputError, naming, shown
from instances.formats.format import Format
from instances.instance import MAX_NODES, Instance, check_size
from instances.metric_costs import MATRIX_NODES
from instances.metrics import metric_cost
from instances.travel import Travel

ROWS_UP_TO = 300
"""Nodes up to which costs are written as rows, for other readers' sake; beyond, by metric where they have one."""


def read_native(path: Path) -> Instance:
    """Read a native file; InputError names the file, the field and the value that cannot be used."""
    content = read_unpacked(path)
    with naming(path):
        rest, cost = _costs_apart(content) or (content, None)
        return instance_of(json_of(text_of(rest)), cost)


def write_native(instance: Instance, path: Path) -> None:
    """Write a native file, compressed where `path` ends in ``.gz``."""
    with naming(path):
        content = document_text(instance).encode("ascii")
    write_aside(path, gzip.compress(content, mtime=0) if path.name.lower().endswith(".gz") else content)


def instance_of(document: Any, cost: Floats | None = None) -> Instance:
    """Return the Instance a parsed native file describes; InputError names the field and the value.

    cost : (N, N) [s], where they were read apart.
    """
    if isinstance(document, dict) and isinstance(document.get("schema"), int) and document["schema"] > SCHEMA:
        raise InputError(f"schema {shown(document['schema'])} is of a newer version; this one reads up to {SCHEMA}")
    said = read_declared(InstanceTable, document, toml=False)
    size = said.n_tasks, said.n_depots
    check_size(*size, MAX_NODES if isinstance(said.cost, MetricTable) else MATRIX_NODES)
    nodes = sum(size)
    coordinates = None if said.coordinates is None else _rows(said.coordinates, "coordinates", nodes, 2)
    travel = None if said.travel is None else travel_of(said.travel)
    provenance = said.provenance
    if isinstance(said.cost, MetricTable):
        if coordinates is not None and not np.isfinite(coordinates).all():
            raise InputError("coordinates must be finite")
        provenance = {**provenance, "metric": document["cost"]}
        if nodes > MATRIX_NODES:
            more = {"provenance": provenance, "endurance": _endurance(said.endurance, size[1])}
            return _without_matrix(said.name, document["cost"], coordinates, *size, **more)
        matrix = metric_cost(document["cost"], coordinates)
    elif (rows := said.cost if cost is None else cost) is not None:
        matrix = _rows(rows, "cost", nodes, nodes)
    elif travel is not None:
        matrix = travel.least()
    else:
        raise InputError("the key 'cost' is missing")
    return Instance(said.name, matrix, *size, coordinates, provenance, travel, _endurance(said.endurance, size[1]))


def _without_matrix(name: str, metric: Any, coordinates: Floats | None, *size: int, **more: Any) -> Instance:
    if coordinates is None:
        raise InputError(f"cost: the metric '{metric['metric']}' needs coordinates")
    return Instance.of_metric(name, metric, coordinates, *size, **more)


def travel_of(said: TravelTable) -> Travel:
    """Return the Travel of a declared ``travel`` object; InputError names the field and the value."""
    states = len(said.cost[0][0]) if said.cost and said.cost[0] else 0
    classes = []
    for g, knots in enumerate(said.cost):
        if len(knots) != len(said.cost[0]):
            raise InputError(f"travel.cost[{g}] has {len(knots)} knots, must have {len(said.cost[0])}")
        classes += [_rows(rows, f"travel.cost[{g}][{q}]", states, states) for q, rows in enumerate(knots)]
    shape = (len(said.cost), len(said.cost[0]) if said.cost else 0, states, states)
    cost = _unlimited(np.array(classes).reshape(shape))
    departures = np.array(said.departures)
    return Travel(cost, said.classes, departures, said.nodes, said.closed, said.window)  # type: ignore[arg-type]  # made arrays there


def _endurance(value: list[float | None] | None, n_depots: int) -> Floats | None:
    if value is None:
        return None
    if len(value) != n_depots:
        raise InputError(f"endurance must be a list of n_depots = {n_depots} numbers [s] or null, got {shown(value)}")
    return _unlimited(np.array(value, dtype=np.float64))


def _unlimited(numbers: Floats) -> Floats:
    """Return numbers with +inf where the file says null."""
    return np.where(np.isnan(numbers), np.inf, numbers)


def document_text(instance: Instance) -> str:
    """Return the native file of `instance` as text, a row of numbers a line."""
    coordinates = "null" if instance.coordinates is None else _row_lines(instance.coordinates)
    metric = instance.provenance.get("metric") if instance.by_metric is None else instance.by_metric.metric
    by_metric = instance.by_metric is not None or (
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
        cost = np.empty((size, size)) if size <= MATRIX_NODES else np.empty((0, 0))
        for i, row in enumerate(rows):
            numbers = msgspec.json.decode(row, type=list[float])
            if len(numbers) != len(cost):
                return None
            cost[i] = numbers
    except (KeyError, ValueError, RecursionError, msgspec.MsgspecError):  # ValueError: keys that are no UTF-8
        return None
    before, _, after = content.rpartition(raw)
    return before + b"null" + after, cost


def _rows(value: Sequence[Sequence[float | None]] | Floats, label: str, count: int, width: int) -> Floats:
    """Return `count` rows of `width` numbers, NaN for null."""
    if len(value) != count:
        raise InputError(f"{label} has {len(value)} rows, must have n_tasks + n_depots = {shown(count)}")
    for i, row in enumerate(value):
        if len(row) != width:
            raise InputError(f"{label}[{i}] has {len(row)} entries, must have {width}")
    return np.array(value, dtype=np.float64)


def _row_lines(array: Floats) -> str:
    return "[\n" + ",\n".join(json.dumps(row, separators=(",", ":")) for row in array.tolist()) + "\n]"


def _travel_text(travel: Travel) -> str:
    """Return ``travel`` as text, a row of numbers a line."""
    knots = (
        ["[\n" + ",\n".join(json.dumps(_nulls(row)) for row in rows) + "\n]" for rows in each] for each in travel.cost
    )
    cost = ",\n".join("[" + ",\n".join(each) + "]" for each in knots)
    rest = {name: json.dumps(getattr(travel, name).tolist()) for name in ("classes", "departures", "nodes")}
    rest |= {"closed": "true"} if travel.closed else {}
    rest |= {"window": json.dumps(travel.window)} if travel.window else {}
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
