"""Ruin (Schrimpf et al. 2000): remove a few related tasks from their tours, and restore them exactly where they were.

Two ways: a task with its nearest neighbours (Shaw 1998; adjacent removal), and strings of consecutive tasks from tours
near a seed task (slack induction by string removals, Christiaens & Vanden Berghe 2020).
Each removal writes down the task and the node before it; restoring reads them backwards.
"""

from __future__ import annotations

from typing import NamedTuple

from formulations.routing.search.costs import Costs
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.tours import Tours, link, removal_change, unlink
from instances.arrays import Bools
from instances.kernels import njit


class Removed(NamedTuple):
    """tasks, behind (q,): tasks and the nodes they stood behind, room for q; ruined (m,): tours that lost a string."""

    tasks: Nodes
    behind: Nodes
    ruined: Bools


@njit(cache=True, nogil=True)
def remove(costs: Costs, tours: Tours, v: int, count: int, tasks: Nodes, behind: Nodes) -> int:
    """Take task v out, book its cost and place, and return the new count of removed tasks."""
    tours.cost[tours.tour[v]] += removal_change(costs, tours, v)
    tasks[count] = v
    behind[count] = tours.before[v]
    unlink(costs, tours, v)
    return count + 1


@njit(cache=True, nogil=True)
def restore(costs: Costs, tours: Tours, count: int, removed: Removed) -> None:
    """Undo `count` removals, last first; costs are the caller's business."""
    tasks, behind = removed.tasks, removed.behind  # once: in a loop each access would count references
    for i in range(count - 1, -1, -1):
        link(costs, tours, tasks[i], behind[i])


@njit(cache=True, nogil=True)
def remove_adjacent(costs: Costs, near: Nodes, tours: Tours, removed: Removed, rng: Rng) -> int:
    """Remove a random task and its nearest neighbours, 1 to as many as there is room for; return how many."""
    n, tasks, behind = near.shape[0], removed.tasks, removed.behind
    wanted = 1 + below(rng, min(tasks.size, near.shape[1] + 1))
    v = below(rng, n)
    count = remove(costs, tours, v, 0, tasks, behind)
    for j in range(wanted - 1):
        count = remove(costs, tours, near[v, j], count, tasks, behind)
    return count


@njit(cache=True, nogil=True)
def _string_around(tours: Tours, v: int, length: int, rng: Rng, n_tasks: int) -> int:
    """Return the first node of a string of `length` tasks that contains v, at a random offset."""
    first = v
    for _ in range(below(rng, length)):
        if tours.before[first] >= n_tasks:
            break
        first = tours.before[first]
    return first


@njit(cache=True, nogil=True)
def remove_strings(costs: Costs, near: Nodes, tours: Tours, removed: Removed, rng: Rng) -> int:
    """Remove strings from tours near a random task, 1 to as many tasks as there is room for; return how many.

    Half of the strings keep a run of tasks in their middle (split strings).
    """
    n, tasks, behind, ruined = near.shape[0], removed.tasks, removed.behind, removed.ruined
    seed = below(rng, n)
    wanted = 1 + below(rng, tasks.size)
    longest = 1 + below(rng, wanted)
    for k in range(ruined.size):
        ruined[k] = False
    count = 0
    for j in range(-1, near.shape[1]):
        v = seed if j < 0 else near[seed, j]
        k = tours.tour[v]
        if k < 0 or ruined[k]:
            continue
        ruined[k] = True
        length = min(longest, wanted - count, tours.size[k])
        kept = 0
        if length > 1 and uniform(rng) < 0.5:
            kept = min(tours.size[k] - length, 1 + below(rng, length))
        u = _string_around(tours, v, length + kept, rng, n)
        skip_from = 1 + below(rng, length - 1) if kept else length
        taken, skipped = 0, 0
        while taken < length and u < n:
            after = tours.after[u]
            if taken >= skip_from and skipped < kept:
                skipped += 1
            else:
                count = remove(costs, tours, u, count, tasks, behind)
                taken += 1
            u = after
        if count >= wanted:
            break
    return count
