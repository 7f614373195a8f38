"""What pricing learns to remember: the tasks that walks come back to.

Completion bounds (`completion.py`) are the least reduced costs of walks, which may return to a task that they no longer
remember. Where tours are long that is what makes labels many: bounds of walks say little of tours. A search that lost
labels follows the best walks from each first task on; what these return to should have been remembered, at the tasks
between, and from then on is (dynamic ng-routes: Roberti & Mingozzi, "Dynamic ng-path relaxation for the delivery man
problem", Transp. Sci. 48, 2014). All pricing, fixing and listing of a tree shares what is learnt.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from formulations.routing.columns.completion import Memory, bins_left
from formulations.routing.columns.label_search import Subproblem
from instances.arrays import Floats, Ints
from instances.kernels import njit

_FOLLOWED = 10
"""Walks of a UAV to learn from, the best ones."""
_LONGEST = 2
"""Times the number of tasks: visits of the longest walk."""

Walk = tuple[int, ...]


class Recall:
    """What a tree has learnt: `returns` (n, n), how often walks came back to a task (second) by way of another (first).

    lessons : how many there were, by which whoever keeps a memory knows that it is out of date.
    """

    def __init__(self, n_tasks: int) -> None:
        self.returns, self.lessons = np.zeros((n_tasks, n_tasks)), 0

    def learn(self, walks: Sequence[Walk], weight: Floats) -> bool:
        """Learn from walks of some weight, (w,); say whether any comes back to a task."""
        more = returns_of(walks, weight, len(self.returns))
        if more.any():
            self.returns, self.lessons = self.returns + more, self.lessons + 1
        return bool(more.any())

    def memory(self, between: Floats, size: int) -> Memory:
        """Return what to remember: `size` tasks at each; `between` (n, n) [s] the cost of any one UAV."""
        return Memory.nearest(between, size, self.returns)


def returns_of(walks: Sequence[Walk], weight: Floats, n_tasks: int) -> Floats:
    """Return how often walks of these weights come back to a task (second) by way of another (first), (n, n).

    A return counts for one in all tasks between together: the fewer there are, the less has to be remembered.
    """
    returns = np.zeros((n_tasks, n_tasks))
    for walk, share in zip(walks, weight.tolist(), strict=True):
        last: dict[int, int] = {}
        for visit, task in enumerate(walk):
            if task in last:
                between = [other for other in walk[last[task] + 1 : visit] if other != task]
                returns[between, task] += share / len(between)
            last[task] = visit
    return returns


def best_walks(problem: Subproblem, threshold: float) -> list[Walk]:
    """Return some of the best walks of reduced cost below `threshold`.

    None where costs change with time, nor where cuts are paid for: walks are followed as if they were not, and lessons
    of these cost more than they save (60, 4 seeds 0 and 4: 95 and 31 s with, 40 and 20 s without).
    """
    if problem.bins.legs.shape[0] > 1 or problem.cuts.rho.any():
        return []
    walks, values, _ = walks_from_each(problem)
    below = np.flatnonzero(values < threshold)
    best = below[np.argsort(values[below], kind="stable")[:_FOLLOWED]]
    return [tuple(walk[walk >= 0].tolist()) for walk in walks[best]]


def walks_from_each(problem: Subproblem) -> tuple[Ints, Floats, Floats]:
    """Return the best walk from every first task, −1 behind its end, their reduced costs and costs [s].

    A walk of more than twice as many visits as tasks is not followed to its end, and its cost said to be infinite.
    """
    return _walks(problem, _LONGEST * problem.price.size)


@njit(cache=True, nogil=True)
def _walks(problem: Subproblem, most: int) -> tuple[Ints, Floats, Floats]:
    bins, step, best, price, sigma = problem.bins, problem.memory.step, problem.best, problem.price, problem.sigma
    legs, cost, out, n = bins.legs[0], bins.cost[0], problem.legs.out, problem.price.size
    walks, values, costs = np.full((n, most), -1), np.full(n, np.inf), np.zeros(n)
    for first in range(n):
        if not out[first] <= problem.cap:
            continue
        left, memory, here = bins_left(problem.cap - out[first], bins), 0, first
        values[first] = sigma * out[first] - price[first] + best[first, left, 0]
        if not values[first] < np.inf:
            continue
        costs[first] = out[first]
        for visit in range(most):
            walks[first, visit] = here
            least, then = (sigma * cost[here, n] if legs[here, n] <= left else np.inf), n
            for j in range(n):
                if legs[here, j] <= left:
                    value = sigma * cost[here, j] - price[j] + best[j, left - legs[here, j], step[here, j, memory]]
                    if value < least:
                        least, then = value, j
            costs[first] += cost[here, then]
            if then == n:
                break
            left, memory, here = left - legs[here, then], step[here, then, memory], then
        else:
            costs[first] = np.inf
    return walks, values, costs
