"""Routes from where UAVs are to where they live: an Instance whose depots' rows and columns are different places.

The row of depot k holds the cost from UAV k's position, its column the cost to its home. Into the row goes what UAV k
has spent already, and by how much its endurance is below the greatest: so the longest tour of the Instance is the
greatest endurance less the least that any UAV has left, and its min-max routes leave most. Only an empty route, which
costs nothing in an Instance, is another matter: the UAV still flies home.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from formulations.limits import Limits
from formulations.routing.search.memetic import Memetic
from instances import Instance, Routes
from instances.arrays import Floats

STEPS = 4000
"""Steps of the search: more shorten tours of thirty tasks by less than half a per cent."""


@dataclass(frozen=True, eq=False)
class OpenRoutes:
    """Tasks of each UAV in flying order, and what endurance [s] each has left at home, shape (m,), negative if none."""

    routes: Routes
    left: Floats


def open_routes(cost: Floats, n_tasks: int, spent: Floats, limits: Floats, steps: int = STEPS) -> OpenRoutes:
    """Return routes that leave the UAV that has least left as much as can be found.

    cost : of legs [s] between the tasks, the m positions and the m homes, in this order. spent, limits : cost so far
    and endurance [s], (m,).
    """
    m = len(spent)
    tasks, here, home = np.arange(n_tasks), n_tasks + np.arange(m), n_tasks + m + np.arange(m)
    handicap = spent + limits.max() - limits
    finite = np.where(np.isfinite(cost), cost, 1e3 * limits.max())
    legs = np.zeros((n_tasks + m, n_tasks + m))
    legs[:n_tasks, :n_tasks] = finite[np.ix_(tasks, tasks)]
    legs[n_tasks:, :n_tasks] = handicap[:, None] + finite[np.ix_(here, tasks)]
    legs[:n_tasks, n_tasks:] = finite[np.ix_(tasks, home)]
    np.fill_diagonal(legs, 0.0)
    routes: Routes = tuple(() for _ in range(m))
    if n_tasks:
        found = Memetic(depth=0.1).solve(Instance("replan", legs, n_tasks, m), limits=Limits(iterations=steps))
        assert found.routes is not None
        routes = found.routes
    stops = [[here[k], *route, home[k]] for k, route in enumerate(routes)]
    needed = np.array([sum(cost[i, j] for i, j in pairwise(s)) for s in stops])
    return OpenRoutes(routes, limits - spent - needed)


def empty_routes(cost: Floats, n_tasks: int, spent: Floats, limits: Floats) -> OpenRoutes:
    """Return what all UAVs have left that fly straight home; arguments as `open_routes`."""
    m = len(spent)
    needed = np.array([cost[n_tasks + k, n_tasks + m + k] for k in range(m)])
    return OpenRoutes(tuple(() for _ in range(m)), limits - spent - needed)
