"""Exchange: a selection made better under a worth that no method of selection knows, one task at a time.

Of all sets that differ by one task more, or by one in place of another, the one worth most that the UAVs can still fly
is taken, until none is better: a local optimum, of which no bound is claimed (exchange algorithms of optimal design:
V. V. Fedorov, Theory of Optimal Experiments, 1972). A set is tried in the order of its worth, its new task at the
place in the tours that costs least.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence

from instances import Instance, Routes, as_routes, check_routes, tour_costs

CLEARLY = 1e-9
"""Relative: what is better by less is not."""


def exchanged(
    instance: Instance, routes: Routes, worth: Callable[[Sequence[int]], float], seconds: float
) -> tuple[Routes, int]:
    """Return routes over tasks of at least as much `worth`, within the endurance of `instance`, and how many exchanges.

    seconds : of search at most [s].
    """
    until, count = time.perf_counter() + seconds, 0
    value = worth(sorted(task for route in routes for task in route))
    while (better := _better(instance, routes, worth, value, until)) is not None:
        routes, value = better
        count += 1
    return routes, count


def _better(
    instance: Instance, routes: Routes, worth: Callable[[Sequence[int]], float], value: float, until: float
) -> tuple[Routes, float] | None:
    """Return the best exchange that can be flown and its worth; None where there is none, or no time."""
    chosen = sorted(task for route in routes for task in route)
    others = [task for task in instance.tasks if task not in chosen]
    told = []
    for new in others:
        for old in (None, *chosen):
            if time.perf_counter() > until:
                return None
            told.append((worth(sorted({*chosen, new} - {old})), new, old))
    for higher, new, old in sorted(told, key=lambda each: -each[0]):
        if not higher > value + CLEARLY * abs(value) or time.perf_counter() > until:
            return None
        rest = as_routes([[task for task in route if task != old] for route in routes])
        fit = [each for each in _with(rest, new) if not check_routes(instance, each, all_tasks=False)]
        if fit:
            return min(fit, key=lambda each: float(tour_costs(instance, each).sum())), higher
    return None


def _with(routes: Routes, task: int) -> Iterator[Routes]:
    """Yield `routes` with `task` at every place."""
    for k, route in enumerate(routes):
        for at in range(len(route) + 1):
            yield (*routes[:k], (*route[:at], task, *route[at:]), *routes[k + 1 :])
