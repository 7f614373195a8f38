"""Annealed ruin-and-recreate (Schrimpf et al. 2000), the loop inside `ruin-recreate` and `memetic`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Measure, Objective, energy, fitness
from formulations.routing.search.moves import MoveParameters, empty_workspace, move
from formulations.routing.search.problem_data import ProblemData
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import GUIDES, RecreateParameters, recreate, shuffle
from formulations.routing.search.ruin import Removed, remove_adjacent, remove_strings, restore
from formulations.routing.search.tours import Tours, copy_tours, longest, sum_costs, unlink
from instances.arrays import Floats
from instances.kernels import njit


class AnnealingParameters(NamedTuple):
    """What the steps of an annealing are.

    Figures: mean gaps in % with several depots and with one (measured.md); with all of them 0.07 and 0.00.

    removals: tasks removed by one ruin, at most; halving them costs less than two seeds can tell.
    strings: share of ruins by strings, the others are adjacent removals; without these 0.20 and 0.00.
    moves: share of steps that try moves of long segments instead of ruining; without 0.30 and 0.00.
    guides: how many of GUIDES are drawn from (recreate.py).
    recreate, move: parameters of the recreations and the moves.
    """

    removals: int = 12
    strings: float = 0.5
    moves: float = 0.1
    guides: int = len(GUIDES)
    recreate: RecreateParameters = RecreateParameters()
    move: MoveParameters = MoveParameters()


@njit(cache=True, nogil=True)
def undo(costs: Costs, tours: Tours, count: int, removed: Removed, costs_before: Floats) -> None:
    """Return to the tours as they were before a ruin of `count` tasks and its recreation."""
    tasks = removed.tasks
    for i in range(count):
        unlink(costs, tours, tasks[i])
    restore(costs, tours, count, removed)
    for k in range(costs_before.size):
        tours.cost[k] = costs_before[k]


@njit(cache=True, nogil=True)
def _keep(tours: Tours, best: Tours, fittest: Tours, lowest: float, measure: Measure) -> float:
    """Copy `tours` to `best` where their longest is shorter, to `fittest` where their fitness is below `lowest` [s].

    measure: of fitness. Return the lowest fitness then.
    """
    now = longest(tours.cost)
    if now < longest(best.cost):
        copy_tours(tours, best)
    if now - measure.cap < lowest:
        value = fitness(tours.cost, measure)
        if value < lowest:
            copy_tours(tours, fittest)
            return value
    return lowest


@njit(cache=True, nogil=True)
def anneal(
    data: ProblemData,
    tours: Tours,
    best: Tours,
    fittest: Tours,
    rng: Rng,
    steps: int,
    temperature: float,
    objective: Objective,
    measure: Measure,
    parameters: AnnealingParameters,
) -> None:
    """Take `steps` steps of ruin and recreate from `tours`, in place.

    `best` follows the smallest max_k C_k, `fittest` the lowest fitness by `measure`. A step that raises the energy by
    x [s] is accepted with probability exp(−x / temperature).
    """
    most, m = parameters.removals, tours.cost.size
    removed = Removed(np.empty(most, np.int32), np.empty(most, np.int32), np.zeros(m, np.bool_))
    costs, near = data.costs, data.near  # once: in the loop each access would count references
    nearest = near.tasks
    tasks, queue, costs_before = removed.tasks, np.empty(most, np.int32), np.empty(m)
    sum_costs(tours)
    now = energy(tours.cost, objective)
    lowest = fitness(fittest.cost, measure)
    workspace = empty_workspace(costs, nearest.shape[0])
    for _ in range(steps):
        if uniform(rng) < parameters.moves:
            now = move(costs, nearest, tours, workspace, rng, now, temperature, objective, parameters.move)
            lowest = _keep(tours, best, fittest, lowest, measure)
            continue
        for k in range(m):
            costs_before[k] = tours.cost[k]
        if uniform(rng) < parameters.strings:
            count = remove_strings(costs, nearest, tours, removed, rng)
        else:
            count = remove_adjacent(costs, nearest, tours, removed, rng)
        for i in range(count):
            queue[i] = tasks[i]
        shuffle(queue, count, rng)
        guide = GUIDES[below(rng, parameters.guides)]
        recreate(costs, near, tours, queue, count, guide, parameters.recreate, rng)
        then = energy(tours.cost, objective)
        if then < now - temperature * math.log(1.0 - uniform(rng)):
            now = then
            lowest = _keep(tours, best, fittest, lowest, measure)
        else:
            undo(costs, tours, count, removed, costs_before)
