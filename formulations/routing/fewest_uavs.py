"""The fewest UAVs that fly all tasks within a makespan of L, and which.

    min |K|   s.t.   routes of the UAVs K with C_k ≤ min(L, L_k)

One K is one instance: its depots alone, endurance min(L, L_k). Any routes are a yes, a proof that there are none is a
no, and any exact method that takes endurance decides (`Decision` ends it at the first routes).

* **Monotone**: with K every superset can, and where K cannot no subset can. So when no K of s UAVs can, at least s + 1
  are needed, and nothing smaller need be looked at.
* **Interchangeable UAVs** (`symmetries.shared_depots`: one depot, class and endurance) are counted, not named: K
  takes the first of them. Identical fleets at one depot thus have one K of each size.
* **Length**: the arcs of any routes cost Σ_k C_k ≥ their cheapest choice, and K flies Σ_{k∈K} min(L, L_k) at most.

All UAVs are asked first. Then one UAV fewer than the best routes so far use is tried, those that fly least left out
first, until no K of that size can: this is the proof. Where the clock ends decisions, smaller sizes, which are easier
to refute, raise the lower end of what is then an interval.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import LinkedRecorder, RecordedSolver, Recorder
from formulations.routing.simple_bounds import least_sum
from formulations.routing.solver import Status, ignore, refusal
from formulations.routing.symmetries import shared_depots
from instances import InputError, Instance, Routes, Travel, objective, tour_costs

Uavs = tuple[int, ...]
MOST_SETS = 10_000
"""Sets of one size that are looked at; a fleet that has more stays without proof."""
_LEAST_TIME = 0.05
"""Seconds that a decision is given at least."""


@dataclass(frozen=True)
class FewestUavs:
    """How many UAVs a makespan of `limit` [s] takes.

    status : OPTIMAL (`fewest` is proved), FEASIBLE (between `at_least` and `fewest`), INFEASIBLE (not even all UAVs
        can), NO_SOLUTION (nothing was found in time).
    at_least : no fewer can; m + 1 where INFEASIBLE.
    routes : those of the fewest UAVs found, of all m UAVs, or None.
    decided : number of sets of UAVs for which a solver was asked.
    """

    status: Status
    limit: float
    at_least: int
    routes: Routes | None
    decided: int

    @property
    def uavs(self) -> Uavs:
        """The UAVs (0..m−1) that fly."""
        return tuple(k for k, route in enumerate(self.routes or ()) if route)

    @property
    def fewest(self) -> int | None:
        """How many of them there are, or None where no routes were found."""
        return None if self.routes is None else len(self.uavs)


class Decision(LinkedRecorder):
    """A recorder for which any routes are enough: no time remains once it has some. (`exact` wants a linked one.)"""

    @property
    def remaining(self) -> float:
        """Wall clock left [s]; 0 with routes."""
        return 0.0 if self.routes is not None else super().remaining


def fewest_uavs(
    instance: Instance,
    limit: float,
    solver: RecordedSolver,
    *,
    limits: Limits,
    seed: int = 0,
    observe: Callable[[int, int | None], object] = lambda at_least, fewest: None,
) -> FewestUavs:
    """Return the fewest UAVs of `instance` that fly all tasks with no tour longer than `limit` [s].

    observe : called with `at_least` and `fewest` when either is better than before.

    Raises InputError where `limit` is not positive or the solver does not take the instance.
    """
    if not 0 < limit < math.inf:
        raise InputError(f"limit must be positive [s], got {limit}")
    limited = replace(instance, endurance=np.minimum(instance.limits, limit))
    if "window" in limited.axes:  # tours are landings, endurance counts from take-off: one number cannot be both
        raise InputError(f"instance {instance.name}: the fewest UAVs are not known where take-off is within a window")
    if reason := refusal(solver, limited):
        raise InputError(reason)
    solver.prepare(limited)  # before the clock begins
    return _Search(limited, limit, solver, limits, seed, observe).run()


class _Search:
    """The search of one call: what is known is `at_least`, `best` routes and the sets `refuted`."""

    def __init__(
        self,
        limited: Instance,
        limit: float,
        solver: RecordedSolver,
        limits: Limits,
        seed: int,
        observe: Callable[[int, int | None], object],
    ) -> None:
        self.instance, self.limit, self.solver, self.limits, self.seed = limited, limit, solver, limits, seed
        self.observe = observe
        self.clock = Recorder(limited, limits, ignore)
        self.groups = [[k - limited.n_tasks for k in group] for group in shared_depots(limited)]
        self.best: Routes | None = None
        self.refuted: list[frozenset[int]] = []
        self.decided = 0
        total = least_sum(limited, float(limited.cost.max()) * limited.n_nodes or 1.0)
        reach = np.cumsum(np.sort(limited.limits)[::-1])
        self.at_least = max(1, int(np.searchsorted(reach, total * (1 - 1e-9))) + 1)

    def run(self) -> FewestUavs:
        """Ask for all UAVs, then for ever fewer, then refute smaller sets where larger ones stay open."""
        m = self.instance.n_depots
        answer = self.decide(tuple(range(m)), self.clock.remaining / 2) if self.at_least <= m else False
        if answer is False:
            self.learn(m + 1)
        size = m - 1 if self.best is None else len(self.used()) - 1
        while self.at_least <= size and self.clock.remaining > 0:
            found = self.try_size(size)
            size = len(self.used()) - 1 if found else size - 1
        return FewestUavs(self.status(), self.limit, self.at_least, self.best, self.decided)

    def try_size(self, size: int) -> bool:
        """Decide the sets of `size` UAVs until one can; where none can, `at_least` is more than that."""
        flown = np.zeros(self.instance.n_depots) if self.best is None else tour_costs(self.instance, self.best)
        groups = sorted(self.groups, key=lambda group: -max(flown[group]))
        every = list(islice(sets_of(groups, size), MOST_SETS + 1))
        sets = [uavs for uavs in every[:MOST_SETS] if not any(known.issuperset(uavs) for known in self.refuted)]
        open_sets = len(every) > MOST_SETS
        for number, uavs in enumerate(sets):
            left = self.clock.remaining if size == self.at_least else self.clock.remaining / 2
            answer = self.decide(uavs, left / (len(sets) - number))
            if answer:
                return True
            open_sets |= answer is None
        if not open_sets:
            self.learn(size + 1)
        return False

    def decide(self, uavs: Uavs, share: float) -> bool | None:
        """Return whether these UAVs can fly all tasks, None where a share of time [s] did not tell."""
        if self.clock.remaining <= 0:
            return None
        part = of_uavs(self.instance, uavs)
        total = least_sum(part, float(part.cost.max()) * part.n_nodes or 1.0)
        if total * (1 - 1e-9) > part.limits.sum():
            self.refuted.append(frozenset(uavs))
            return False
        self.decided += 1
        limits = replace(self.limits, time=max(share, _LEAST_TIME))
        result = self.solver.search(Decision(part, limits, ignore), self.seed)
        if result.status is Status.INFEASIBLE:
            self.refuted.append(frozenset(uavs))
            return False
        if result.routes is None:
            return None
        routes: list[tuple[int, ...]] = [()] * self.instance.n_depots
        for k, route in zip(uavs, result.routes, strict=True):
            routes[k] = route
        assert math.isfinite(objective(self.instance, routes))
        self.best = tuple(routes)
        self.observe(self.at_least, len(self.used()))
        return True

    def learn(self, at_least: int) -> None:
        """Note that no fewer can."""
        if at_least > self.at_least:
            self.at_least = at_least
            self.observe(at_least, None if self.best is None else len(self.used()))

    def used(self) -> Uavs:
        """Return the UAVs that fly in the best routes."""
        return tuple(k for k, route in enumerate(self.best or ()) if route)

    def status(self) -> Status:
        """Return what is known."""
        if self.best is None:
            return Status.INFEASIBLE if self.at_least > self.instance.n_depots else Status.NO_SOLUTION
        return Status.OPTIMAL if self.at_least >= len(self.used()) else Status.FEASIBLE


def sets_of(groups: list[list[int]], size: int) -> Iterator[Uavs]:
    """Yield the sets of `size` UAVs that take the first of each group, those with more of the first groups first."""
    if not groups:
        if size == 0:
            yield ()
        return
    first, others = groups[0], groups[1:]
    room = sum(map(len, others))
    for count in range(min(len(first), size), max(0, size - room) - 1, -1):
        for rest in sets_of(others, size - count):
            yield (*first[:count], *rest)


def of_uavs(instance: Instance, uavs: Uavs) -> Instance:
    """Return the instance with these UAVs (0..m−1) alone, in this order."""
    chosen = list(uavs)
    kept = [*instance.tasks, *(instance.n_tasks + k for k in uavs)]
    whole = instance.travel or Travel(instance.cost[None, None], instance.classes)
    travel = Travel(whole.cost[:, :, kept][:, :, :, kept], whole.classes[chosen], whole.departures)
    xy = None if instance.coordinates is None else instance.coordinates[kept]
    endurance = None if instance.endurance is None else instance.endurance[chosen]
    name = f"{instance.name} of {len(chosen)}"
    return Instance.of_travel(name, travel, instance.n_tasks, coordinates=xy, endurance=endurance)
