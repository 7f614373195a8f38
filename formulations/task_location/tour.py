"""One closed tour through the tasks and what is sensed along it: the paper's Fig. 1 (tours for 200, 40, 5 tasks).

The tour is the MMMDMTSP with one UAV based at the first task, handed to a registered solver; distances stand for costs.
"""

from __future__ import annotations

import numpy as np

from formulations.limits import Limits
from formulations.routing.registry import make_solver
from instances import Instance
from instances.arrays import Floats

SOLVER = "ruin-recreate"
ITERATIONS = 20_000
PATIENCE = 2_000
"""Iterations a task of the search for an open path, which is drawn and should not cross itself."""


def closed_tour(points: Floats, *, seed: int = 0) -> list[int]:
    """Return the order in which a short closed tour visits `points` (n, 2) [m], from point 0."""
    n = len(points)
    if n < 4:
        return list(range(n))
    order = np.r_[1:n, 0]  # in an Instance tasks come first, depots last
    places = points[order]
    distance = np.linalg.norm(places[:, None] - places[None], axis=2)
    instance = Instance("tour", distance, n - 1, 1, places)
    return [0, *(int(order[task]) for task in _route(instance, seed, SOLVER, ITERATIONS))]


def open_path(points: Floats, *, seed: int = 0) -> list[int]:
    """Return the order in which a short open path visits `points` (n, 2) [m]: a Hamiltonian path.

    It is the tour of a UAV whose depot is no distance from any point.
    """
    n = len(points)
    distance = np.zeros((n + 1, n + 1))
    distance[:n, :n] = np.linalg.norm(points[:, None] - points[None], axis=2)
    if n < 2:
        return list(range(n))
    return list(_route(Instance("path", distance, n, 1), seed, "memetic", PATIENCE * n))


def _route(instance: Instance, seed: int, solver: str, iterations: int) -> tuple[int, ...]:
    """Return a short route of the one UAV of `instance`."""
    method = make_solver(solver)
    method.prepare(instance)
    result = method.solve(instance, limits=Limits(time=20.0, iterations=iterations), seed=seed)
    assert result.routes is not None
    return result.routes[0]


def tour_length(points: Floats, order: list[int]) -> float:
    """Return the length [m] of the closed tour through `points` in `order`."""
    stops = points[[*order, order[0]]]
    return float(np.linalg.norm(np.diff(stops, axis=0), axis=1).sum())


def along(points: Floats, order: list[int], spacing: float) -> Floats:
    """Return places every `spacing` [m] along the closed tour, shape (k, 2) [m], the first at the first task."""
    stops = points[[*order, order[0]]]
    passed = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(stops, axis=0), axis=1))])
    count = max(1, round(passed[-1] / spacing))
    at = np.linspace(0.0, passed[-1], count, endpoint=False)
    return np.stack([np.interp(at, passed, stops[:, d]) for d in (0, 1)], axis=1)
