"""Symmetries: which routes differ by no more than names of UAVs or the direction in which a tour is flown."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from instances import Instance, Routes


def shared_depots(instance: Instance) -> list[list[int]]:
    """Return the groups of depots (node numbers, in order) whose UAVs can exchange their tours.

    They have the same costs from and to every task, at all times, and their UAVs are of one class and one endurance.
    """
    n = instance.n_tasks
    groups: dict[tuple[int, float, bytes], list[int]] = {}
    for uav, k in enumerate(instance.depots):
        travel = instance.travel
        cost = instance.cost[None] if travel is None else travel.cost[travel.classes[uav]]
        ends = cost[:, k, :n].tobytes() + cost[:, :n, k].tobytes()
        groups.setdefault((int(instance.classes[uav]), float(instance.limits[uav]), ends), []).append(k)
    return list(groups.values())


def neighbours(instance: Instance) -> list[tuple[int, int]]:
    """Return the pairs of UAVs, one after the other in a group of `shared_depots`."""
    return [pair for group in shared_depots(instance) for pair in pairwise(group)]


def is_symmetric(instance: Instance) -> bool:
    """Return whether every arc in use costs every UAV the same both ways, so that a tour may be flown backwards."""
    n, costs = instance.n_tasks, instance.class_costs
    return bool((costs[:, :n, :] == costs[:, :, :n].transpose(0, 2, 1)).all())


def in_order(instance: Instance, routes: Routes) -> Routes:
    """Return `routes` with those of a shared depot ordered by their smallest task, empty ones last.

    Where costs are symmetric, a route also starts with the smaller of its two ends.
    """
    ordered = list(routes)
    for group in shared_depots(instance):
        best = sorted((routes[k - instance.n_tasks] for k in group), key=lambda route: min(route, default=np.inf))
        for k, route in zip(group, best, strict=True):
            ordered[k - instance.n_tasks] = route
    if is_symmetric(instance):
        ordered = [route if not route or route[0] <= route[-1] else route[::-1] for route in ordered]
    return tuple(ordered)


def used_arcs(instance: Instance, routes: Sequence[Sequence[int]]) -> set[tuple[int, int, int]]:
    """Return the (i, j, k) with θ_ijk = 1 in `routes`."""
    used = set()
    for k, route in zip(instance.depots, routes, strict=True):
        if route:
            used |= {(i, j, k) for i, j in pairwise([k, *route, k])}
    return used
