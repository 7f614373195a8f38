"""Cooling: temperature and aim along one annealing; all change geometrically.

The norm is so soft that a tour counts as long which is within a few temperatures of the longest. How soft is drawn for
each annealing: a soft norm makes room in crowds of long tours, a sharp one finds optima in which most tours are long.
In the end what counts is the excess over a cap just below the best known longest tour, and the annealing goes on to
temperatures below the small shares of a tour by which good packings differ; a fine annealing has a cap nearer to that
tour and goes on longer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search.energy import SHARP, TINY, Aim
from formulations.routing.search.randomness import uniform
from formulations.routing.search.tours import Tours

HOT, WARM, MILD = 0.7, 0.15, 0.1
"""Temperatures in mean legs of the tours where a fresh annealing begins, a child's, a relieved member's."""
COLD, LAST = 0.007, 1e-4
"""The last temperature, at most, in mean legs and as a share of the longest tour; FINE times LAST of a fine one."""
EVEN, PEAKED = 0.5, 0.02
"""Share ε of the mean tour in the energy at HOT and in the end."""
SOFT = (8.0, 2.0)
"""p = max_k C_k / (soft · temperature), soft one of SOFT."""
SETTLED = 0.015
"""Temperature in mean legs below which the excess over the cap counts."""
UNDER = 1e-3
"""The cap lies below the best known longest tour by this share of it; FINE times that of a fine annealing."""
COARSE, FINE = 1.0, 0.2
"""The two finenesses."""


class Manner(NamedTuple):
    """How an annealing goes: its first temperature in mean legs, one of SOFT, and COARSE or FINE."""

    first: float
    soft: float
    fineness: float


def draw_fineness(patience_used: float, rng: NDArray[np.uint64]) -> float:
    """Return FINE with probability `patience_used`, else COARSE: fine annealings where coarse ones find nothing new."""
    return FINE if uniform(rng) < patience_used else COARSE


def cool(tours: Tours, longest: float, done: float, manner: Manner) -> tuple[float, Aim]:
    """Return (temperature [s], aim) at `done` in 0..1 of an annealing; legs are those of `tours`.

    longest [s]: that of the best tours known.
    """
    first, soft, fineness = manner
    leg = max(float(tours.cost.sum()) / tours.after.size, TINY)  # an empty tour has a leg of 0
    legs = float(tours.cost.max()) / leg
    last = max(min(COLD, fineness * LAST * legs), TINY)
    now = first * (last / first) ** done
    evenness = PEAKED * (EVEN / PEAKED) ** (math.log(now / last) / math.log(HOT / last))
    p = SHARP if now < SETTLED else int(min(SHARP - 1, max(2.0, legs / (soft * now))))
    return leg * now, Aim(evenness, p, (1.0 - fineness * UNDER) * longest)
