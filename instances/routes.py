"""Routes and their independent check: no solver grades itself.

A route's cost is the paper's C_k (eq. costsum): depot to first task, task to task, last task back to depot.
C_max = max_k C_k (eq. c_max) is what the min-max problem minimises. Where a UAV may wait before take-off, C_k is when
it lands, and its endurance counts from its take-off.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import index

import numpy as np

from instances.arrays import Bools, Floats, Ints
from instances.instance import Instance
from instances.take_off import take_off

ENDURANCE_ROUNDING = 1e-9
"""Share by which C_k may pass L_k: what summing the legs in another order can make of it."""

Routes = tuple[tuple[int, ...], ...]
"""For each depot, in depot order, its tasks in flying order; empty when the UAV stays home."""


def as_routes(routes: Iterable[Iterable[int]]) -> Routes:
    """Return `routes` as a tuple of tuples of Python ints; TypeError where a task is no whole number."""
    return tuple(tuple(map(index, route)) for route in routes)


def check_routes(instance: Instance, routes: Sequence[Sequence[int]], *, all_tasks: bool = True) -> list[str]:
    """Return what is wrong with `routes`, a sentence each; an empty list means feasible.

    Feasible: one route per depot, and every task on exactly one route exactly once (eqs. const1–const4, const6), on
    legs its UAV can fly and within its endurance.

    Parameters
    ----------
    instance
        What they are routes of.
    routes
        For each depot, in depot order, its tasks in flying order; empty when the UAV stays home.
    all_tasks
        Whether every task must be visited; else a task may be left out.

    Returns
    -------
    list of str
        Sentences in which UAVs are called 0 to m − 1, as everywhere.
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
                faults.append(f"UAV {k} visits {node}, which is not a task (tasks are 0 to {instance.n_tasks - 1}).")
    faults += [f"Task {task} is visited by no route." for task, times in visits.items() if times == 0 and all_tasks]
    faults += [f"Task {task} is visited {times} times." for task, times in visits.items() if times > 1]
    return faults or _unflyable(instance, routes)


def _unflyable(instance: Instance, routes: Sequence[Sequence[int]]) -> list[str]:
    """Return which UAVs cannot fly their route, and which not on one battery."""
    if not instance.axes:
        return []
    flights = tour_costs(instance, routes) - take_offs(instance, routes)
    faults = [f"UAV {k} has a leg that it cannot fly." for k in np.flatnonzero(np.isinf(flights))]
    waits = instance.travel is not None and "window" in instance.axes
    most = " however long it waits" if waits else ""
    return faults + [
        f"UAV {k} takes {flights[k]:.9g} s, more than its endurance of {instance.limits[k]:.9g} s{most}."
        for k in np.flatnonzero(past_endurance(instance, flights) & np.isfinite(flights))
    ]


def past_endurance(instance: Instance, flights: Floats) -> Bools:
    """Return which `flights` [s] from take-off to landing, shape (m,), are longer than their UAV can fly."""
    return flights > instance.limits * (1 + ENDURANCE_ROUNDING)


def take_offs(instance: Instance, routes: Sequence[Sequence[int]]) -> Floats:
    """Return when each UAV takes off [s], shape (m,): as early as its endurance lets it (``take_off.py``).

    0 for all where they may not wait, and for a UAV that stays home; where no take-off is within endurance, that of
    the least flight.
    """
    times = np.zeros(len(routes))
    if instance.travel is not None and "window" in instance.axes:
        for k in (k for k, route in enumerate(routes) if len(route)):
            stops = _stops(instance, k, routes[k])
            if instance.travel.tour_cost(k, stops) > instance.limits[k] * (1 + ENDURANCE_ROUNDING):
                times[k] = take_off(instance.travel, k, stops, float(instance.limits[k]))
    return times


def _stops(instance: Instance, k: int, route: Sequence[int]) -> Ints:
    return np.array([instance.n_tasks + k, *route, instance.n_tasks + k])


def tour_costs(instance: Instance, routes: Sequence[Sequence[int]]) -> Floats:
    """Return C_k [s] of each UAV (paper, eq. costsum).

    The one place that knows of classes, clocks and states.

    Parameters
    ----------
    instance
        What they are routes of.
    routes
        For each depot, in depot order, its tasks in flying order.

    Returns
    -------
    numpy.ndarray
        Shape (m,) [s], landings where UAVs wait; 0 for a UAV that stays home, +inf where a leg cannot be flown.
    """
    costs, times = np.zeros(len(routes)), take_offs(instance, routes)
    for k, route in enumerate(routes):
        if len(route):
            stops = _stops(instance, k, route)
            if instance.travel is None:
                costs[k] = instance.cost[stops[:-1], stops[1:]].sum()
            else:
                costs[k] = instance.travel.tour_cost(k, stops, float(times[k]))
    return costs


def objective(instance: Instance, routes: Sequence[Sequence[int]]) -> float:
    """Return C_max [s] of complete routes, +inf where a UAV cannot fly its tour."""
    costs = tour_costs(instance, routes)
    past = past_endurance(instance, costs - take_offs(instance, routes)).any()
    return float("inf") if past else float(costs.max())


def makespan(instance: Instance, routes: Sequence[Sequence[int]]) -> float:
    """Return C_max [s], the cost of the longest tour (paper, eq. c_max), whatever the UAVs' endurance."""
    return float(tour_costs(instance, routes).max())
