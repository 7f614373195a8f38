"""The destructive bound: the largest cap at which the relaxation over tours of cost ≤ cap is already impossible.

For any cap, routes whose longest tour is ≤ cap have a makespan of at least the capped relaxation's bound L(cap). Where
L(cap) > cap there are none, and cap is a lower bound on every makespan; and where L(cap) ≤ cap, L(cap) is. Bisection
between what is known raises the cap as far as time allows (Klein & Scholl, "Computing lower bounds by destructive
improvement", Eur. J. Oper. Res. 112, 1999, for the idea). Valid in floating point as every L is (see `pricing`).
"""

from __future__ import annotations

from collections.abc import Iterator

from formulations.routing.columns.generation import generate
from formulations.routing.columns.label_search import Clock
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Column, Effort, Pricer
from instances import Instance

_EFFORTS = (Effort(3, 150, 200), Effort(3, 200, 3000), Effort(6, 400, 20_000))
_LABELS = 1_000_000
_PRECISION = 1e-3  # share of `upper` at which bisection ends


def destructive_bounds(
    instance: Instance, lower: float, upper: float, out_of_time: Clock, *, from_top: bool = True
) -> Iterator[float]:
    """Yield ever higher lower bounds on the longest tour [s].

    lower, upper : a bound and the cost of routes known [s]; from_top : whether the first cap is `upper` itself, whose
        bound may be known already.
    """
    legs, store, columns = Legs.of(instance), make_store(instance.n_tasks, _LABELS), list[Column]()
    high = upper
    cap = upper if from_top else (lower + upper) / 2
    while high - lower > _PRECISION * upper and not out_of_time():
        master = Master(instance.n_tasks, instance.n_depots, 3 * cap / instance.n_tasks)
        master.add([column for column in columns if column.cost <= cap])
        allowed = legs.under(cap)
        pricers = [Pricer(allowed, cap, effort, store, out_of_time) for effort in _EFFORTS]
        found = generate(master, pricers, cap, out_of_time).best.value
        bound, columns = min(found, cap * (1 - 1e-12)), master.columns
        if bound > lower:
            lower = bound
            yield lower
        if found <= cap:
            high = cap
        cap = (lower + high) / 2
