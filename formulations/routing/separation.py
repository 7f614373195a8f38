r"""Separation: the subtour cuts that a fractional or integer θ of the paper's MILP violates.

The cuts are const6 in its depot-linked form (``paper_model.py``): for a UAV k, a set S of tasks and v ∈ S,

    Σ_{i∉S, j∈S} θ_ijk ≥ y_vk        (what enters S from outside is at least what visits v)

which, as y_jk = Σ_i θ_ijk, is the same as Σ_{i∈S} Σ_{j∈S} θ_ijk ≤ Σ_{i∈S∖v} y_ik. Some S is violated for v exactly
when the largest flow from depot k to v with capacities θ_··k is less than y_vk, and the smallest cut gives S: the exact
separation of Padberg & Grötschel (in "The Traveling Salesman Problem", Lawler et al. 1985) for a conditional visit.
S = {i, j} is the two-cycle cut θ_ijk + θ_jik ≤ y_ik, S = T the cut y_vk ≤ u_k = Σ_j θ_kjk.

Flows are found by shortest augmenting paths (Edmonds & Karp 1972) on the arcs with θ > 0, of which there are few, and
stop as soon as y_vk is reached: microseconds a task, much faster than a call of a library would be.
"""

from __future__ import annotations

import numpy as np

from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit

_ARC = 1e-9  # θ below this is no arc


@njit(cache=True)
def two_cycles(theta: Floats, least: float) -> tuple[Bools, Ints]:
    """Return the violated sets S = {i, j} of one UAV, as `subtours` does."""
    n = len(theta) - 1
    y = theta[:, :n].sum(axis=0)
    sets = np.zeros((n * (n - 1) // 2, n), dtype=np.bool_)
    visited = np.empty(len(sets), dtype=np.int64)
    found = 0
    for j in range(n):
        for i in range(j):
            v = i if y[i] >= y[j] else j
            # entering {i, j} < y_v  ⇔  θ_ij + θ_ji > y of the other
            if theta[i, j] + theta[j, i] > y[i + j - v] + least:
                sets[found, i] = sets[found, j] = True
                visited[found] = v
                found += 1
    return sets[:found], visited[:found]


def subtours(theta: Floats, least: float) -> tuple[Bools, Ints]:
    """Return the sets S violated by more than `least`, shape (cuts, n), and the v of each.

    theta : θ of one UAV, shape (n+1, n+1), its depot last. Of every flow that falls short the smallest S and the
        largest are returned; v is the task of S visited most. A task inside a set already found is not tried.
    """
    y = theta[:, :-1].sum(axis=0)
    sets, visited = _subtours(theta, y, np.argsort(-y, kind="stable"), least)
    return sets, visited


@njit(cache=True)
def _subtours(theta: Floats, y: Floats, order: Ints, least: float) -> tuple[Bools, Ints]:
    """Return the sets of `subtours`; y (n,): how much enters each task, the first of `order` most."""
    n = y.size
    near, degree = _neighbours(theta)
    sets = np.zeros((2 * n, n), dtype=np.bool_)
    visited = np.empty(2 * n, dtype=np.int64)
    covered = np.zeros(n, dtype=np.bool_)
    parent = np.empty(n + 1, dtype=np.int64)
    queue = np.empty(n + 1, dtype=np.int64)
    found = 0
    for v in order:
        if y[v] <= least:
            break
        if covered[v]:
            continue
        residual = theta.copy()
        missing = y[v]
        while missing > least:
            _search(residual, near, degree, n, v, True, parent, queue)
            if parent[v] < 0:
                break
            missing -= _augment(residual, parent, n, v)
        if missing <= least:
            continue
        largest = parent < 0
        _search(residual, near, degree, v, n, False, parent, queue)
        smallest = parent >= 0
        for side in range(2):
            S = smallest if side == 0 else largest
            if side == 1 and (smallest ^ largest).sum() == 0:
                break
            top = v
            for i in range(n):
                if S[i]:
                    sets[found, i] = covered[i] = True
                    if y[i] > y[top]:
                        top = i
            visited[found] = top
            found += 1
    return sets[:found], visited[:found]


@njit(cache=True)
def cut_tree(weight: Floats) -> Bools:
    """Return the sides of the fundamental cuts of a cut tree, (nodes − 1, nodes), of symmetric weights (Gusfield 1990).

    Each is a smallest cut between the two nodes that it tells apart in the tree.
    """
    size = len(weight)
    near, degree = _neighbours(weight)
    above = np.full(size, size - 1)
    sides = np.zeros((size - 1, size), dtype=np.bool_)
    parent = np.empty(size, dtype=np.int64)
    queue = np.empty(size, dtype=np.int64)
    for v in range(size - 1):
        residual = weight.copy()
        _search(residual, near, degree, v, above[v], True, parent, queue)
        while parent[above[v]] >= 0:
            _augment(residual, parent, v, above[v])
            _search(residual, near, degree, v, above[v], True, parent, queue)
        for i in range(size):
            sides[v, i] = parent[i] >= 0
            if i > v and sides[v, i] and above[i] == above[v]:
                above[i] = v
    return sides


@njit(cache=True)
def _neighbours(theta: Floats) -> tuple[Ints, Ints]:
    """Return for each node the nodes it shares an arc with, and their number."""
    size = len(theta)
    near = np.empty((size, size), dtype=np.int64)
    degree = np.zeros(size, dtype=np.int64)
    for i in range(size):
        for j in range(size):
            if theta[i, j] > _ARC or theta[j, i] > _ARC:
                near[i, degree[i]] = j
                degree[i] += 1
    return near, degree


@njit(cache=True)
def _search(
    residual: Floats, near: Ints, degree: Ints, first: int, last: int, forwards: bool, parent: Ints, queue: Ints
) -> None:
    """Search breadth-first from `first` until `last`; parent < 0 where not reached. Backwards: against the arcs."""
    parent[:] = -1
    parent[first] = first
    queue[0] = first
    head, tail = 0, 1
    while head < tail:
        i = queue[head]
        head += 1
        for at in range(degree[i]):
            j = near[i, at]
            if parent[j] < 0 and (residual[i, j] if forwards else residual[j, i]) > _ARC:
                parent[j] = i
                if j == last:
                    return
                queue[tail] = j
                tail += 1


@njit(cache=True)
def _augment(residual: Floats, parent: Ints, first: int, last: int) -> float:
    """Send as much as fits along the path found; return how much."""
    amount = np.inf
    j = last
    while j != first:
        amount = min(amount, residual[parent[j], j])
        j = parent[j]
    j = last
    while j != first:
        residual[parent[j], j] -= amount
        residual[j, parent[j]] += amount
        j = parent[j]
    return amount
