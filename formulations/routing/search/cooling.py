"""Cooling: temperature, share of the mean tour and p of the norm along one annealing; all change geometrically.

The norm is so soft that a tour counts as long which is within a few temperatures of the longest; in the end, from
SETTLED times the last temperature, only the longest counts. How soft is drawn for each annealing: a soft norm makes
room in crowds of long tours, a sharp one finds optima in which most tours are long.
"""

from __future__ import annotations

import math

from formulations.routing.search.energy import SHARP, TINY
from formulations.routing.search.tours import Tours

HOT, WARM, MILD, COLD = 0.7, 0.15, 0.1, 0.007
"""Temperatures in mean legs of the tours: where a fresh annealing begins, a child's, a relieved member's; the end."""
EVEN, PEAKED = 0.5, 0.02
"""First and last share ε of the mean tour in the energy."""
SOFT, SETTLED = (8.0, 2.0), 1.5
"""p = max_k C_k / (soft · temperature) while that is above SETTLED · COLD, soft one of SOFT; the maximum below."""
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


def exponent(tours: Tours, first: float, done: float, soft: float) -> int:
    """Return p, from 2 to SHARP, at `done` of an annealing begun at `first`."""
    now = temperature(first, done)
    if now < SETTLED * COLD:
        return SHARP
    legs = float(tours.cost.max()) / max(mean_leg(tours), TINY)
    return int(min(SHARP, max(2.0, legs / (soft * now))))
