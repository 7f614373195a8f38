"""Separation of crowds: sets of tasks entered less than twice, whose shortest tour is longer than any UAV may fly.

Sets come of a cut tree of what is flown together and of its components, and each grows by the task that most is flown
to from it for as long as it is entered less than twice. How long a tour that passes it is at least is said by a 1-tree
of legs that may lead over other nodes, by whichever UAV is cheaper (Held & Karp, "The traveling-salesman problem and
minimum spanning trees: Part II", Math. Program. 1, 1971).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from formulations.routing.arcs.joint import Crowd
from formulations.routing.separation import cut_tree
from instances.arrays import Bools, Floats
from instances.kernels import njit

_MOST = 20
"""Cuts of one call, the most violated ones."""
_FLOWN = (1e-9, 0.2, 0.5)
"""What is flown on an edge, more than which joins a component."""
_ROUNDS = 60
"""Of the ascent to good potentials."""
_SURE = 1e-6
"""Share by which a tour must be too long."""


class Crowds:
    """Sets known to be too long or not, of legs cost (m, n + 1, n + 1), the depot last, and limits (m,) in the same."""

    def __init__(self, cost: Floats, limits: Floats) -> None:
        self.limits = limits
        nearest = np.minimum(cost.min(axis=0), min(1.0, float(limits.min())))
        leg = np.minimum(nearest, nearest.T)
        for over in range(len(leg)):
            leg = np.minimum(leg, leg[:, over, None] + leg[None, over])
        self._leg = leg
        self._known: dict[bytes, tuple[float, Floats]] = {}

    def cuts(self, x: Floats, cap: float, least: float) -> list[Crowd]:
        """Return cuts that x (n + 1, n + 1) violates by more than `least`, for routes of cost up to `cap`."""
        n, seen, found = len(x) - 1, set[bytes](), list[tuple[float, Crowd]]()
        edge, longest = x + x.T, float(np.minimum(self.limits, cap).max()) * (1 + _SURE)
        edge[edge < _FLOWN[0]] = 0.0
        sets = [~side if side[n] else side for side in cut_tree(edge)]
        for flown in _FLOWN:
            count, of = connected_components(np.where(edge[:n, :n] > flown, 1, 0), directed=False)
            sets += [np.append(of == number, False) for number in range(count)]
        for tasks in sets:
            if tasks.sum() >= 2 and (crowd := self._grown(tasks.copy(), edge, longest, 2.0 - least, seen)):
                found.append(crowd)
        found.sort(key=lambda item: item[0])
        return [cut for _, cut in found[:_MOST]]

    def _grown(
        self, tasks: Bools, edge: Floats, longest: float, most: float, seen: set[bytes]
    ) -> tuple[float, Crowd] | None:
        """Grow a set while it is entered less than `most`; return how much it is, and its cut, once it is too long."""
        n = len(edge) - 1
        linked = edge[:, tasks].sum(axis=1)
        entered = float(tasks.sum() - linked[tasks].sum() / 2)
        while entered < most and tasks.tobytes() not in seen:
            seen.add(tasks.tobytes())
            length, potential = self._shortest(tasks, longest)
            if length > longest:
                return entered, Crowd(n, tuple(np.flatnonzero(tasks).tolist()), tuple(potential.tolist()))
            others = np.where(tasks, -1.0, linked)[:n]
            i = int(np.argmax(others))
            if others[i] < 0:
                return None
            entered += 1.0 - others[i]
            tasks[i] = True
            linked += edge[:, i]
        return None

    def _shortest(self, tasks: Bools, longest: float) -> tuple[float, Floats]:
        """Return a lower bound on tours of the tasks, and its potentials."""
        key = tasks.tobytes()
        if key not in self._known:
            nodes = np.append(len(tasks) - 1, np.flatnonzero(tasks))
            self._known[key] = one_tree(self._leg[np.ix_(nodes, nodes)], longest, _ROUNDS)
        return self._known[key]


@njit(cache=True)
def one_tree(leg: Floats, target: float, rounds: int) -> tuple[float, Floats]:
    """Return a lower bound on tours of nodes with symmetric legs, and its potentials; `target` is enough."""
    size = len(leg)
    potential, best, best_potential = np.zeros(size), -np.inf, np.zeros(size)
    degree, before = np.zeros(size), np.full(size, 2.0)
    pull = 1.0
    for _ in range(rounds):
        length = _tree(leg, potential, degree)
        if length > best:
            best, best_potential = length, potential.copy()
            if best > target:
                break
        step = 0.7 * (2.0 - degree) + 0.3 * (2.0 - before)
        norm = (step**2).sum()
        if norm == 0.0:
            break
        potential += pull * max(1.03 * target - length, 0.01 * target) / norm * step
        before = degree.copy()
        pull *= 0.97
    return best, best_potential


@njit(cache=True)
def _tree(leg: Floats, potential: Floats, degree: Floats) -> float:
    """Return the cost of the least 1-tree, the first node the one apart; write the nodes' degrees (Prim)."""
    size = len(leg)
    degree[:] = 0.0
    near, link = np.full(size, np.inf), np.ones(size, np.int64)
    done = np.zeros(size, np.bool_)
    done[0] = True
    total, i = 2.0 * potential.sum(), 1
    for _ in range(size - 2):
        done[i] = True
        following = -1
        for j in range(size):
            if not done[j]:
                cost = leg[i, j] - potential[i] - potential[j]
                if cost < near[j]:
                    near[j], link[j] = cost, i
                if following < 0 or near[j] < near[following]:
                    following = j
        i = following
        total += near[i]
        degree[i] += 1
        degree[link[i]] += 1
    for _ in range(2):
        nearest = -1
        for j in range(1, size):
            if j != degree[0] and (nearest < 0 or leg[0, j] - potential[j] < leg[0, nearest] - potential[nearest]):
                nearest = j
        total += leg[0, nearest] - potential[0] - potential[nearest]
        degree[nearest] += 1
        degree[0] = nearest
    degree[0] = 2.0
    return total
