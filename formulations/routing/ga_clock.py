"""Fitness of the genetic algorithm where costs change with time: tours flown leg by leg."""

from __future__ import annotations

from formulations.routing.clocks import Clocks, arrival_home
from formulations.routing.ga_operators import Population
from instances.arrays import Floats
from instances.kernels import njit


@njit(cache=True)
def evaluate_by_clock(clocks: Clocks, scale: Floats, people: Population) -> None:
    """Set totals and fitness of all chromosomes that are born to what tours take, times `scale` (m,)."""
    perms, sizes, totals, fitness = people
    n, m = perms.shape[1], sizes.shape[1]
    for row in range(fitness.size):
        if sizes[row].sum() < n:  # not born
            continue
        first, longest = 0, 0.0
        for k in range(m):
            last = first + sizes[row, k]
            totals[row, k] = arrival_home(clocks, k, n, perms[row, first:last]) * scale[k]
            longest = max(longest, totals[row, k])
            first = last
        fitness[row] = longest
