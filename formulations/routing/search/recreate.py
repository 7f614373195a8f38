"""Recreate: put the removed tasks back one by one where they hurt least.

Hurt is the growth of Σ_k C_k^p: p = 1 minimises the total, a large p spares the longest tours. From p = SHARP hurt is
what exceeds the longest tour that is left, and only in case of a tie the growth of the tour: a long detour of a UAV
with time to spare is then better than the least growth of the longest tour, which no p-norm in use would say.
A p drawn anew for each recreation keeps the search from going blind where only the longest tour counts.
Places looked at: behind and before each near neighbour, and both ends of the tours of near depots; now and then one of
them is overlooked (blinks, Christiaens & Vanden Berghe 2020).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import SHARP, power
from formulations.routing.search.neighbours import Neighbours
from formulations.routing.search.randomness import below
from formulations.routing.search.tours import Tours, insertion_change, link

BLINK = 0.01
"""Probability of overlooking a place, at most one for each task."""
WIDTH = 12
"""Near tasks whose two sides are looked at, but for the annealings of a population that packs (population.py)."""
TIE = 1e-4
"""From p = SHARP: weight of the growth of a tour below the longest."""
DEPOTS = 4
"""Nearest depots whose tour ends are looked at; as many again are drawn among the others."""


@njit(cache=True, nogil=True)
def growth(length: float, change: float, p: int) -> float:
    """Return (length + change)^p − length^p; from p = SHARP what exceeds 1, the longest tour left, and a tie-break."""
    if p == 1:
        return change
    if p >= SHARP:
        return max(length + change - 1.0, 0.0) - max(length - 1.0, 0.0) + TIE * change
    return power(length + change, p) - power(length, p)


@njit(cache=True, nogil=True)
def _better_side(costs: Costs, tours: Tours, v: int, u: int) -> tuple[int, float]:
    """Return (node to put task v behind, cost change [s]) for the cheaper of behind u and before u."""
    b = tours.before[u]
    behind = insertion_change(costs, tours, v, u)
    ahead = costs.into[v, b] + costs.out[v, u] - tours.arc[b]
    if ahead < behind:
        return b, ahead
    return u, behind


@njit(cache=True, nogil=True)
def best_place(
    costs: Costs,
    near: Neighbours,
    tours: Tours,
    v: int,
    p: int,
    scale: float,
    width: int,
    blink: float,
    rng: NDArray[np.uint64],
) -> tuple[int, float]:
    """Return (node to put task v behind, change of that tour's cost [s]); the node is −1 where all was overlooked.

    1 / scale [s] is the longest tour that is left: it keeps powers in range, and from p = SHARP it is what counts.
    width: near tasks whose two sides are looked at.
    """
    n_near = near.tasks.shape[1]
    n_depots = near.depots.shape[1]
    n_tasks_seen = min(width, n_near)
    n_seen = n_tasks_seen + min(2 * DEPOTS, n_depots)
    overlooked = below(rng, int(n_seen / blink)) if blink > 0.0 else -1
    best, best_u, best_change = np.inf, -1, 0.0
    for j in range(n_seen):
        if j < n_tasks_seen:
            node = near.tasks[v, j]
        elif j < n_tasks_seen + DEPOTS or n_depots <= 2 * DEPOTS:
            node = near.depots[v, j - n_tasks_seen]
        else:
            node = near.depots[v, DEPOTS + below(rng, n_depots - DEPOTS)]
        k = tours.tour[node]
        if k < 0 or j == overlooked:
            continue
        u, change = _better_side(costs, tours, v, node)
        value = growth(tours.cost[k] * scale, change * scale, p)
        if value < best or best_u < 0:
            best, best_u, best_change = value, u, change
    return best_u, best_change


@njit(cache=True, nogil=True)
def recreate(
    costs: Costs,
    near: Neighbours,
    tours: Tours,
    queue: NDArray[np.int32],
    count: int,
    p: int,
    width: int,
    rng: NDArray[np.uint64],
) -> None:
    """Put queue[:count] back into the tours, in that order, and book the costs; `width` as in best_place."""
    longest = tours.cost.max()
    scale = 1.0 / longest if longest > 0.0 else 1.0
    for i in range(count):
        v = queue[i]
        u, change = best_place(costs, near, tours, v, p, scale, width, BLINK, rng)
        if u < 0:
            u, change = best_place(costs, near, tours, v, p, scale, width, 0.0, rng)
        k = tours.tour[u]
        link(costs, tours, v, u)
        tours.cost[k] += change


@njit(cache=True, nogil=True)
def shuffle(queue: NDArray[np.int32], count: int, rng: NDArray[np.uint64]) -> None:
    """Put queue[:count] in random order (Fisher & Yates)."""
    for i in range(count - 1, 0, -1):
        j = below(rng, i + 1)
        queue[i], queue[j] = queue[j], queue[i]


@njit(cache=True, nogil=True)
def construct(costs: Costs, near: Neighbours, tours: Tours, rng: NDArray[np.uint64]) -> None:
    """Fill empty tours with all tasks in random order, each where it least raises Σ_k C_k²."""
    n = near.tasks.shape[0]
    queue = np.arange(n).astype(np.int32)
    shuffle(queue, n, rng)
    for i in range(n):
        recreate(costs, near, tours, queue[i : i + 1], 1, 2, WIDTH, rng)
