"""Cooling: temperature and aim along one annealing; all change geometrically.

The norm is so soft that a tour counts as long which is within a few temperatures of the longest. How soft is drawn for
each annealing: a soft norm makes room in crowds of long tours, a sharp one finds optima in which most tours are long.
In the end what counts is the excess over a cap just below the best known longest tour, and the annealing goes on to
temperatures below the small shares of a tour by which good packings differ. A fine annealing has a cap nearer to that
tour and a colder end. Where all UAVs start at one place packing is all there is: there fine annealings also begin low,
the cap counts sooner, and a stirring begins so low that it only passes through packings like the one it began with.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search.energy import SHARP, TINY, Aim
from formulations.routing.search.randomness import below, uniform
from formulations.routing.search.tours import Tours

HOT, WARM, MILD, LOW, GENTLE = 0.7, 0.15, 0.1, 0.05, 0.01
"""Temperatures in mean legs where a fresh annealing begins, a child's, a relieved member's; at most LOW if PACKED;
that of a stirred member."""
COLD = 0.007
"""The last temperature in mean legs, at most."""
EVEN, PEAKED = 0.5, 0.02
"""Share ε of the mean tour in the energy at HOT and in the end."""
SOFT = (8.0, 2.0)
"""p = max_k C_k / (soft · temperature), soft one of SOFT."""
MOST_STIRRED, MOST_PACKED = 0.4, 0.67
"""Share of stirrings, and of PACKED annealings among the others, at most."""


class Ending(NamedTuple):
    """How an annealing ends.

    settled: the temperature in mean legs below which the excess over the cap counts; under: the share of the best known
    longest tour by which the cap lies below it; last: the last temperature, at most, as a share of the longest tour.
    """

    settled: float
    under: float
    last: float


COARSE, FINE, PACKED = Ending(0.015, 1e-3, 1e-4), Ending(0.015, 2e-4, 2e-5), Ending(0.05, 3e-5, 3e-5)
"""The usual ending; that of a fine annealing; and that of a fine one where all UAVs start at one place."""


class Manner(NamedTuple):
    """How an annealing goes: its first temperature in mean legs, one of SOFT, and its ending."""

    first: float
    soft: float
    ending: Ending


def draw_stirring(staleness: float, rng: NDArray[np.uint64]) -> Manner | None:
    """Return the manner of a stirring, with probability staleness / 2 but MOST_STIRRED at most, else None."""
    if uniform(rng) >= min(MOST_STIRRED, 0.5 * staleness):
        return None
    return Manner(GENTLE, SOFT[below(rng, len(SOFT))], PACKED)


def draw_manner(first: float, staleness: float, packing: bool, rng: NDArray[np.uint64]) -> Manner:
    """Return a manner that begins at `first` mean legs, fine with probability `staleness`.

    packing: a fine one is PACKED and begins at most at LOW, with probability MOST_PACKED at most.
    """
    soft = SOFT[below(rng, len(SOFT))]
    if uniform(rng) >= (min(MOST_PACKED, staleness) if packing else staleness):
        return Manner(first, soft, COARSE)
    return Manner(min(first, LOW), soft, PACKED) if packing else Manner(first, soft, FINE)


def cool(tours: Tours, longest: float, done: float, manner: Manner) -> tuple[float, Aim]:
    """Return (temperature [s], aim) at `done` in 0..1 of an annealing; legs are those of `tours`.

    longest [s]: that of the best tours known.
    """
    first, soft, ending = manner
    leg = max(float(tours.cost.sum()) / tours.after.size, TINY)  # an empty tour has a leg of 0
    legs = float(tours.cost.max()) / leg
    last = max(min(COLD, ending.last * legs), TINY)
    now = first * (last / first) ** done
    evenness = PEAKED * (EVEN / PEAKED) ** (math.log(now / last) / math.log(HOT / last))
    p = SHARP if now < ending.settled else int(min(SHARP - 1, max(2.0, legs / (soft * now))))
    return leg * now, Aim(evenness, p, (1.0 - ending.under) * longest)
