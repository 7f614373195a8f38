"""The total bound: the least sum of all tours in the linear relaxation over arcs without a UAV, a UAV's share of it.

Of the programme of ``arc_programme.py`` over the costs c_ij = min_k w_k c_ijk of ``simple_bounds.py``, with r(S) = 1
for every set S of tasks, ÷ Σ_k w_k (for one UAV the relaxation of Dantzig, Fulkerson and Johnson, whose value is Held
and Karp's bound). As weak for min-max as the relaxation of the MILP, whose size is m times this one's: instances of
hundreds of tasks take seconds.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from formulations.routing.arc_programme import ArcProgramme
from formulations.routing.simple_bounds import weighted_costs
from instances import Instance
from instances.arrays import Floats


class Total(NamedTuple):
    """The `bound` [s], whether nothing more can be cut off, a UAV's share of what each task costs, `price` (n,) [s].

    Tasks in a set that is cut off share what it costs to enter it. No claim is made about prices.
    """

    bound: float
    complete: bool
    price: Floats


def total(instance: Instance, upper: float, time_limit: float) -> Total:
    """Return the bound, at most `upper` [s], the cost of routes known.

    0, as the prices, where not even the first programme was solved within `time_limit` [s].
    """
    end = time.perf_counter() + time_limit
    cost, weight = arc_costs(instance, upper)
    programme = ArcProgramme(cost, instance.n_tasks, instance.n_depots, upper)
    complete = programme.solve_all(end)
    return Total(min(upper, programme.sum / weight), complete, programme.price / weight)


def arc_costs(instance: Instance, upper: float) -> tuple[Floats, float]:
    """Return min_k w_k c_ijk [s], (N, N), infinite between depots, and Σ_k w_k."""
    cost, weight = weighted_costs(instance, upper)
    np.fill_diagonal(cost, np.inf)
    cost[instance.n_tasks :, instance.n_tasks :] = np.inf
    return cost, weight
