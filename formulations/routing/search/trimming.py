"""Trimming: the longest tour gives tasks away until it is shorter than any known, and the others are searched alone.

Where a tour of few far tasks is the longest, most changes that shorten it make others longer than it was by more than
an annealing lets pass, while the far tasks together in one tour are what is cheapest: it comes back to that. With
the trimmed tour set aside it cannot; whether the others can be packed below it is then all that is asked (a form of
large neighbourhood search, Shaw 1998). Where they nearly can, the longest of them is trimmed in its turn.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs
from formulations.routing.search.decomposition import task_on
from formulations.routing.search.problem_data import GranularNeighbourhood
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.recreate import better_side
from formulations.routing.search.tours import Tours, insertion_change, link, removal_change, unlink
from instances.arrays import Bools
from instances.kernels import njit


class TrimmingParameters(NamedTuple):
    """What is trimmed, and how the others are searched.

    pr439_10, from routes of 0.162 % which hold annealings up, to the best known, 25 s by script: 28 of 231 stages, all
    of them after a second trimming; where tasks are given away without looking 4 of 205.

    share: of the stages after the founders; best: share of those that trim the best routes, the others trim a member.
    shorter: share of the incumbent's longest tour by which a trimmed one is, at least.
    draws: tasks of which the one that others take at least cost is given away.
    most: tours trimmed one after the other; near: share of the incumbent's longest tour by which the longest may exceed
    it, at most, where another is.
    depth: steps are depth · n² / m; first: temperature in mean legs.
    """

    share: float = 0.2
    best: float = 0.5
    shorter: float = 1e-5
    draws: int = 3
    most: int = 2
    near: float = 5e-3
    depth: float = 3.0
    first: float = 0.05


@njit(cache=True, nogil=True)
def elsewhere(
    costs: Costs, near: GranularNeighbourhood, tours: Tours, v: int, aside: Bools, rng: Rng
) -> tuple[int, float]:
    """Return (node to put task v behind, change of that tour's cost [s]), beside a near task on a tour not set aside.

    Where there is none it is behind the depot of such a tour.
    """
    best, best_change = -1, np.inf
    for u in near.tasks[v]:
        if not aside[tours.tour[u]]:
            w, change = better_side(costs, tours, v, u)
            if change < best_change:
                best, best_change = w, change
    if best < 0:
        k = below(rng, aside.size)
        while aside[k]:
            k = (k + 1) % aside.size
        best = tours.after.size - aside.size + k
        best_change = insertion_change(costs, tours, v, best)
    return best, best_change


@njit(cache=True, nogil=True)
def trim(
    costs: Costs,
    near: GranularNeighbourhood,
    tours: Tours,
    aside: Bools,
    most: float,
    parameters: TrimmingParameters,
    rng: Rng,
) -> None:
    """Set the longest tour aside that is not, and let it give tasks to those that are not until it costs `most` [s].

    aside (m,): at least two tours are not set aside.
    """
    first = -1
    for k in range(aside.size):
        if not aside[k] and (first < 0 or tours.cost[k] > tours.cost[first]):
            first = k
    aside[first] = True
    while tours.size[first] > 0 and tours.cost[first] > most:
        given, to, least = -1, -1, np.inf
        for _ in range(parameters.draws):
            v = task_on(tours, first, rng)
            u, change = elsewhere(costs, near, tours, v, aside, rng)
            if change < least:
                given, to, least = v, u, change
        tours.cost[first] += removal_change(costs, tours, given)
        unlink(costs, tours, given)
        link(costs, tours, given, to)
        tours.cost[tours.tour[given]] += least
