"""Held–Karp by the clock, for `subset-dp` where costs change with time: earliest arrivals instead of least costs.

    f_k({j}, j) = c_kj(0),   f_k(S, j) = min_{i ∈ S∖j} a + c_ij(a),  a = f_k(S∖j, i)
    t_k(S)      = min_{j ∈ S} a + c_jk(a),  a = f_k(S, j)

exact because who departs later never arrives earlier (`Travel` checks it): a ≤ b ⇒ a + c(a) ≤ b + c(b), so the earliest
arrival at the last task of a set is never worse than a later one. It would not be with the paper's energy, whose UAV
arrives after |σ|/v0 whatever the wind, and so whatever the energy.

Where UAVs may wait before take-off, t_k(S) is the least landing A_S(τ), begun at τ ≤ window, with A_S(τ) − τ ≤ L_k.
As A_S never falls, every such τ that is not before some τ' is not before A_S(τ') − L_k either, so from τ = 0

    τ ← A_S(τ) − L_k   until A_S(τ) − τ ≤ L_k

climbs to the least of them and never passes it (Kleene's iteration): A_S(τ) is a lower bound at every step. Each step
is a recursion for S alone, and the gap shrinks by the factor A_S'(τ); only sets with L_k < t_k(S) ≤ L_k + window at
τ = 0 ask for it.

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
from instances.routes import ENDURANCE_ROUNDING

Extend = Callable[[int, int, Floats, Floats], None]
"""Fills path and tour for the sets from one number to before another."""

_DOWN = 1 - 2.0**-50
_MOST_STEPS = 20_000
"""Of the climb to a take-off; the landing is a lower bound, perhaps of no routes, where flights shrink too slowly."""


def arrivals(instance: Instance, k: int) -> Extend:
    """Return what fills f (2ⁿ, n) and t (2ⁿ,) [s] of UAV k for the sets low..high−1, those before being filled."""
    clocks, tasks, depot = clocks_of(instance), np.arange(instance.n_tasks), instance.n_tasks + k
    return lambda low, high, path, tour: _extend(low, high, clocks, k, tasks, depot, 0.0, path, tour)


def let_wait(instance: Instance, k: int, tour: Floats, below: float, in_time: Callable[[], bool]) -> bool:
    """Make of t_k(S) [s] at take-off 0 the least landings within endurance, `tour` (2ⁿ,); say whether there was time.

    Sets that cannot be flown within it, or that land no earlier than `below` [s], become +inf.
    """
    assert instance.travel is not None
    clocks, limit = clocks_of(instance), float(instance.limits[k])
    late = np.flatnonzero(tour > limit * (1 + ENDURANCE_ROUNDING))
    for s in late.tolist():
        if tour[s] > min(limit * (1 + ENDURANCE_ROUNDING) + instance.travel.window, below):
            tour[s] = np.inf
            continue
        if not in_time():
            return False
        tasks = np.array([i for i in range(instance.n_tasks) if s >> i & 1])
        tour[s], _ = _earliest(instance, clocks, k, tasks)
    return True


def _earliest(instance: Instance, clocks: Clocks, k: int, tasks: Ints) -> tuple[float, Floats]:
    """Return when UAV k lands from all `tasks` [s], +inf where no take-off is within endurance, and f of it."""
    path, tour = np.empty((1 << len(tasks), len(tasks))), np.zeros(1 << len(tasks))
    depot, limit, window = instance.n_tasks + k, np.inf, 0.0
    if instance.travel is not None and "window" in instance.axes:
        limit, window = float(instance.limits[k]), instance.travel.window
    least = limit * (1 + ENDURANCE_ROUNDING / 2)
    most = limit * (1 + ENDURANCE_ROUNDING * (1 - 2.0**-10))  # arrivals are lowered; `check_routes` is to pass them
    take_off = _climb(clocks, k, tasks, depot, (least, most), window, path, tour)
    return float(tour[-1]) if take_off <= window else np.inf, path


def earliest_order(instance: Instance, k: int, tasks: list[int]) -> tuple[int, ...]:
    """Return `tasks` (at most 22 or so) in the order in which UAV k is home first."""
    clocks, depot = clocks_of(instance), instance.n_tasks + k
    g = int(clocks.classes[k])
    _, path = _earliest(instance, clocks, k, np.array(tasks))
    order, rest, following = [], (1 << len(tasks)) - 1, depot
    while rest:
        members, before = [i for i in range(len(tasks)) if rest >> i & 1], path[rest]
        j = min(members, key=lambda i: float(before[i] + leg_at(clocks, g, tasks[i], following, before[i])))
        order.append(tasks[j])
        rest, following = rest ^ 1 << j, tasks[j]
    return tuple(reversed(order))


@njit(cache=True)
def _climb(
    clocks: Clocks,
    k: int,
    tasks: Ints,
    depot: int,
    limits: tuple[float, float],
    window: float,
    path: Floats,
    tour: Floats,
) -> float:
    """Return the least take-off [s] of a flight within the first of `limits` [s], from below.

    The climb ends once the flight takes no more than the second; path and tour are filled for that take-off. It is
    past `window` [s] where there is none.
    """
    take_off = 0.0
    for _ in range(_MOST_STEPS):
        _extend(1, tour.size, clocks, k, tasks, depot, take_off, path, tour)
        if tour[-1] - take_off <= limits[1]:
            break
        take_off = tour[-1] - limits[0]
        if take_off > window:
            break
    return take_off


@njit(cache=True)
def _extend(
    low: int, high: int, clocks: Clocks, k: int, tasks: Ints, depot: int, begins: float, path: Floats, tour: Floats
) -> None:
    """Fill f and t of the sets low..high−1 of `tasks`, begun at `begins` [s]; a set's subsets have smaller numbers."""
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
                best = begins + leg_at(clocks, g, depot, tasks[j], begins)
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
