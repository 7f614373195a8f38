"""Fixing legs by reduced cost: a leg whose best tour would lift the Lagrangian bound to the cap is not needed.

Let L be the Lagrangian bound at (σ, π) and r_k the term of UAV k in it. Routes in which UAV k uses a given leg cost at
least L − r_k + r_k(leg), where r_k(leg) bounds the reduced cost of k's tours through it: the best way from the depot
to the leg (completion bounds of the reversed graph), the leg, and the best way home, together within the cap. Where it
reaches the cap, only routes without the leg can be better. L, r_k and r_k(leg) are all taken at the same duals.
Cuts are charged in either part on their own, which is never more than the whole tour pays: ⌊a/2⌋ + ⌊b/2⌋ ≤ ⌊(a+b)/2⌋.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from formulations.routing.columns.completion import Bins, bins_left, completion
from formulations.routing.columns.labelling import Subproblem
from formulations.routing.columns.legs import Legs, UavLegs
from formulations.routing.columns.pricing import DualBound, Pricer
from instances.arrays import Floats
from instances.kernels import njit


def fix_legs(pricer: Pricer, uavs: Iterable[int], at: DualBound) -> Legs:
    """Return the legs left, of `uavs` only those needed by routes of cost ≤ the pricer's cap."""
    legs, allowed = pricer.legs.copy(), at.allowed(pricer.cap)
    for k in uavs:
        if pricer.out_of_time():
            break
        problem = pricer.subproblem(k, at.duals)
        back = problem.legs.backwards()
        bins = Bins.of(back, problem.cap, problem.bins.most)
        behind = completion(back, bins, problem.memory, problem.watch, problem.price, problem.sigma)
        _fix(legs.of_uav(k), problem, behind, allowed[k])
    return legs


@njit(cache=True)
def _fix(legs: UavLegs, problem: Subproblem, behind: Floats, allowed: float) -> None:
    """Forbid, in place, the legs of one UAV whose best reduced cost exceeds what is allowed.

    behind : the completion bounds of the reversed graph.
    """
    out, between, home = legs.out, legs.between, legs.home
    cap, bins, step, ahead = problem.cap, problem.bins, problem.memory.step, problem.best
    price, sigma = problem.price, problem.sigma
    n = home.size
    for i in range(n):
        if out[i] <= cap:
            value = sigma * out[i] - price[i] + ahead[i, bins_left(cap - out[i], bins), 0]
            if value > allowed:
                out[i] = np.inf
        if home[i] <= cap:
            value = sigma * home[i] - price[i] + behind[i, bins_left(cap - home[i], bins), 0]
            if value > allowed:
                home[i] = np.inf
        for j in range(n):
            if not between[i, j] <= cap:
                continue
            left = bins_left(cap - between[i, j], bins)
            least = np.inf
            for b in range(left + 1):
                least = min(least, behind[i, b, step[j, i, 0]] + ahead[j, left - b, step[i, j, 0]])
            if least + sigma * between[i, j] - price[i] - price[j] > allowed:
                between[i, j] = np.inf
