"""Routes and their independent check: no solver grades itself.

A route's cost is the paper's C_k (eq. costsum): depot to first task, task to task, last task back to depot.
C_max = max_k C_k (eq. c_max) is what the min-max problem minimises.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import index

import numpy as np

from instances.arrays import Floats
from instances.instance import Instance

Routes = tuple[tuple[int, ...], ...]
"""For each depot, in depot order, its tasks in flying order; empty when the UAV stays home."""


def as_routes(routes: Iterable[Iterable[int]]) -> Routes:
    """Return `routes` as a tuple of tuples of Python ints; TypeError where a task is no whole number."""
    return tuple(tuple(map(index, route)) for route in routes)


def check_routes(instance: Instance, routes: Sequence[Sequence[int]]) -> list[str]:
    """Return what is wrong with `routes`, a sentence each; an empty list means feasible.

    Feasible: one route per depot, and every task on exactly one route exactly once (eqs. const1–const4, const6).
    Routes are called #1 to #m, as in ``.sol`` files.
    """
    faults = []
    if len(routes) != instance.n_depots:
        faults.append(f"There are {len(routes)} routes for {instance.n_depots} depots.")
    visits = dict.fromkeys(instance.tasks, 0)
    for k, route in enumerate(routes):
        for node in route:
            if node in visits:
                visits[node] += 1
            else:
                faults.append(
                    f"Route #{k + 1} visits {node}, which is not a task (tasks are 0 to {instance.n_tasks - 1})."
                )
    faults += [f"Task {task} is visited by no route." for task, times in visits.items() if times == 0]
    faults += [f"Task {task} is visited {times} times." for task, times in visits.items() if times > 1]
    return faults


def tour_costs(instance: Instance, routes: Sequence[Sequence[int]]) -> Floats:
    """Return C_k [s] of each UAV, shape (m,) (paper, eq. costsum); 0 for a UAV that stays home."""
    costs = np.zeros(len(routes))
    for k, route in enumerate(routes):
        if len(route):
            stops = np.array([instance.n_tasks + k, *route, instance.n_tasks + k])
            costs[k] = instance.cost[stops[:-1], stops[1:]].sum()
    return costs


def makespan(instance: Instance, routes: Sequence[Sequence[int]]) -> float:
    """Return C_max [s], the cost of the longest tour (paper, eq. c_max)."""
    return float(tour_costs(instance, routes).max())
