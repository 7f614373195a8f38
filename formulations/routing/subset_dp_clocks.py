"""Held–Karp by the clock, for `subset-dp` where costs change with time: earliest arrivals instead of least costs.

    f_k({j}, j) = c_kj(0),   f_k(S, j) = min_{i ∈ S∖j} a + c_ij(a),  a = f_k(S∖j, i)
    t_k(S)      = min_{j ∈ S} a + c_jk(a),  a = f_k(S, j)

exact because who departs later never arrives earlier (`Travel` checks it): a ≤ b ⇒ a + c(a) ≤ b + c(b), so the earliest
arrival at the last task of a set is never worse than a later one. It would not be with the paper's energy, whose UAV
arrives after |σ|/v0 whatever the wind, and so whatever the energy.

Floating point: every arrival is lowered by a share 2⁻⁵⁰, more than its rounding, so that by the same rule no t_k(S) is
above the true one however steep the costs are; routes are costed by `instances.routes`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from formulations.routing.clocks import Clocks, clocks_of, leg_at
from instances import Instance
from instances.arrays import Floats, Ints
from instances.kernels import njit

Extend = Callable[[int, int, Floats, Floats], None]
"""Fills path and tour for the sets from one number to before another."""

_DOWN = 1 - 2.0**-50


def arrivals(instance: Instance, k: int) -> Extend:
    """Return what fills f (2ⁿ, n) and t (2ⁿ,) [s] of UAV k for the sets low..high−1, those before being filled."""
    clocks, tasks, depot = clocks_of(instance), np.arange(instance.n_tasks), instance.n_tasks + k
    return lambda low, high, path, tour: _extend(low, high, clocks, k, tasks, depot, path, tour)


def earliest_order(instance: Instance, k: int, tasks: list[int]) -> tuple[int, ...]:
    """Return `tasks` (at most 22 or so) in the order in which UAV k is home first."""
    clocks, depot = clocks_of(instance), instance.n_tasks + k
    g, nodes = int(clocks.classes[k]), np.array(tasks)
    path, tour = np.empty((1 << len(tasks), len(tasks))), np.zeros(1 << len(tasks))
    _extend(1, 1 << len(tasks), clocks, k, nodes, depot, path, tour)
    order, rest, following = [], (1 << len(tasks)) - 1, depot
    while rest:
        members, before = [i for i in range(len(tasks)) if rest >> i & 1], path[rest]
        j = min(members, key=lambda i: float(before[i] + leg_at(clocks, g, tasks[i], following, before[i])))
        order.append(tasks[j])
        rest, following = rest ^ 1 << j, tasks[j]
    return tuple(reversed(order))


@njit(cache=True)
def _extend(low: int, high: int, clocks: Clocks, k: int, tasks: Ints, depot: int, path: Floats, tour: Floats) -> None:
    """Fill f and t of the sets low..high−1 of `tasks`; every subset of a set has a smaller number."""
    n, g = tasks.size, clocks.classes[k]
    members = np.empty(n, np.int64)
    for s in range(low, high):
        size = 0
        for j in range(n):
            if s >> j & 1:
                members[size] = j
                size += 1
        best_tour = np.inf
        for a in range(size):
            j = members[a]
            if size == 1:
                best = leg_at(clocks, g, depot, tasks[j], 0.0)
            else:
                best = np.inf
                before = path[s ^ (1 << j)]
                for b in range(size):
                    i = members[b]
                    if i != j and before[i] < best:
                        best = min(best, before[i] + leg_at(clocks, g, tasks[i], tasks[j], before[i]))
            best *= _DOWN
            path[s, j] = best
            best_tour = min(best_tour, (best + leg_at(clocks, g, tasks[j], depot, best)) * _DOWN)
        tour[s] = best_tour
