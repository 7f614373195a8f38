"""Cheapest ways: what flying to a task and back costs at least, over any tasks on the way.

Costs need not obey the triangle inequality (a detour may be downwind), so a direct arc bounds nothing; the cheapest way
does: the shortest walks over the tasks, then out of and back to a depot.
"""

from __future__ import annotations

from instances.arrays import Floats
from instances.walks import shortest_walks


def ways_between_tasks(cost: Floats, n_tasks: int) -> Floats:
    """Return the cost of the cheapest way from each task to each, over tasks only, shape (n, n), rounded down."""
    return shortest_walks(cost[:n_tasks, :n_tasks]) * (1 - (n_tasks + 2) * 2.0**-52)


def ways_from_depot(cost: Floats, between: Floats, k: int) -> tuple[Floats, Floats]:
    """Return the cheapest ways from depot k (node number) to each task and back, shape (n,) each, rounded down."""
    n = len(between)
    out = (cost[k, :n, None] + between).min(axis=0)
    back = (between + cost[None, :n, k]).min(axis=1)
    return out * (1 - 2.0**-52), back * (1 - 2.0**-52)
