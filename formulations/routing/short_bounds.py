"""The lower bounds on the longest tour C_max that seconds buy, for routes that are to carry a gap.

farthest, assignment, arborescence    see ``simple_bounds.py``; milliseconds
capped-tours    the relaxation over whole tours that cost no more than the routes known: the first step of
                ``columns/destructive.py``, and of all relaxations here the strongest for its time
"""

from __future__ import annotations

import time

from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.destructive import destructive_bounds
from formulations.routing.simple_bounds import SIMPLE
from formulations.routing.total import total
from instances import Instance


def short_bounds(instance: Instance, upper: float, time_limit: float) -> dict[str, float]:
    """Return bounds [s] by name; `upper` [s] is the cost of routes known, `time_limit` [s] that of capped-tours.

    That one is left out where columns do not take the instance, and where the limit is 0. It is the same every time
    unless the limit strikes; what it has by then is a bound too.
    """
    bounds = {name: bound(instance, upper) for name, bound in SIMPLE.items()}
    method = BranchAndPrice()
    if upper > 0 and time_limit > 0 and method.accepts(instance) is None:
        method.prepare(instance)
        end = time.perf_counter() + time_limit
        price = total(instance, upper, time_limit / 3).price
        found = destructive_bounds(instance, 0.0, upper, lambda: end - time.perf_counter(), price=price)
        bounds["capped-tours"] = next(found, 0.0)
    return bounds
