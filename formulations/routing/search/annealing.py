"""Annealed ruin-and-recreate (Schrimpf et al. 2000), the loop inside `ruin-recreate` and `memetic`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.routing.search.costs import Costs
from formulations.routing.search.cuts import blank_bench, cut
from formulations.routing.search.energy import SHARP, Aim, energy, fitness
from formulations.routing.search.neighbours import Neighbours
from formulations.routing.search.randomness import below, uniform
from formulations.routing.search.recreate import WIDTH, recreate, shuffle
from formulations.routing.search.ruin import put_back, ruin_adjacent, ruin_strings
from formulations.routing.search.tours import Tours, copy_tours, sum_costs, unlink
from instances.arrays import Floats

POWERS = (1, 2, 5, 12, 30, SHARP)
"""The p of the recreation's guides (recreate.py), one drawn for each recreation."""
QUENCH = 0.1
"""Temperature of the cuts as a share of that of the ruins: a cut tries hundreds of moves, not one."""


class Habits(NamedTuple):
    """removals: tasks taken out by one ruin, at most; strings: share of ruins by strings, the others are adjacent
    removals; cuts: share of steps that cut long pieces instead of ruining; powers: how many of POWERS are drawn from;
    width: near tasks whose two sides a recreation looks at, for each task.
    """

    removals: int
    strings: float
    cuts: float
    powers: int
    width: int = WIDTH


@njit(cache=True, nogil=True)
def undo(
    costs: Costs,
    tours: Tours,
    count: int,
    gone: NDArray[np.int32],
    stood: NDArray[np.int32],
    costs_before: Floats,
) -> None:
    """Return to the tours as they were before a ruin of `count` tasks and its recreation."""
    for i in range(count):
        unlink(costs, tours, gone[i])
    put_back(costs, tours, count, gone, stood)
    tours.cost[:] = costs_before


@njit(cache=True, nogil=True)
def _keep(tours: Tours, best: Tours, fittest: Tours, lowest: float, known: float) -> float:
    """Copy `tours` to `best` where their longest is shorter, to `fittest` where their fitness is below `lowest` [s].

    known [s] is what fitness is measured by. Return the lowest fitness then.
    """
    longest = tours.cost.max()
    if longest < best.cost.max():
        copy_tours(tours, best)
    if longest - known < lowest:
        value = fitness(tours.cost, known)
        if value < lowest:
            copy_tours(tours, fittest)
            return value
    return lowest


@njit(cache=True, nogil=True)
def anneal(
    costs: Costs,
    near: Neighbours,
    tours: Tours,
    best: Tours,
    fittest: Tours,
    rng: NDArray[np.uint64],
    steps: int,
    temperature: float,
    aim: Aim,
    habits: Habits,
) -> None:
    """Take `steps` steps of ruin and recreate from `tours`, in place.

    `best` follows the smallest max_k C_k, `fittest` the lowest fitness. A step that raises the energy by x [s] is kept
    with probability exp(−x / temperature).
    """
    removals = habits.removals
    gone, stood, queue = (np.empty(removals, np.int32), np.empty(removals, np.int32), np.empty(removals, np.int32))
    ruined = np.zeros(tours.cost.size, np.uint8)
    costs_before = np.empty(tours.cost.size)
    sum_costs(tours)
    now = energy(tours.cost, aim)
    lowest = fitness(fittest.cost, aim.known)
    bench = blank_bench(near.tasks.shape[0])
    for _ in range(steps):
        if uniform(rng) < habits.cuts:
            now = cut(costs, near.tasks, tours, bench, rng, now, QUENCH * temperature, aim)
            lowest = _keep(tours, best, fittest, lowest, aim.known)
            continue
        costs_before[:] = tours.cost
        if uniform(rng) < habits.strings:
            count = ruin_strings(costs, near.tasks, tours, rng, removals, gone, stood, ruined)
        else:
            count = ruin_adjacent(costs, near.tasks, tours, rng, removals, gone, stood)
        queue[:count] = gone[:count]
        shuffle(queue, count, rng)
        recreate(costs, near, tours, queue, count, POWERS[below(rng, habits.powers)], habits.width, rng)
        then = energy(tours.cost, aim)
        if then < now - temperature * math.log(1.0 - uniform(rng)):
            now = then
            lowest = _keep(tours, best, fittest, lowest, aim.known)
        else:
            undo(costs, tours, count, gone, stood, costs_before)
