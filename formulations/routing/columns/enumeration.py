"""Enumeration: every tour that routes better than the incumbent can still use, as one pool of columns.

By the Lagrangian bound (see `pricing`) routes that use tour p of UAV k cost at least L − r_k + r(p), so a tour with
r(p) ≥ cap − L + r_k is in no better routes. What is left is listed by the same label search without a beam; of the
tours over one set of tasks only the cheapest matters. The list is given up, not cut, when it does not fit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.labelling import search
from formulations.routing.columns.pool import Pool
from formulations.routing.columns.pricing import Duals, Pricer


def enumerate_tours(
    pricer: Pricer, duals: Duals, bound: float, least: NDArray[np.float64], labels: int, room: int
) -> Pool | None:
    """Return the pool at these duals, where `bound` is L and `least` its terms r_k.

    None where it would take more than `room` tours, or `labels` labels of one UAV.
    """
    s, m = pricer.store, pricer.n_uavs
    parts, last, parent = [], [], []
    total = 0
    for k in range(m):
        threshold = pricer.cap - bound + float(least[k])
        found = search(pricer.field(k, duals), s, threshold, pricer.out_of_time, labels=labels, tours=room - total)
        if not found.complete:
            return None
        ends = found.ends
        total += ends.size
        last.append(s.last[: found.labels].copy())
        parent.append(s.parent[: found.labels].copy())
        cost = s.cost[ends] + pricer.legs.home[k][s.last[ends]]
        parts.append((np.full(ends.size, k), s.visited[ends].copy(), cost, ends))
    uav, visited, cost, label = (np.concatenate([part[a] for part in parts]) for a in range(4))
    return Pool(m, uav, visited, cost, label, last, parent)
