"""Which node of a TSPLIB, LKH or VRPLIB file each of our nodes is.

These formats number nodes from 1, the depot first. VRPLIB's solutions number *customers*: customer i is node i + 1, so
that with one depot they are 1 to n, and a customer is also the row, from 0, of the arrays that readers of VRPLIB make
of an instance (vrplib, PyVRP). With m depots at m places the customers are therefore m to m + n − 1.

An instance that was read from such a file keeps that file's numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from instances.instance import Instance


def file_nodes(instance: Instance) -> list[int]:
    """Return the file's node (from 1) of each of our nodes, (n+m,); UAVs that share a node start at one place."""
    n, m = instance.n_tasks, instance.n_depots
    places = 1 if _together(instance) else m
    kept: Any = instance.provenance.get("nodes")
    if _is_numbering(kept, n, m, places):
        return list(kept)
    return [*range(places + 1, places + 1 + n), *(min(k, places) for k in range(1, m + 1))]


def customers(instance: Instance) -> list[int]:
    """Return VRPLIB's number of the customer that each task is, (n,), rising."""
    return [node - 1 for node in file_nodes(instance)[: instance.n_tasks]]


def first_of_each(nodes: Sequence[int]) -> list[int]:
    """Return our node for each node of a file, in the file's order; the first where several UAVs start there."""
    ours = dict(zip(reversed(nodes), reversed(range(len(nodes))), strict=True))
    return [ours[node] for node in sorted(ours)]


def _together(instance: Instance) -> bool:
    """Return whether all UAVs start at one place, as far as the costs can tell."""
    n, xy = instance.n_tasks, instance.coordinates
    if instance.by_metric is not None:
        return bool((instance.by_metric.coordinates[n:] == instance.by_metric.coordinates[n]).all())
    out, home = instance.cost[n:, :n], instance.cost[:n, n:]
    return bool(
        not instance.cost[n:, n:].any()
        and (out == out[0]).all()
        and (home == home[:, :1]).all()
        and (xy is None or (xy[n:] == xy[n]).all())
    )


def _is_numbering(nodes: Any, n: int, m: int, places: int) -> bool:
    """Return whether `nodes` are those of a file: tasks rising, depots at as many nodes as there are places."""
    if not isinstance(nodes, list) or len(nodes) != n + m or not all(type(node) is int for node in nodes):
        return False
    tasks, depots = nodes[:n], set(nodes[n:])
    rising = bool(np.all(np.diff(tasks) > 0))
    return rising and len(depots) in (m, places) and sorted({*tasks, *depots}) == list(range(1, n + len(depots) + 1))
