"""Moving costs that kernels compute from the places of nodes, for instances too large for a matrix.

Coordinates are divided by the speed, so that distances are times [s]. All of them lie in the processor's cache, where a
matrix of (n+m)² costs would not. What they cost is what `instances.metrics` says, up to rounding.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from instances.arrays import Floats, Ints
from instances.kernels import njit
from instances.metric_costs import MetricCosts

Nodes = NDArray[np.int32]


class Kind(IntEnum):
    """Metrics; WIND is that of `instances.wind_metric`, with or without one."""

    EUCLIDEAN = 0
    MANHATTAN = 1
    MAXIMUM = 2
    ATT = 3
    WIND = 4


ROUNDINGS = ("none", "nearest", "up", "down")
"""By number."""
_MINKOWSKI = {Kind.MANHATTAN: 1.0, Kind.MAXIMUM: np.inf}
"""p of the norm by which near places are found, 2 of the others."""
_CANDIDATES = 2
"""In a wind the nearest are chosen from that many times as many near places."""


class PlaceCosts(NamedTuple):
    """Costs of UAVs that are alike.

    x, y (n+m,): coordinates over speed [s]; kind, rounding: a Kind's value and a number of ROUNDINGS; wind (7,): the
    wind at the origin over the speed (u, v) and what it changes by with x and y (u_x, u_y, v_x, v_y) [1/s], and half
    the modulus of its curl [1/s]; empty in calm air.
    """

    x: Floats
    y: Floats
    kind: int
    rounding: int
    wind: Floats


def place_costs(costs: MetricCosts) -> PlaceCosts:
    """Return the costs of an instance without a matrix."""
    said: Any = costs.said
    kind = Kind[said.__struct_config__.tag.upper()]
    speed = {Kind.EUCLIDEAN: "speed", Kind.WIND: "airspeed"}.get(kind)
    unit = math.sqrt(10.0) if kind is Kind.ATT else getattr(said, speed) if speed else 1.0
    if kind is Kind.WIND and costs.wind is None:
        kind = Kind.EUCLIDEAN
    rounding = ROUNDINGS.index(getattr(said, "rounding", "none"))
    wind = _linear(costs.wind, unit) if kind is Kind.WIND else np.empty(0)
    x, y = (read_only(axis / unit) for axis in costs.coordinates.T)
    return PlaceCosts(x, y, int(kind), rounding, read_only(wind))


def _linear(wind: Any, v0: float) -> Floats:
    """Return `PlaceCosts.wind` of a wind that is linear in position."""
    from instances.wind_metric import vorticity  # here: few instances need it

    far = 1e4
    here, east, north = wind([(0.0, 0.0), (far, 0.0), (0.0, far)])
    by_x, by_y = (east - here) / far, (north - here) / far
    return np.array([*(here / v0), by_x[0], by_y[0], by_x[1], by_y[1], 0.5 * abs(vorticity(wind))])


@njit(cache=True, nogil=True)
def place_leg(costs: PlaceCosts, u: int, w: int) -> float:
    """Return what a leg takes from node u to node w [s]."""
    dx, dy = costs.x[w] - costs.x[u], costs.y[w] - costs.y[u]
    if costs.kind == Kind.MANHATTAN.value:
        d = abs(dx) + abs(dy)
    elif costs.kind == Kind.MAXIMUM.value:
        d = max(abs(dx), abs(dy))
    else:
        d = math.sqrt(dx * dx + dy * dy)
    if costs.kind == Kind.WIND.value:
        return _in_wind(costs, u, w, d)
    if costs.rounding == 1:
        return float(math.floor(d + 0.5))
    if costs.rounding == 2 or costs.kind == Kind.ATT.value:
        return float(math.ceil(d))
    return d if costs.rounding == 0 else float(math.floor(d))


@njit(cache=True, nogil=True)
def _in_wind(costs: PlaceCosts, u: int, w: int, tau: float) -> float:
    """Return what a leg of τ [s] in calm air takes in the wind [s]: that at its middle times its chord, and its arc."""
    wind, s = costs.wind, costs.wind[6] * tau
    x, y = 0.5 * (costs.x[u] + costs.x[w]), 0.5 * (costs.y[u] + costs.y[w])
    along = (costs.x[w] - costs.x[u]) * (wind[0] + wind[2] * x + wind[3] * y)
    along += (costs.y[w] - costs.y[u]) * (wind[1] + wind[4] * x + wind[5] * y)
    if 0.0 < s <= 1.0:
        tau *= 0.5 * (math.asin(s) / s + math.sqrt(1.0 - s * s))
    return tau - along


@njit(cache=True, nogil=True)
def _cheapest(costs: PlaceCosts, candidates: Nodes, out: Nodes) -> None:
    """Write to each row of `out` the candidates of that row that are cheapest to fly to or from, these first."""
    for v in range(out.shape[0]):
        held = np.empty(candidates.shape[1])
        for i in range(held.size):
            held[i] = min(place_leg(costs, v, candidates[v, i]), place_leg(costs, candidates[v, i], v))
        order = np.argsort(held)
        for i in range(out.shape[1]):
            out[v, i] = candidates[v, order[i]]


def near_places(costs: PlaceCosts, n_tasks: int, n_near: int, n_near_depots: int) -> tuple[Nodes, Nodes]:
    """Return the nearest tasks (n, ·) and the nearest depots (n, ·) of every task, nearest first."""
    points = np.column_stack([costs.x, costs.y])
    tasks, depots = points[:n_tasks], points[n_tasks:]
    width, width_depots = min(n_near, n_tasks - 1), min(n_near_depots, len(depots))
    more = _CANDIDATES if costs.kind == Kind.WIND else 1
    found = _nearest(costs.kind, tasks, tasks, min(more * width, n_tasks - 1) + 1)
    others = found != np.arange(n_tasks)[:, None]
    others[others.all(axis=1), -1] = False  # nodes at one place may push out the task itself
    found = found[others].reshape(n_tasks, -1)
    homes = n_tasks + _nearest(costs.kind, tasks, depots, min(more * width_depots, len(depots)))
    if costs.kind != Kind.WIND:
        return found, homes
    chosen = np.empty((n_tasks, width), np.int32), np.empty((n_tasks, width_depots), np.int32)
    _cheapest(costs, found, chosen[0])
    _cheapest(costs, homes, chosen[1])
    return chosen


def _nearest(kind: int, points: Floats, among: Floats, count: int) -> Nodes:
    """Return which places `among` others lie nearest to each of the points, (k, count)."""
    from scipy.spatial import cKDTree  # here: few instances need it, and it takes its time

    found = cKDTree(among).query(points, k=np.arange(1, count + 1), p=_MINKOWSKI.get(Kind(kind), 2.0))[1]
    return np.asarray(found, dtype=np.int32)


def place_sites(costs: PlaceCosts, n_tasks: int) -> Ints:
    """Return for each depot the first depot at the same place, shape (m,)."""
    at = np.column_stack([costs.x, costs.y])[n_tasks:]
    _, first, which = np.unique(at, axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[which.ravel()], dtype=np.int64)


def read_only(array: Any) -> Any:
    """Return the array contiguous and read only, the type the kernels are compiled for; copied where it is neither."""
    if array.flags.writeable or not array.flags.c_contiguous:
        array = np.array(array, order="C")
        array.setflags(write=False)
    return array
