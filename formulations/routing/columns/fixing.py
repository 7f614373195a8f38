"""Fixing legs by reduced cost: a leg whose best tour would lift the Lagrangian bound to the cap is not needed.

Let L be the Lagrangian bound at (σ, π) and r_k the term of UAV k in it. Routes in which UAV k uses a given leg cost at
least L − r_k + r_k(leg), where r_k(leg) bounds the reduced cost of k's tours through it: the best way from the depot
to the leg (completion bounds of the reversed graph), the leg, and the best way home, together within the cap. Where it
reaches the cap, only routes without the leg can be better. L, r_k and r_k(leg) are all taken at the same duals.
Cuts are charged in either part on their own, which is never more than the whole tour pays: ⌊a/2⌋ + ⌊b/2⌋ ≤ ⌊(a+b)/2⌋.
Where costs change with time, the leg begins with some number b of bins left, of `most`: the way to it ends when at most
most − b bins are flown, and the leg costs what it does then.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from formulations.routing.columns.completion import Bins, bins_left, completion
from formulations.routing.columns.label_search import Subproblem
from formulations.routing.columns.legs import Legs, UavLegs
from formulations.routing.columns.pricing import DualBound, Effort, Pricer
from instances.arrays import Floats, Ints
from instances.kernels import njit

_FEWER = 0.9
"""Part of the legs that thorough fixing must come below to be worth the while."""


def fix_legs(pricer: Pricer, uavs: Iterable[int], at: DualBound) -> Legs:
    """Return the legs left, of `uavs` only those needed by routes of cost ≤ the pricer's cap."""
    legs, allowed = pricer.legs.copy(), at.allowed(pricer.cap)
    first_of = pricer.firsts(uavs, at.duals, allowed)

    def fix(k: int) -> None:
        if pricer.time_left() <= 0:
            return
        problem = pricer.subproblem(k, at.duals)
        bins = Bins.of(problem.legs, problem.cap, problem.bins.most, problem.bins.courses, backwards=True)
        behind = completion(bins, problem.memory, problem.watch, problem.price, problem.sigma)
        _fix(legs.of_uav(k), problem, behind, allowed[k])

    pricer.each(fix, dict.fromkeys(first_of.values()))
    for k, first in first_of.items():
        for left in (legs.out, legs.between, legs.home):
            left[k] = left[first]
    return legs


def fix_as_worth(quick: Pricer, thorough: Effort, uavs: Ints, at: DualBound) -> Legs:
    """Fix legs by a quick pricer, and then thoroughly where that leaves far fewer of the first UAV.

    With ten tasks a tour it leaves a twentieth fewer, for twenty times the work; with twenty, a fifth.
    """

    def again(legs: Legs, uavs: Ints) -> Legs:
        return fix_legs(quick.at(thorough, legs), uavs, at)

    legs, first = fix_legs(quick, uavs, at), uavs[:1]
    more = again(legs, first)
    left, before = (int(np.isfinite(some.between[first]).sum()) for some in (more, legs))
    return again(more, uavs) if left < _FEWER * before else more


@njit(cache=True, nogil=True)
def _fix(legs: UavLegs, problem: Subproblem, behind: Floats, allowed: float) -> None:
    """Forbid, in place, the legs of one UAV whose best reduced cost exceeds what is allowed.

    behind : the completion bounds of the reversed graph.
    """
    out, between, home = legs.out, legs.between, legs.home
    cap, bins, ahead, price, sigma = problem.cap, problem.bins, problem.best, problem.price, problem.sigma
    n = home.size
    for i in range(n):
        if out[i] <= cap:
            value = sigma * out[i] - price[i] + ahead[i, bins_left(cap - out[i], bins), 0]
            if value > allowed:
                out[i] = np.inf
        if home[i] <= cap and _least_through(problem, behind, i, n) - price[i] > allowed:
            home[i] = np.inf
        for j in range(n):
            if between[i, j] <= cap and _least_through(problem, behind, i, j) - price[i] - price[j] > allowed:
                between[i, j] = np.inf


@njit(cache=True, nogil=True)
def _least_through(problem: Subproblem, behind: Floats, i: int, j: int) -> float:
    """Return the least reduced cost [s], prices of i and j left out, of tours through the leg from i to j (n: home)."""
    cap, bins, step, ahead, sigma = problem.cap, problem.bins, problem.memory.step, problem.best, problem.sigma
    n, least = problem.price.size, np.inf
    if bins.legs.shape[0] > 1:
        for b in range(bins.most + 1):
            used = bins.legs[b, i, j]
            if used <= b:
                on = ahead[j, b - used, step[i, j, 0]] if j < n else 0.0
                before = behind[i, bins.most - b, step[j, i, 0] if j < n else 0]
                least = min(least, before + sigma * bins.cost[b, i, j] + on)
        return least
    cost = bins.cost[0, i, j]
    left = bins_left(cap - cost, bins)
    if j == n:
        return sigma * cost + behind[i, left, 0]
    for b in range(left + 1):
        least = min(least, behind[i, b, step[j, i, 0]] + ahead[j, left - b, step[i, j, 0]])
    return least + sigma * cost
