"""The destructive bound: the largest cap at which the relaxation over tours of cost ≤ cap is already impossible.

For any cap, routes whose longest tour is ≤ cap have a makespan of at least the capped relaxation's bound L(cap). Where
L(cap) > cap there are none, and cap is a lower bound on every makespan; and where L(cap) ≤ cap, L(cap) is. Bisection
between what is known raises the cap as far as time allows (Klein & Scholl, "Computing lower bounds by destructive
improvement", Eur. J. Oper. Res. 112, 1999, for the idea). Valid in floating point as every L is (see `pricing`).

Each relaxation begins at the best duals of the one before, the first at prices given: from nothing duals swing for
half a minute at 200 tasks before any bound is worth having.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from formulations.routing.columns.generation import generate
from formulations.routing.columns.label_search import Clock
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Column, Duals, Effort, Pricer
from formulations.routing.columns.recall import Recall
from instances import Instance
from instances.arrays import Floats

_EFFORTS = (Effort(3, 150, 300), Effort(4, 200, 2000), Effort(6, 300, 20_000), Effort(7, 400, 60_000))
_LABELS = 1_000_000
_STEPS = 6e8  # of the completion bounds of a UAV, half a second: time limits are looked at between UAVs
_PRECISION = 1e-3  # share of `upper` at which bisection ends


def destructive_bounds(
    instance: Instance,
    lower: float,
    upper: float,
    time_left: Clock,
    *,
    price: Floats | None = None,
    from_top: bool = True,
) -> Iterator[float]:
    """Yield ever higher lower bounds on the longest tour [s].

    lower, upper : a bound and the cost of routes known [s]; price (n,) [s] : about what a task adds to the longest
        tour; from_top : whether the first cap is `upper` itself, whose bound may be known already.
    """
    n, m = instance.n_tasks, instance.n_depots
    legs, store, columns, recall = Legs.of(instance), make_store(n, _LABELS), list[Column](), Recall(n)
    start = None if price is None else Duals(price, np.full(m, (1 - 1e-14) / m), np.zeros(m), np.zeros(0))
    high = upper
    cap = upper if from_top else (lower + upper) / 2
    while high - lower > _PRECISION * upper and time_left() > 0:
        box = np.full(n, 3 * cap / n)
        master = Master(n, legs.kinds(), box if start is None else np.maximum(box, 2 * np.abs(start.price)))
        master.add([column for column in columns if column.cost <= cap])
        allowed = legs.under(cap)
        pricers = [Pricer(allowed, cap, effort, store, time_left, recall) for effort in _efforts(allowed)]
        best = generate(master, pricers, cap, time_left, start=start).best
        bound, columns, start = min(best.value, cap * (1 - 1e-12)), master.columns, best.duals
        if bound > lower:
            lower = bound
            yield lower
        if best.value <= cap:
            high = cap
        cap = (lower + high) / 2


def _efforts(legs: Legs) -> list[Effort]:
    """Return how hard to price, the quickest first: less is remembered where UAVs have very many legs."""
    most = int(np.isfinite(legs.between).sum(axis=(1, 2)).max())
    near = [max(1, min(e.near, int(np.log2(max(2.0, _STEPS / (most * e.bins + 1)))))) for e in _EFFORTS]
    return list(dict.fromkeys(replace(e, near=fewer) for e, fewer in zip(_EFFORTS, near, strict=True)))
