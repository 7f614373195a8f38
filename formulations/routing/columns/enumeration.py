"""Enumeration: the tours that routes better than the incumbent can still use, UAV by UAV into one pool of columns.

By the Lagrangian bound (see `pricing`) routes that use tour p of UAV k cost at least L − r_k + r(p), so a tour with
r(p) ≥ cap − L + r_k is in no better routes. What is left is listed by the same label search without a beam; of the
tours over one set of tasks only the cheapest matters. The list of a UAV is given up, not cut, when it does not fit.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.columns.labelling import Orders, search
from formulations.routing.columns.pool import Pool
from formulations.routing.columns.pricing import DualBound, Pricer


def list_tours(pool: Pool, pricer: Pricer, at: DualBound, labels: int, room: int) -> tuple[Pool, int]:
    """Return `pool` with the tours of more UAVs, those with few legs first, and the number of labels made in vain.

    It ends at the first UAV that takes more than `labels` labels, or at `room` tours in all.
    """
    s, allowed = pricer.store, at.allowed(pricer.cap)
    n_legs = np.isfinite(pricer.legs.between).sum(axis=(1, 2))
    for k in sorted(np.flatnonzero(~pool.listed).tolist(), key=lambda k: int(n_legs[k])):
        problem, threshold = pricer.subproblem(k, at.duals), float(allowed[k])
        found = search(problem, s, threshold, pricer.out_of_time, labels=labels, tours=room - pool.size)
        if not found.complete:
            return pool, found.labels
        ends = found.ends
        cost = s.cost[ends] + problem.legs.home[s.last[ends]]
        orders = Orders(s.last[: found.labels].copy(), s.parent[: found.labels].copy())
        pool = pool.listing(k, s.visited[ends], cost, ends, orders)
    return pool, 0
