"""Cooling: the temperature and the share of the mean tour along one annealing, both falling geometrically."""

from __future__ import annotations

import math

from formulations.routing.search.tours import Tours

HOT, WARM, MILD, COLD = 0.7, 0.15, 0.1, 0.007
"""Temperatures in mean legs of the tours: where a fresh annealing begins, a child's, a relieved member's; the end."""
EVEN, PEAKED = 0.5, 0.02
"""First and last share ε of the mean tour in the energy."""
_STEEPNESS = math.log(EVEN / PEAKED) / math.log(HOT / COLD)


def mean_leg(tours: Tours) -> float:
    """Return the mean cost of a leg [s], empty tours counted as a leg of 0."""
    return float(tours.cost.sum()) / tours.after.size


def temperature(first: float, done: float) -> float:
    """Return the temperature in mean legs at `done` in 0..1 of an annealing begun at `first`."""
    return first * (COLD / first) ** done


def evenness(first: float, done: float) -> float:
    """Return ε at `done` of an annealing begun at `first`: a function of the temperature alone."""
    return PEAKED * (temperature(first, done) / COLD) ** _STEEPNESS
