"""Column generation: the master and pricing in turn, until the capped relaxation is solved or reaches the cap.

Only tours of cost ≤ cap < U exist, which is what makes the bound strong: a relaxation without columns enough is itself
a proof. Duals are smoothed (Wentges, "Weighted Dantzig–Wolfe decomposition for linear mixed-integer programming",
1997): priced half-way between the best duals so far and the master's; where that finds nothing the master's own are
priced. Every pricing gives a Lagrangian bound. A pricer that can neither find columns nor exclude them is followed by
the next, stronger one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Duals, Prices
from instances.arrays import Floats

_SMOOTHING = 0.5
_CLOSE = 0.02  # of the gap to the cap: how near the master's value and the bound must come
_EXACT = 1e-7  # of the cap: columns that gain less are not worth adding


@dataclass(frozen=True)
class Relaxation:
    """How column generation ended.

    bound [s] : the best Lagrangian bound; `duals` and `least` (r_k ≤ 0 of each UAV) are those of that bound.
    solved : whether no column is missing that could lower the master's value by more than a fraction of the gap.
    weight : λ of the master's columns.
    """

    bound: float
    duals: Duals
    least: Floats
    solved: bool
    weight: Floats
    rounds: int


def generate(
    master: Master,
    pricers: Sequence[Prices],
    cap: float,
    out_of_time: Callable[[], bool],
    centre: Relaxation | None = None,
) -> Relaxation:
    """Solve the relaxation over tours of cost ≤ `cap`; stop early where the bound passes the cap or time is up.

    centre : how a relaxation with no fewer tours and no more cuts ended; what its duals prove still holds, and new
        ones are sought near them. With it to fall back to, stop also where even the strongest pricer loses labels.
    """
    m = pricers[0].n_uavs
    _, at_master, weight = master.solve()
    best, best_bound, best_least, trust = at_master, -np.inf, np.zeros(m), 1.0
    if centre is not None:
        best, best_bound, best_least, trust = centre.duals, centre.bound, centre.least, _SMOOTHING
    level, rounds = 0, 0
    while True:
        rounds += 1
        duals = best.towards(at_master, trust)
        priced = []
        for k in range(m):
            if out_of_time():
                return Relaxation(best_bound, best, best_least, False, weight, rounds)
            priced.append(pricers[level].price(k, duals, -duals.rent[k] - _EXACT * cap))
        least = np.array([min(0.0, p.least) for p in priced])
        bound = duals.offset + float(least.sum()) - duals.margin(cap, m)
        if bound > best_bound:
            best, best_bound, best_least = duals, bound, least
        complete = all(p.complete for p in priced)
        if best_bound > cap or (centre is not None and level + 1 == len(pricers) and not complete):
            return Relaxation(best_bound, best, best_least, complete, weight, rounds)
        if master.add([c for p in priced for c in p.columns]):
            value, at_master, weight = master.solve()
            if value - best_bound <= _CLOSE * (cap - best_bound) and not master.penalised:
                return Relaxation(best_bound, best, best_least, True, weight, rounds)
            trust = _SMOOTHING if value - best_bound > _EXACT * cap else 1.0
        elif trust < 1.0:
            trust = 1.0
        elif master.widen(2 * cap):
            _, at_master, weight = master.solve()
        elif not complete and level + 1 < len(pricers):
            level += 1
        else:
            return Relaxation(best_bound, best, best_least, complete, weight, rounds)
