"""The total bound of tours no longer than the best routes known, and the arcs that these leave.

The programme of ``timed_arcs.py`` under the cap U, cut by the sets that need more UAVs than enter them (``needs.py``),
÷ Σ_k w_k as in ``total.py``: routes of a longest tour up to U keep all its rows. Strong where tours are long, most of
all from one site; where they are short, whole tours (``columns/``) are stronger.

Σ_k w_k C_k ≤ U·Σ_k w_k of such routes besides: arcs whose reduced cost is above what is left to that are in none.

Legs cost what the cheapest way over tasks does, so that a tour gets no shorter by more tasks, which sets need: routes
cost no less than that, and what an arc costs more counts where it is flown.
"""

from __future__ import annotations

import time
from collections.abc import Hashable
from typing import NamedTuple

import numpy as np

from formulations.routing.arc_programme import ArcProgramme
from formulations.routing.needs import Needs
from formulations.routing.simple_bounds import least_costs, ways_between_tasks, ways_from_depot
from formulations.routing.timed_arcs import TimedArcs
from formulations.routing.total import arc_costs
from instances import Instance
from instances.arrays import Bools, Floats

MOST_TASKS = 600
"""Beyond this a round of looking for sets takes seconds, and a limit of time would be passed by as much."""
_ROUNDING = 1e-9
"""Share by which the cap is above the routes known."""
_GAIN, _DULL = 2e-4, 10
"""Share of the cap that a round is to gain, and how many in turn may gain less."""


class CappedTotal(NamedTuple):
    """The `bound` [s], whether nothing more was found to cut off, and the arcs that routes as good may use, (N, N)."""

    bound: float
    complete: bool
    arcs: Bools


def capped_total(instance: Instance, upper: float, time_limit: float) -> CappedTotal:
    """Return the bound, at most `upper` [s], the cost of routes known, and the arcs of routes that cost no more.

    0 and all arcs where not even the first programme was solved within `time_limit` [s].
    """
    end, n, m = time.perf_counter() + time_limit, instance.n_tasks, instance.n_depots
    dear, weight = arc_costs(instance, upper)
    cost, cap, arcs = _cheapest_ways(dear, n), upper * (1 + _ROUNDING), np.isfinite(dear)
    legs = _cheapest_ways(np.minimum(least_costs(instance)[0].min(axis=0), 2 * upper), n)
    excess = np.where(arcs, dear, 0.0) - np.where(arcs, cost, 0.0)
    whole, timed = ArcProgramme(cost, n, m, upper), TimedArcs(cost, legs, n, m, cap)

    def alone(held: Bools, fleet: int) -> ArcProgramme:
        """Return the programme of the tasks held, with what is known of sets of them."""
        nodes = np.append(np.flatnonzero(held), np.arange(n, n + m))
        part = np.ix_(nodes, nodes)
        programme = TimedArcs(cost[part], legs[part], int(held.sum()), fleet, cap)
        among = (timed.need > 1) & ~(timed.cuts & ~held).any(axis=1)
        programme.add_sets(timed.cuts[among][:, held], timed.need[among])
        return programme

    needs, dull, complete = Needs((whole, timed), alone, cap), 0, False
    solved = whole.solve_all(end)
    while solved and dull < _DULL and not complete:
        before = timed.sum
        solved = timed.solve_all(end)
        if timed.solved:
            # what is no number excludes nothing
            arcs &= ~(timed.last + timed.reduced + excess > cap * weight * (1 + _ROUNDING))
        dull = dull + 1 if timed.sum - before < _GAIN * cap * weight else 0
        sets, need = needs.find(timed.entered(), end) if solved else (timed.cuts[:0], timed.need[:0])
        timed.add_sets(sets, need)
        complete = solved and not len(sets) and time.perf_counter() < end
    return CappedTotal(min(upper, max(whole.sum, timed.sum) / weight), complete, _of_all_alike(arcs, instance))


def _of_all_alike(arcs: Bools, instance: Instance) -> Bools:
    """Return the arcs without those that a UAV like theirs may not fly: routes stay as good when they change names."""
    n, same = instance.n_tasks, dict[tuple[Hashable, ...], list[int]]()
    for depot, of_class, limit in zip(
        instance.depots, instance.classes.tolist(), instance.limits.tolist(), strict=True
    ):
        legs = instance.class_costs[of_class]
        same.setdefault((of_class, limit, legs[depot, :n].tobytes(), legs[:n, depot].tobytes()), []).append(depot)
    for depots in same.values():
        arcs[depots, :n] = arcs[depots, :n].all(axis=0)
        arcs[:n, depots] = arcs[:n, depots].all(axis=1, keepdims=True)
    return arcs


def _cheapest_ways(cost: Floats, n_tasks: int) -> Floats:
    """Return the cost of the cheapest ways over tasks [s], (N, N), infinite where there are none."""
    ways, between = np.full_like(cost, np.inf), ways_between_tasks(cost, n_tasks)
    ways[:n_tasks, :n_tasks] = between
    np.fill_diagonal(ways, np.inf)
    for k in range(n_tasks, len(cost)):
        ways[k, :n_tasks], ways[:n_tasks, k] = ways_from_depot(cost, between, k)
    return ways
