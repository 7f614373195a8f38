"""Fixing legs by reduced cost: a leg whose best tour would lift the Lagrangian bound to the cap is not needed.

Let L be the Lagrangian bound at (σ, π) and r_k the term of UAV k in it. Routes in which UAV k uses a given leg cost at
least L − r_k + r_k(leg), where r_k(leg) bounds the reduced cost of k's tours through it: the best way from the depot
to the leg (completion bounds of the reversed graph), the leg, and the best way home, together within the cap. Where it
reaches the cap, only routes without the leg can be better. L, r_k and r_k(leg) are all taken at the same duals.
Cuts are charged in either part on their own, which is never more than the whole tour pays: ⌊a/2⌋ + ⌊b/2⌋ ≤ ⌊(a+b)/2⌋.
"""

from __future__ import annotations

from collections.abc import Iterable

import numba
import numpy as np

from formulations.routing.columns.completion import Bins, bins_left, completion, successors
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.pricing import Duals, Pricer
from instances.arrays import Floats


def fix_legs(pricer: Pricer, uavs: Iterable[int], duals: Duals, bound: float, least: Floats) -> Legs:
    """Return the legs left, of `uavs` only those needed; at these duals `bound` is L (rounding margin taken off) and
    `least` its terms r_k.
    """
    legs, cap, watch = pricer.legs, pricer.cap, pricer.watch(duals)
    out, between, home = legs.out.copy(), legs.between.copy(), legs.home.copy()
    for k in uavs:
        if pricer.out_of_time():
            break
        b, _, _ = pricer.grid(k)
        back_legs = Bins.of(np.ascontiguousarray(legs.between[k].T), legs.out[k], cap, b.count)
        order, degree = successors(back_legs.legs, b.count)
        reverse = completion(
            np.ascontiguousarray(legs.between[k].T), legs.out[k], back_legs.legs, back_legs.home, order, degree,
            pricer.memory.step, watch.turn, watch.charge, duals.price, duals.sigma[k], b.count,
        )  # fmt: skip
        ahead, allowed = pricer.field(k, duals).best, cap - (bound - least[k])
        _fix(
            out[k], between[k], home[k], cap, b.width, b.count, ahead, reverse, pricer.memory.step, duals.price,
            duals.sigma[k], allowed,
        )  # fmt: skip
    return Legs(out, between, home)


@numba.njit(cache=True)
def _fix(out, between, home, cap, width, count, ahead, behind, step, price, sigma, allowed):  # type: ignore[no-untyped-def]
    """Forbid, in place, the legs of one UAV whose best reduced cost exceeds what is allowed."""
    n = home.size
    for i in range(n):
        if out[i] <= cap:
            value = sigma * out[i] - price[i] + ahead[i, bins_left(cap - out[i], width, count), 0]
            if value > allowed:
                out[i] = np.inf
        if home[i] <= cap:
            value = sigma * home[i] - price[i] + behind[i, bins_left(cap - home[i], width, count), 0]
            if value > allowed:
                home[i] = np.inf
        for j in range(n):
            if not between[i, j] <= cap:
                continue
            left = bins_left(cap - between[i, j], width, count)
            least = np.inf
            for b in range(left + 1):
                least = min(least, behind[i, b, step[j, i, 0]] + ahead[j, left - b, step[i, j, 0]])
            if least + sigma * between[i, j] - price[i] - price[j] > allowed:
                between[i, j] = np.inf
