"""What `memetic` does with states: the plan that ignores them, then annealings from it, from scratch, from the best.

The decoupled plan, routes of straight legs with the best states put in afterwards, each tour in its better direction,
is a candidate, so that nothing worse is ever returned. Annealings are short where there are few tasks, and many.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import Recorder
from formulations.routing.search.budget import Budget, BudgetParameters
from formulations.routing.search.energy import TINY, Objective, p_norm
from formulations.routing.search.randomness import Rng, seeded
from formulations.routing.search.recreate import GUIDES, shuffle
from formulations.routing.search.states.annealing import StateAnnealing, anneal, recreate
from formulations.routing.search.states.costs import StateCosts, state_costs
from formulations.routing.search.states.tours import StateTours, copy_tours, empty_tours, from_routes, to_routes
from formulations.routing.solver import Result
from formulations.routing.stateless import stateless
from instances import Instance, Routes, Travel
from instances.arrays import Ints
from instances.metrics import distances
from instances.routes import tour_costs

Decoupled = Callable[[Instance, Limits, int], Routes | None]
"""Finds routes of an instance without states."""


@dataclass(frozen=True)
class StateSearch:
    """How the annealings follow each other.

    decoupled, decoupled_most: share of the time limit, and seconds at most, for the plan that ignores states.
    steps: of one annealing, for each task.
    fresh, improving: first temperatures in mean legs, from scratch and from routes that are known; last: the last one.
    mean_weight: share of the mean tour in the energy, in the beginning and in the end. softness: as in `schedule`.
    near: tasks nearest to a seed that a ruin may reach.
    """

    decoupled: float = 0.1
    decoupled_most: float = 10.0
    steps: int = 400
    fresh: float = 0.7
    improving: float = 0.15
    last: float = 0.005
    mean_weight: tuple[float, float] = (0.5, 0.02)
    softness: float = 4.0
    near: int = 30
    annealing: StateAnnealing = field(default_factory=StateAnnealing)
    budget: BudgetParameters = field(default_factory=lambda: BudgetParameters(steps=50))


def search_states(recorder: Recorder, seed: int, decoupled: Decoupled, settings: StateSearch) -> Result:
    """Search until a limit; a step is an iteration."""
    instance = recorder.instance
    plan = decoupled_plan(recorder, seed, decoupled, settings)
    costs, rng = state_costs(instance), seeded(seed)
    budget, runs = Budget(recorder, settings.budget), 0
    best = from_routes(costs, plan) if plan is not None else scratch(costs, settings, rng)
    if recorder.routes is not None:
        best = from_routes(costs, recorder.routes)
    nearest = near_tasks(costs, settings.near)
    while not budget.stopped_by:
        fresh = runs % 2 == 1 or (plan is None and runs == 0)
        start = scratch(costs, settings, rng) if fresh else best
        _run(
            recorder,
            budget,
            costs,
            nearest,
            start,
            best,
            rng,
            settings.fresh if fresh else settings.improving,
            settings,
        )
        runs += 1
    recorder.incumbent(to_routes(best))
    return recorder.result(budget.stopped_by, iterations=budget.iterations, annealings=runs)


def search_decoupled(recorder: Recorder, seed: int, decoupled: Decoupled) -> Result:
    """Return the plan that ignores states, searched for until the time limit."""
    decoupled_plan(recorder, seed, decoupled, StateSearch(decoupled=1.0, decoupled_most=math.inf))
    return recorder.result("time" if recorder.limits.iterations is None else "iterations")


def _run(
    recorder: Recorder,
    budget: Budget,
    costs: StateCosts,
    nearest: Ints,
    start: StateTours,
    best: StateTours,
    rng: Rng,
    first: float,
    settings: StateSearch,
) -> None:
    """Anneal from `start` at temperature `first`; `best` follows what is found."""
    tours, trial = empty_tours(costs), empty_tours(costs)
    copy_tours(start, tours)
    if start is not best and tours.cost.max() < best.cost.max():
        copy_tours(tours, best)
    length, begun, taken = settings.steps * nearest.shape[0], budget.fraction, 0
    known = float(best.cost.max())
    while taken < length and not budget.stopped_by:
        hurried = (budget.fraction - begun) / max(1.0 - begun, 1e-9)
        temperature, objective = _schedule(max(taken / length, hurried), first, tours, settings)
        steps = budget.next_steps(length - taken)
        anneal(costs, nearest, tours, trial, best, rng, steps, temperature, objective, settings.annealing)
        budget.took(steps)
        taken += steps
        if best.cost.max() < known:
            known = float(best.cost.max())
            recorder.incumbent(to_routes(best))


def _schedule(done: float, first: float, tours: StateTours, settings: StateSearch) -> tuple[float, Objective]:
    """Return temperature and objective at `done` in 0..1 of an annealing."""
    leg = max(float(tours.cost.sum()) / (tours.tour.size + tours.size.size), TINY)
    now = first * (settings.last / first) ** done
    even, peaked = settings.mean_weight
    weight = even * (peaked / even) ** (math.log(settings.fresh / now) / math.log(settings.fresh / settings.last))
    p = int(min(499.0, max(2.0, float(tours.cost.max()) / leg / (settings.softness * now))))
    return leg * now, Objective(p_norm(p), weight)


def scratch(costs: StateCosts, settings: StateSearch, rng: Rng) -> StateTours:
    """Return tours made by inserting all tasks in random order."""
    tours = empty_tours(costs)
    queue = np.arange(tours.tour.size)
    shuffle(queue, queue.size, rng)
    room = np.empty((2, tours.prefix.shape[1]), np.float32)
    for i in range(queue.size):
        recreate(costs, tours, queue[i : i + 1], 1, GUIDES[1], room, settings.annealing, rng)
    return tours


def near_tasks(costs: StateCosts, count: int) -> Ints:
    """Return the nearest tasks of each, itself first, (n, count) or as many as there are."""
    n = costs.least.shape[1] - costs.classes.size
    least = costs.least[:, :n, :n].min(axis=0)
    least = np.minimum(least, least.T)
    np.fill_diagonal(least, -1.0)
    return np.ascontiguousarray(np.argsort(least, axis=1, kind="stable")[:, : min(count, n)])


def decoupled_plan(recorder: Recorder, seed: int, decoupled: Decoupled, settings: StateSearch) -> Routes | None:
    """Offer the plan that ignores states to the recorder and return it; None where there is none."""
    instance, limits = recorder.instance, recorder.limits
    straight = straight_legs(instance)
    share = min(settings.decoupled * limits.time, settings.decoupled_most)
    found = decoupled(straight, replace(limits, time=max(share, 1e-3)), seed)
    if found is None:
        return None
    turned = tuple(route[::-1] for route in found)
    there, back = tour_costs(instance, found), tour_costs(instance, turned)
    plan = tuple(b if shorter else a for a, b, shorter in zip(found, turned, back < there, strict=True))
    recorder.incumbent(found)
    recorder.incumbent(plan)
    return plan


def straight_legs(instance: Instance) -> Instance:
    """Return the instance without states whose legs cost what straight lines do, where it has coordinates; else least.

    Lines are in metres, not seconds: the routes count, not what they cost.
    """
    plain = stateless(instance)
    if instance.coordinates is None or plain.axes:
        return plain
    return replace(plain, cost=distances(instance.coordinates), travel=None)


def warm_up(instance: Instance) -> Instance:
    """Return a small instance for which the same kernels are compiled as for `instance`."""
    nodes = np.repeat(np.arange(6), 2)
    closed = instance.travel is not None and instance.travel.closed
    cost = np.random.default_rng(0).uniform(1.0, 2.0, (1, 1, 12, 12))
    return Instance.of_travel("warm-up", Travel(cost, np.zeros(2, dtype=np.int64), nodes=nodes, closed=closed), 4)
