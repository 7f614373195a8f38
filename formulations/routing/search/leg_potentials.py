"""Potentials of nodes: what of the cost of a leg any leg out of its first node, or into its second, would cost.

Every task is left and entered once, so a number taken off all legs out of it, or into it, changes no comparison of
totals; but it changes which legs look cheap. Where costs are asymmetric some tasks are dear to reach from
everywhere, and are near to nobody though a tour must fly there: of the legs of ft70's best tours a fifth lead to none
of the eight nearest by cost, and a twentieth to none by what is left of the costs under potentials. Where costs are
symmetric, what is near by cost does as well, and there are no potentials.

They are those of the assignment problem, whose cheapest solution every set of tours is at least as dear as, softened:

    f_i = softmin_j (c_ij − g_j),   g_j = softmin_i (c_ij − f_i),   softmin x = −T ln Σ exp(−x / T)

in turn (Sinkhorn & Knopp 1967; as an assignment: Kosowsky & Yuille, Neural Networks 7, 1994). What is left of a leg's
cost, c_ij − f_i − g_j, is T times the negative logarithm of how likely a random assignment at temperature T takes it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import AlikeCosts
from instances.arrays import Floats
from instances.kernels import njit


class PotentialParameters(NamedTuple):
    """How potentials are found.

    softness: T, as a share of what legs to and from near nodes cost; 0.05 to 0.2 rank the legs of good tours alike.
    near: how many nodes are near to say that.
    passes: over all legs; 20 rank them no better.
    most: nodes, at most: of 1000 the passes take 0.07 s; where there are more, near is what costs least.
    """

    softness: float = 0.1
    near: int = 20
    passes: int = 5
    most: int = 1000


def leg_potentials(costs: AlikeCosts, n_tasks: int, parameters: PotentialParameters) -> Floats:
    """Return f and g [s], (2, n+m).

    Zeros where costs are symmetric, nodes too many, or near ones cost nothing to fly to.
    """
    size = len(costs.out)
    near = min(parameters.near, size // 2)
    if costs.out is costs.into or size > parameters.most or near == 0:
        return np.zeros((2, size))
    usual = np.median(np.partition(costs.out, near, axis=1)[:, : near + 1].sum(axis=1)) / near
    if usual <= 0.0:
        return np.zeros((2, size))
    return _balanced(costs, n_tasks, parameters.softness * usual, parameters.passes)


@njit(cache=True, nogil=True)
def _balanced(costs: AlikeCosts, n_tasks: int, temperature: float, passes: int) -> Floats:
    """Return f and g [s] after some passes over all legs; legs between depots and from a node to itself are none."""
    size = costs.out.shape[0]
    potentials = np.zeros((2, size))
    for _ in range(passes):
        for v in range(size):
            potentials[0, v] = _softmin(costs.out[v], potentials[1], v, n_tasks, temperature)
        for v in range(size):
            potentials[1, v] = _softmin(costs.into[v], potentials[0], v, n_tasks, temperature)
    return potentials


@njit(cache=True, nogil=True)
def _softmin(row: Floats, others: Floats, v: int, n_tasks: int, temperature: float) -> float:
    """Return the softmin [s] of row − others, over the nodes that a leg may join node v to."""
    last = row.size if v < n_tasks else n_tasks
    least = np.inf
    for i in range(last):
        if i != v:
            least = min(least, row[i] - others[i])
    total = 0.0
    for i in range(last):
        if i != v:
            total += np.exp((least - row[i] + others[i]) / temperature)
    return least - temperature * np.log(total)


def left_of(costs: AlikeCosts, potentials: Floats, n_tasks: int) -> AlikeCosts:
    """Return costs [s] of which legs between tasks are what potentials leave of them."""
    f, g = potentials[:, :n_tasks]
    out = costs.out.copy()
    out[:n_tasks, :n_tasks] -= f[:, None] + g
    out.setflags(write=False)
    into = np.ascontiguousarray(out.T)
    into.setflags(write=False)
    return AlikeCosts(out, into)
