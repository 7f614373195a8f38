"""Inputs: what people have, as an Instance: a matrix, points, a table, a graph, a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from instances import InputError, Instance
from instances.arrays import Floats
from instances.errors import shown

Source: TypeAlias = Any
"""Instance | file | numpy array or rows (N, N) or (N, 2) | pandas.DataFrame | networkx.Graph."""


def instance(
    source: Source, *, depots: int | Sequence[Any] | None = None, speed: float = 1.0, name: str = "instance"
) -> Instance:
    """Return an Instance of what people have.

    Tasks keep their order and are numbered 0..n-1, depots n..n+m-1; where nodes had labels, or were moved, these stand
    in ``provenance["labels"]``.

    Parameters
    ----------
    source
        An Instance, as it is; a file: an instance in any known format, a scenario (``.toml``, whose costs are
        planned), or a matrix of costs (``.csv``); a square array or DataFrame of costs [s], (N, N), entry [i, j] from i
        to j; points [m], (N, 2), flown in straight lines at `speed`; a networkx graph whose edges have a ``weight``
        [s], nodes being as far apart as the shortest path between them.
    depots
        Which nodes are depots: how many, the last ones; or their numbers, a DataFrame's or graph's their labels.
        The same node twice is two UAVs there. Beside points also the depots' own places [m], (m, 2).
    speed
        At which points are flown between [m/s].
    name
        Of the instance, where it has none.

    Returns
    -------
    Instance
        Frozen and validated.

    Raises
    ------
    InputError
        For what cannot be used, with one sentence that names it.
    """
    if isinstance(source, Instance):
        return _alone(source, depots)
    if isinstance(source, (str, Path)):
        return _from_file(Path(source), depots, speed)
    if hasattr(source, "adjacency") and hasattr(source, "nodes"):
        return _from_graph(source, depots, name)
    if hasattr(source, "columns") and hasattr(source, "to_numpy"):
        return _from_table(source, depots, speed, name)
    array = _numbers(source, "a problem")
    return _from_array(array, depots, speed, name, list(range(len(array))))


def _alone(made: Instance, depots: Any) -> Instance:
    if depots is not None:
        raise InputError(f"depots: {made.name} has its own {made.n_depots}")
    return made


def _from_file(path: Path, depots: Any, speed: float) -> Instance:
    from instances.files import read_instance
    from instances.scenario import read_scenario

    if path.suffix.lower() == ".toml":
        from workbench.planning import plan

        return _alone(plan(read_scenario(path))[0], depots)
    if path.suffix.lower() != ".csv":
        return _alone(read_instance(path), depots)
    from io import StringIO

    import pandas as pd

    from instances.disk import read_text

    try:
        table = pd.read_csv(StringIO(read_text(path)), header=None)
        if not all(pd.api.types.is_numeric_dtype(kind) for kind in table.dtypes):  # names along both sides
            table = pd.read_csv(StringIO(read_text(path)), index_col=0)
    except (ValueError, pd.errors.ParserError) as error:
        raise InputError(f"{path}: is no table of numbers ({error})") from None
    return _from_table(table, depots, speed, path.stem, where=f"{path}: ")


def _from_table(table: Any, depots: Any, speed: float, name: str, where: str = "") -> Instance:
    """Return the instance of a DataFrame: costs with labels along both sides, or a point a row."""
    array = _numbers(table.to_numpy(), f"{where}a table")
    labels = table.index.tolist()
    if array.shape[0] == array.shape[1] and labels != table.columns.tolist():
        raise InputError(f"{where}a table of costs must have the same labels along both sides")
    return _from_array(array, depots, speed, name, labels)


def _from_graph(graph: Any, depots: Any, name: str) -> Instance:
    import networkx

    labels = list(graph.nodes)
    return _from_array(np.asarray(networkx.floyd_warshall_numpy(graph, labels)), depots, 1.0, name, labels)


def _from_array(array: Floats, depots: Any, speed: float, name: str, labels: list[Any]) -> Instance:
    """Return the instance of costs (N, N) [s] or points (N, 2) [m]; two points alone are points."""
    if depots is None:
        raise InputError("depots is missing: how many of the last nodes are depots, or which")
    if array.ndim != 2 or (array.shape[1] != 2 and array.shape[0] != array.shape[1]):
        raise InputError(f"a problem must be costs (N, N) or points (N, 2), got shape {array.shape}")
    costs = array.shape[0] == array.shape[1] and array.shape != (2, 2)
    if not costs and np.ndim(depots) == 2:
        places = _numbers(depots, "depots")
        if places.shape[1:] != (2,):
            raise InputError(f"depots must be places [m], (m, 2), got shape {places.shape}")
        array, labels = np.concatenate([array, places]), [*labels, *range(len(labels), len(labels) + len(places))]
        depots = len(places)
    order = _order(depots, labels)
    m = depots if isinstance(depots, (int, np.integer)) else len(depots)
    moved = order != list(range(len(labels))) or labels != list(range(len(labels)))
    provenance = {"labels": [_plain(labels[i]) for i in order]} if moved else {}
    if costs:
        return Instance(name, array[np.ix_(order, order)], len(order) - m, int(m), None, provenance)
    if not speed > 0:
        raise InputError(f"speed must be positive [m/s], got {shown(speed)}")
    xy = array[order]
    cost = np.hypot(*(xy[:, None] - xy).transpose(2, 0, 1)) / speed
    return Instance(name, cost, len(order) - m, int(m), xy, provenance)


def _order(depots: Any, labels: list[Any]) -> list[int]:
    """Return the nodes, tasks first, then the depots as asked for; InputError names a depot that is none of them."""
    if isinstance(depots, (int, np.integer)) and not isinstance(depots, bool):
        if not 1 <= depots < len(labels):
            raise InputError(f"depots must be from 1 to {len(labels) - 1} of {len(labels)} nodes, got {depots}")
        return list(range(len(labels)))
    number = {label: i for i, label in enumerate(labels)}
    try:
        chosen = [number[depot] for depot in depots]
    except (KeyError, TypeError):
        raise InputError(f"depots must be how many, or labels of nodes, got {shown(depots)}") from None
    return [i for i in range(len(labels)) if i not in set(chosen)] + chosen


def _numbers(value: Any, what: str) -> Floats:
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} must be an array of numbers, got {shown(value)}") from None


def _plain(label: Any) -> Any:
    """Return a label as a JSON value: a number or a text."""
    return label.item() if isinstance(label, np.generic) else label if isinstance(label, (int, float)) else str(label)
