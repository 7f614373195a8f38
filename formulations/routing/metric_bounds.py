"""Lower bounds on the longest tour where costs are computed by a metric: of any number of nodes, in seconds.

    farthest       max_i min_k (c_ki + c_ik): a UAV flies to task i and back, and by the triangle inequality no way
                   round is cheaper; metrics that are rounded to nearest or down break it
    nearest-two    Σ_i min(d_i + d_i', 2·min_k c_ik) / 2m with d_i ≤ d_i' the costs to the two nodes nearest to task i:
                   it is entered from one node and left to another, or to the depot it was entered from; where legs
                   cost the same both ways

Each is lowered by what its sum can have been rounded up by.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from instances import Instance
from instances.arrays import Floats, Ints
from instances.metric_costs import MetricCosts

_ROUNDED = 2.0**-45
"""Share by which a cost may be off: some operations, of which an arc's inverse sine loses most."""
_NORM = {"manhattan": 1.0, "maximum": np.inf}


def metric_bounds(instance: Instance, costs: MetricCosts) -> Iterator[tuple[str, float, str]]:
    """Yield name, value [s] and, where there is none, why."""
    rounded = costs.metric.get("rounding") in ("nearest", "down")
    why = "costs that are rounded to nearest or down are no metric" if rounded else ""
    ways = _ways(instance, costs)
    yield "farthest", 0.0 if rounded else float(ways.max()) * (1 - _ROUNDED), why
    if not costs.symmetric:
        yield "nearest-two", 0.0, "legs do not cost the same both ways"
        return
    n, points = instance.n_tasks, costs.coordinates
    p = _NORM.get(costs.metric["metric"], 2.0)
    near: Ints = np.asarray(cKDTree(points).query(points[:n], k=min(3, len(points)), p=p)[1])
    others = near != np.arange(n)[:, None]
    others[others.all(axis=1), -1] = False  # nodes at one place may push out the task itself
    legs = costs.legs(np.arange(n)[:, None], near[others].reshape(n, -1))
    both = np.minimum(legs.sum(axis=1), ways) if legs.shape[1] == 2 else ways
    yield "nearest-two", float(both.sum()) / (2 * instance.n_depots) * (1 - n * 2.0**-52 - _ROUNDED), ""


def _ways(instance: Instance, costs: MetricCosts) -> Floats:
    """Return min_k (c_ki + c_ik) [s] of each task, (n,), a depot at a time."""
    tasks, least = np.arange(instance.n_tasks), np.full(instance.n_tasks, np.inf)
    for depot in instance.depots:
        least = np.minimum(least, costs.legs(np.array(depot), tasks) + costs.legs(tasks, np.array(depot)))
    return least
