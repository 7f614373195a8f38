"""Search in parts: the UAV of the longest tour and some of those near it, over their tasks alone.

A short search ends in traps that lead out only by several tours at once, but seldom by all of them: one of six tours of
ten, begun at theirs, finds the way sooner than another search of all, or not at all, which three trials tell.
"""

from __future__ import annotations

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import Recorder
from formulations.routing.search.memetic import Memetic
from formulations.routing.solver import refusal
from instances import Instance, Routes, Travel, tour_costs

_SHARE = 0.6  # of the UAVs that one search is of
_STEPS = 10  # of one search, for each pair of tasks of the whole
_IN_VAIN = 3  # searches in turn that find nothing, after which there are no more


def improve_in_parts(recorder: Recorder, seed: int) -> int:
    """Improve the recorder's routes part by part until that does no more; return the steps made."""
    instance, rng, in_vain, steps = recorder.instance, np.random.default_rng(seed), 0, 0
    size, each = max(2, round(_SHARE * instance.n_depots)), _STEPS * instance.n_tasks**2
    if recorder.routes is None or size >= instance.n_depots:
        return steps
    if recorder.objective <= 0.0:  # nothing is shorter, and the longest tour may have no tasks
        return steps
    while in_vain < _IN_VAIN and (left := recorder.remaining) > 0:
        limits = Limits(time=left, iterations=each)
        uavs = _around_the_longest(instance, recorder.routes, size, rng)
        routes = search_of_part(instance, recorder.routes, uavs, limits, int(rng.integers(2**31)), goes_on=True)
        better = routes is not None and recorder.incumbent(routes)
        in_vain, steps = 0 if better else in_vain + 1, steps + each
    return steps


def _around_the_longest(instance: Instance, routes: Routes, size: int, rng: np.random.Generator) -> list[int]:
    """Draw so many UAVs, that of the longest tour first: others the likelier the shorter a leg to a task of it is.

    Legs from a UAV's depot count as well: it may have no tasks yet.
    """
    first = int(np.argmax(tour_costs(instance, routes)))
    between = np.minimum(instance.cost, instance.cost.T)[list(routes[first])]
    near = [between[:, [*route, instance.n_tasks + k]].min() for k, route in enumerate(routes)]
    drawn = rng.exponential(size=len(routes)) * near
    drawn[first] = -1.0
    return np.argsort(drawn, kind="stable")[:size].tolist()


def search_of_part(
    instance: Instance, routes: Routes, uavs: list[int], limits: Limits, seed: int, *, goes_on: bool
) -> Routes | None:
    """Return `routes` with those of `uavs` searched for anew, over what the others leave; None where none are found.

    routes : for each UAV its tasks, in depot order; uavs : numbers of some of them.
    goes_on : whether the search begins at their routes, which must then be of all those tasks; else from scratch.
    """
    kept = {i for k, route in enumerate(routes) if k not in uavs for i in route}
    tasks = [i for i in instance.tasks if i not in kept]
    if not tasks or not uavs:
        return None
    memetic, few = Memetic(), part(instance, tasks, uavs)
    if refusal(memetic, few) is not None:
        return None
    number = {i: at for at, i in enumerate(tasks)}
    start = tuple(tuple(number[i] for i in routes[k]) for k in uavs) if goes_on else None
    found = memetic.solve(few, limits=limits, seed=seed, start=start)
    if found.routes is None:
        return None
    new = list(routes)
    for k, route in zip(uavs, found.routes, strict=True):
        new[k] = tuple(tasks[i] for i in route)
    return tuple(new)


def part(instance: Instance, tasks: list[int], uavs: list[int]) -> Instance:
    """Return the instance of some of the tasks and some of the UAVs, numbered in the order given."""
    nodes = tasks + [instance.n_tasks + k for k in uavs]
    whole = instance.travel or Travel(instance.cost[None, None], instance.classes)
    at = np.full(instance.n_nodes, -1)
    at[nodes] = np.arange(len(nodes))
    kept = np.flatnonzero(at[whole.nodes] >= 0)
    states = kept[np.argsort(at[whole.nodes[kept]], kind="stable")]
    costs = whole.cost[:, :, states[:, None], states]
    travel = Travel(costs, whole.classes[uavs], whole.departures, at[whole.nodes[states]], whole.closed)
    return Instance.of_travel(instance.name, travel, len(tasks), endurance=instance.limits[uavs])
