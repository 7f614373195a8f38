"""Tours of a selection, and the kernels that change them: insert, remove, straighten. Fleet and endurance included.

Data of the UAVs stand side by side: `way` maps each UAV to its matrix of legs (a class), so that equal UAVs share it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.selection.fleet import groups_of
from formulations.selection.worth import Worth
from instances import Instance, Routes
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


class Data(NamedTuple):
    """What does not change: legs [s] `out` (G, n), `between` (G, n, n), `home` (G, n), `cap` (G,) [s] of each group of
    equal UAVs, `way` (m,) the group of each UAV; worth: `prizes` (n,), `prior` and `posterior` (n, n), or (0, 0).
    """

    out: Floats
    between: Floats
    home: Floats
    cap: Floats
    way: Ints
    prizes: Floats
    prior: Floats
    posterior: Floats

    @classmethod
    def of(cls, instance: Instance, worth: Worth) -> Data:
        """Gather the data of a problem."""
        groups, none = groups_of(instance), np.zeros((0, 0))
        way = np.zeros(instance.n_depots, np.int64)
        for number, group in enumerate(groups):
            way[list(group.uavs)] = number
        out, between, home = (np.stack([getattr(g.legs, part) for g in groups]) for part in ("out", "between", "home"))
        cap = np.array([g.cap for g in groups])
        prior = none if worth.prior is None else worth.prior
        posterior = none if worth.posterior is None else worth.posterior
        return cls(out, between, home, cap, way, worth.prizes, prior, posterior)


class Tours(NamedTuple):
    """One tour a UAV: its tasks `stops` (m, n), `size` (m,), `cost` (m,) [s]; the `tour` of each task (n,), or −1."""

    stops: NDArray[np.int16]
    size: Ints
    cost: Floats
    tour: Ints

    @classmethod
    def empty(cls, n_tasks: int, n_uavs: int) -> Tours:
        """Return tours of no task."""
        stops = np.zeros((n_uavs, n_tasks), np.int16)
        return cls(stops, np.zeros(n_uavs, np.int64), np.zeros(n_uavs), np.full(n_tasks, -1, np.int64))

    def copy(self) -> Tours:
        """Return the same tours in arrays of their own."""
        return Tours(self.stops.copy(), self.size.copy(), self.cost.copy(), self.tour.copy())

    def routes(self) -> Routes:
        """Return them as routes."""
        return tuple(tuple(row[:size].tolist()) for row, size in zip(self.stops, self.size, strict=True))


@njit(cache=True)
def assign(target: Tours, source: Tours) -> None:
    """Make `target` what `source` is."""
    target.stops[:] = source.stops
    target.size[:] = source.size
    target.cost[:] = source.cost
    target.tour[:] = source.tour


@njit(cache=True)
def length(data: Data, tours: Tours, k: int) -> float:
    """Return the cost [s] of tour k, summed anew."""
    g, row, size = data.way[k], tours.stops[k], tours.size[k]
    if size == 0:
        return 0.0
    total = data.out[g, row[0]] + data.home[g, row[size - 1]]
    for a in range(size - 1):
        total += data.between[g, row[a], row[a + 1]]
    return total


@njit(cache=True)
def best_place(data: Data, tours: Tours, k: int, task: int) -> tuple[float, int]:
    """Return what the cheapest insertion of a task into tour k costs [s], and before which stop; +inf if none fits."""
    g, row, size = data.way[k], tours.stops[k], tours.size[k]
    if size == 0:
        least, at = data.out[g, task] + data.home[g, task], 0
    else:
        least, at = data.out[g, task] + data.between[g, task, row[0]] - data.out[g, row[0]], 0
        for a in range(1, size):
            before, after = row[a - 1], row[a]
            more = data.between[g, before, task] + data.between[g, task, after] - data.between[g, before, after]
            if more < least:
                least, at = more, a
        end = row[size - 1]
        more = data.between[g, end, task] + data.home[g, task] - data.home[g, end]
        if more < least:
            least, at = more, size
    return (least, at) if tours.cost[k] + least <= data.cap[g] else (np.inf, at)


@njit(cache=True)
def insert(data: Data, tours: Tours, k: int, task: int, at: int) -> None:
    """Put a task before stop `at` of tour k."""
    row = tours.stops[k]
    for a in range(tours.size[k], at, -1):
        row[a] = row[a - 1]
    row[at] = task
    tours.size[k] += 1
    tours.tour[task] = k
    tours.cost[k] = length(data, tours, k)


@njit(cache=True)
def remove(data: Data, tours: Tours, leaving: Bools) -> None:
    """Take the tasks `leaving` (n,) out of their tours; a tour that cannot be flown without them is emptied."""
    for k in range(tours.size.size):
        row, kept = tours.stops[k], 0
        for a in range(tours.size[k]):
            if leaving[row[a]]:
                tours.tour[row[a]] = -1
            else:
                row[kept] = row[a]
                kept += 1
        if kept == tours.size[k]:
            continue
        tours.size[k] = kept
        tours.cost[k] = length(data, tours, k)
        if tours.cost[k] > data.cap[data.way[k]]:
            for a in range(kept):
                tours.tour[row[a]] = -1
            tours.size[k], tours.cost[k] = 0, 0.0


@njit(cache=True)
def straighten(data: Data, tours: Tours, k: int) -> None:
    """Shorten tour k by reversing parts of it and moving single tasks, until neither helps (2-opt, relocation)."""
    row, size = tours.stops[k], tours.size[k]
    improved = size > 1
    while improved:
        improved = False
        for a in range(size - 1):
            for b in range(a + 1, size):
                for kind in range(3):  # reverse a..b, move a behind b, move b before a
                    _change(row, a, b, kind)
                    cost = length(data, tours, k)
                    if cost < tours.cost[k] * (1 - 1e-12):
                        tours.cost[k] = cost
                        improved = True
                    else:
                        _change(row, a, b, (0, 2, 1)[kind])


@njit(cache=True)
def _change(row: NDArray[np.int16], a: int, b: int, kind: int) -> None:
    if kind == 0:
        while a < b:
            row[a], row[b] = row[b], row[a]
            a += 1
            b -= 1
    elif kind == 1:
        moved = row[a]
        for c in range(a, b):
            row[c] = row[c + 1]
        row[b] = moved
    else:
        moved = row[b]
        for c in range(b, a, -1):
            row[c] = row[c - 1]
        row[a] = moved
