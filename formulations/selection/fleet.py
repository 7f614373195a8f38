"""Fleet: the UAVs in groups of equal ones, and the legs that fit within their endurance.

Equal are UAVs with the same way out, legs, way home and endurance: whoever of them flies a tour does not matter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.columns.legs import UavLegs
from instances import Instance
from instances.arrays import Bools
from instances.routes import ENDURANCE_ROUNDING
from instances.walks import shortest_walks


class Group(NamedTuple):
    """Equal UAVs: their numbers `uavs`, their `legs` [s], and the `cap` [s] on a tour, finite."""

    uavs: tuple[int, ...]
    legs: UavLegs
    cap: float

    def within(self) -> Bools:
        """Return which tasks lie on some walk from depot to depot that fits, (n,)."""
        return np.asarray(np.isfinite(self.legs.out) | np.isfinite(self.legs.between).any(axis=0))


def groups_of(instance: Instance) -> list[Group]:
    """Return the UAVs of `instance` in groups, each with the legs that some walk within its endurance can use."""
    found: dict[tuple[bytes, ...], list[int]] = {}
    for k in range(instance.n_depots):
        legs = legs_of(instance, k)
        key = (
            legs.out.tobytes(),
            legs.home.tobytes(),
            *(part.tobytes() for part in (instance.classes[k], instance.limits[k])),
        )
        found.setdefault(key, []).append(k)
    groups = []
    for uavs in found.values():
        legs = legs_of(instance, uavs[0])
        limit = float(instance.limits[uavs[0]])
        longest = 1.0 + sum(float(part[np.isfinite(part)].sum()) for part in legs)  # no tour is longer
        cap = min(limit, longest) * (1 + ENDURANCE_ROUNDING)
        groups.append(Group(tuple(uavs), _within(legs, cap), cap))
    return groups


def legs_of(instance: Instance, k: int) -> UavLegs:
    """Return the legs of UAV k; those from a task to itself are forbidden."""
    n, cost = instance.n_tasks, instance.uav_cost(k)
    between = cost[:n, :n].copy()
    np.fill_diagonal(between, np.inf)
    return UavLegs(cost[n + k, :n].copy(), between, cost[:n, n + k].copy())


def _within(legs: UavLegs, cap: float) -> UavLegs:
    """Forbid every leg that no tour of cost ≤ `cap` can use: the shortest walk through it costs more."""
    limit = cap * (1 + 1e-12)
    walk = shortest_walks(legs.between)
    there, back = (legs.out[:, None] + walk).min(axis=0), (walk + legs.home).min(axis=1)
    out = np.where(legs.out + back > limit, np.inf, legs.out)
    between = np.where(there[:, None] + legs.between + back > limit, np.inf, legs.between)
    return UavLegs(out, between, np.where(there + legs.home > limit, np.inf, legs.home))
