"""Fitness of the genetic algorithm where costs change with time: tours flown leg by leg, from their best take-off."""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.waiting import LIMIT, wait
from formulations.routing.clocks import Clocks, arrival_home
from formulations.routing.ga_operators import Population
from instances.arrays import Floats
from instances.kernels import njit


@njit(cache=True)
def evaluate_by_clock(clocks: Clocks, scale: Floats, waits: Floats, people: Population) -> None:
    """Set totals and fitness of all chromosomes that are born to what tours take, times `scale` (m,).

    waits (m, 3) : who may wait before take-off (`Waits.table`).
    """
    perms, sizes, totals, fitness = people
    n, m = perms.shape[1], sizes.shape[1]
    for row in range(fitness.size):
        if sizes[row].sum() < n:  # not born
            continue
        first, longest = 0, 0.0
        for k in range(m):
            last = first + sizes[row, k]
            time = arrival_home(clocks, k, n, perms[row, first:last])
            if time > waits[k, LIMIT]:
                stops = np.full(last - first + 2, n + k)
                stops[1:-1] = perms[row, first:last]
                time = wait(clocks, clocks.classes[k], stops, waits[k])[1]
            totals[row, k] = time * scale[k]
            longest = max(longest, totals[row, k])
            first = last
        fitness[row] = longest
