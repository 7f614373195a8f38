"""Greedy construction for the min-max objective, the floor every other method must beat.

Variants, each from empty tours, one task at a time (C_k: cost of UAV k's tour, eq. costsum):

* ``regret``, the default: every task has a best tour, the one that is shortest after taking it; next comes the task
  that would lose most in its second best tour (Potvin & Rousseau, EJOR 66, 1993). The best of the four by far.
* ``cheapest``: of all insertions, the one after which that UAV's tour C_k is shortest. So the tours grow side by side,
  as in the cheapest-insertion heuristic of Rosenkrantz, Stearns and Lewis (SIAM J. Comput. 6, 1977), with the
  resulting tour cost instead of its increase as the measure, because C_max counts and not the sum.
* ``shortest``: the UAV with the shortest tour takes the task that lengthens it least.
* ``nearest``: the UAV with the shortest tour flies on to the task nearest to its last one (nearest neighbour).

Ties go to the lowest UAV, then task. When the time is up the tasks still left are routed by ``nearest``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.construction import Rule, extend_nearest, first_gaps, insert_many
from formulations.routing.search.problem_data import both_ways
from formulations.routing.search.tours import Tours, empty_tours, to_routes
from formulations.routing.solver import Result
from instances import InputError, Instance, Routes
from instances.errors import suggestion

_RULES = {rule.name.lower(): rule for rule in Rule}
VARIANTS = (*_RULES, "nearest")
_LOOKS = 4_000_000
"""Entries of the table of gaps looked at between two looks at the clock: about 10 ms."""


@dataclass(frozen=True)
class Greedy(RecordedSolver):
    """Greedy construction, without randomness; `variant` is regret, cheapest, shortest or nearest."""

    variant: str = "regret"

    proves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        if self.variant not in VARIANTS:
            near_miss = suggestion(str(self.variant), VARIANTS)
            raise InputError(f"greedy: variant must be one of {', '.join(VARIANTS)}, got {self.variant!r}{near_miss}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (or load them from numba's cache)."""
        small = Instance("warm-up", 1.0 - np.eye(4), 3, 1)
        for variant in {self.variant, "nearest"}:
            Greedy(variant).solve(small, limits=Limits(time=3600.0))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Construct routes; an iteration limit has no meaning here."""
        instance = recorder.instance
        tours = empty_tours(instance.n_tasks, instance.n_depots)
        in_time = self.variant == "nearest" or _insert_all(instance, tours, _RULES[self.variant], recorder)
        extend_nearest(instance.cost, tours)
        recorder.incumbent(to_routes(tours))
        return recorder.result("finished" if in_time else "time")


def _insert_all(instance: Instance, tours: Tours, rule: Rule, recorder: Recorder) -> bool:
    """Fill `tours` by `rule` until all is routed or the time is up; return whether all is."""
    costs = both_ways(instance.cost)
    gaps = first_gaps(costs, instance.n_tasks)
    chunk = max(1, _LOOKS // (instance.n_tasks * (instance.n_depots + 10)))
    left = instance.n_tasks
    while left and recorder.remaining > 0.0:
        insert_many(costs, tours, gaps, rule, min(chunk, left))
        left -= min(chunk, left)
    return left == 0


def greedy_routes(instance: Instance) -> Routes:
    """Return the greedy routes, however long it takes."""
    routes = Greedy().solve(instance, limits=Limits(time=float("inf"))).routes
    assert routes is not None
    return routes
