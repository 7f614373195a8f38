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
Where tours are too long for the UAVs' endurance they are made anew of costs scaled by it (search/endurance.py): for
tours as long as those, then for the least shares of endurance. That may find none; it proves nothing.
Of 20,000 tasks and 50 UAVs ``regret`` takes minutes, ``nearest`` 0.2 s: it looks at near tasks first, in a wind at the
20 nearest either way alone while one of them is left.
Where costs change with time insertions are compared to first order by the clock (clocked/construction.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.construction import Rule, extend_nearest, first_gaps, insert_many
from formulations.routing.search.costs import Costs, search_costs, warm_up, warm_up_by_clock
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.place_costs import PlaceCosts, near_places
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours, empty_tours, to_routes
from formulations.routing.solver import Result
from instances import InputError, Instance, Routes
from instances.errors import suggestion

_RULES = {rule.name.lower(): rule for rule in Rule}
VARIANTS = (*_RULES, "nearest")
_LOOKS = 4_000_000
"""Entries of the table of gaps looked at between two looks at the clock: about 10 ms."""
_NEAR = 20
"""Tasks that ``nearest`` looks at before it looks at all, where there is no matrix of costs."""
_NEAREST = 1e-8
"""Seconds that ``nearest`` takes at most for the square of the number of tasks it routes: kept for what is left."""


@dataclass(frozen=True)
class Greedy(RecordedSolver):
    """Greedy construction, without randomness.

    variant : which task is added next, and where: regret, cheapest, shortest or nearest.
    """

    variant: str = "regret"

    proves: ClassVar[bool] = False
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance", "time", "window", "metric"})

    def __post_init__(self) -> None:
        if self.variant not in VARIANTS:
            near_miss = suggestion(str(self.variant), VARIANTS)
            raise InputError(f"greedy: variant must be one of {', '.join(VARIANTS)}, got {self.variant!r}{near_miss}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (or load them from numba's cache)."""
        small = (warm_up_by_clock if "time" in instance.axes else warm_up)(instance, 3, 1)
        for variant in {self.variant, "nearest"}:
            Greedy(variant).solve(small, limits=Limits(time=3600.0))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Construct routes; an iteration limit has no meaning here."""
        instance = recorder.instance
        if "time" in instance.axes:
            from formulations.routing.clocked.construction import greedy_by_clock  # here: it asks for greedy tours

            return greedy_by_clock(recorder, self.variant)
        endurance = Endurance(instance, search_costs(instance))
        tours, in_time = self._constructed(recorder, endurance.costs)
        for reference in (float(tours.cost.max()), endurance.most):
            if endurance.limited and recorder.routes is None and in_time:
                endurance.refer(reference)
                _, in_time = self._constructed(recorder, endurance.costs)
        return recorder.result("finished" if in_time else "time")

    def _constructed(self, recorder: Recorder, costs: Costs) -> tuple[Tours, bool]:
        """Offer routes to the recorder; return them, and whether they were finished in time."""
        tours = empty_tours(recorder.instance.n_tasks, recorder.instance.n_depots)
        in_time = self.variant == "nearest" or _insert_all(costs, tours, _RULES[self.variant], recorder)
        extend_nearest(costs, tours, _near(costs, recorder.instance.n_tasks))
        recorder.incumbent(to_routes(tours))
        return tours, in_time


def _insert_all(costs: Costs, tours: Tours, rule: Rule, recorder: Recorder) -> bool:
    """Fill `tours` by `rule` until all is routed or the time is up; return whether all is."""
    n, m = recorder.instance.n_tasks, recorder.instance.n_depots
    gaps = first_gaps(costs, n)
    chunk = max(1, _LOOKS // (n * (m + 10)))
    left = n
    while left and recorder.remaining > _NEAREST * left**2:
        insert_many(costs, tours, gaps, rule, min(chunk, left))
        left -= min(chunk, left)
    return left == 0


def _near(costs: Costs, n_tasks: int) -> Nodes:
    """Return tasks near each where a look at all would compute their legs anew, (n, q); else none, (n, 0)."""
    return (
        near_places(costs, n_tasks, _NEAR, 1)[0] if isinstance(costs, PlaceCosts) else np.empty((n_tasks, 0), np.int32)
    )


def greedy_routes(instance: Instance) -> Routes:
    """Return the greedy routes, however long it takes."""
    routes = Greedy().solve(instance, limits=Limits(time=float("inf"))).routes
    assert routes is not None
    return routes
