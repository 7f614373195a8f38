"""Candidate legs: those that a search by Lin & Kernighan's moves may add to a ring of tours, shortest first.

The nearest nodes of a task in a cluster all lie in that cluster, so that legs from one cluster to the next, of which
good tours need some, would never be looked at. So beside its nearest nodes a node v gets a few in every direction: from
the nearest on, node w is taken unless a node u taken before is nearer both to v and to w than they are to each other,

    c_uv ≤ c_vw  and  c_uw < c_vw,

and all that once more among the nodes left over. The first layer contains the relative neighbourhood graph (Toussaint,
Pattern Recognition 12, 1980), hence a minimum spanning tree: no cluster is cut off. Two layers do what quadrant
neighbours do (Johnson & McGeoch 1997), without coordinates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.problem_data import Nodes, keep_nearest
from instances.arrays import Bools, Floats
from instances.kernels import njit


class CandidateLegs(NamedTuple):
    """nodes, cost (N, q): where legs from each node lead to and what they cost [s]; −1 and ∞ where there are fewer.

    The depots, all at one place, are candidates together or not at all.
    """

    nodes: Nodes
    cost: Floats


def candidate_legs(cost: Floats, n_tasks: int, near: int, layers: int, most: int) -> CandidateLegs:
    """Return the `near` nearest nodes and those of the layers, `most` at most, of every node of a ring.

    cost (n+m, n+m): symmetric, depots at one place. The depots count as one, and are m entries.
    """
    n, m = n_tasks, len(cost) - n_tasks
    chosen = _chosen(cost, n + 1, min(near, n), layers, min(most, n))
    nodes = np.full((n + m, chosen.shape[1] + m - 1), -1, np.int32)
    nodes[: n + 1, : chosen.shape[1]] = chosen
    for v in np.flatnonzero((chosen == n).any(axis=1)):
        at = int(np.argmax(chosen[v] == n))
        nodes[v] = [*chosen[v, :at], *range(n, n + m), *chosen[v, at + 1 :]]
    nodes[n + 1 :] = nodes[n]
    legs = np.where(nodes >= 0, np.take_along_axis(cost, nodes.astype(np.int64), axis=1), np.inf)
    return CandidateLegs(nodes, legs)


@njit(cache=True, nogil=True)
def _chosen(cost: Floats, count: int, near: int, layers: int, most: int) -> Nodes:
    """Return the candidates of nodes 0..count−1 among them, nearest first, (count, most); −1 where there are fewer."""
    out = np.full((count, most), -1, np.int32)
    nearest, taken = np.empty(near, np.int32), np.zeros(count, np.bool_)
    left = np.empty(count)
    for v in range(count):
        row, held = cost[v, :count], 0
        taken[v] = True
        for _ in range(layers):
            held = _add_layer(cost, v, left, taken, out[v], held)
        keep_nearest(row, row, v, 0, nearest)
        for u in nearest:
            if not taken[u] and held < most:
                out[v, held] = u
                held += 1
        taken[v] = False
        for i in range(held):
            taken[out[v, i]] = False
        _sort(out[v], row, held)
    return out


@njit(cache=True, nogil=True)
def _add_layer(cost: Floats, v: int, left: Floats, taken: Bools, out: Nodes, held: int) -> int:
    """Add a layer of nodes not yet taken to the first `held` of `out`, as there is room; return how many there are."""
    row = cost[v]
    for w in range(left.size):
        left[w] = np.inf if taken[w] else row[w]
    while held < out.size:
        u, least = -1, np.inf
        for w in range(left.size):
            if left[w] < least:
                u, least = w, left[w]
        if u < 0:
            break
        taken[u] = True
        out[held] = u
        held += 1
        left[u] = np.inf
        others = cost[u]
        for w in range(left.size):
            if others[w] < row[w]:
                left[w] = np.inf
    return held


@njit(cache=True, nogil=True)
def _sort(nodes: Nodes, row: Floats, held: int) -> None:
    """Put the first `held` nodes in the order of what legs to them cost."""
    for i in range(1, held):
        v, j = nodes[i], i
        while j > 0 and row[nodes[j - 1]] > row[v]:
            nodes[j] = nodes[j - 1]
            j -= 1
        nodes[j] = v
