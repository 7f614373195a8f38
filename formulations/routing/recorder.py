"""Recorder: the clock, incumbent, bound and trace that every method keeps the same way."""

from __future__ import annotations

import math
import time
from typing import Any

from formulations.limits import Limits
from formulations.routing.solver import Event, Observer, Result, Status
from instances import Instance, Routes, as_routes, makespan


class Recorder:
    """Keeps the best routes and bound of one solve, streams events and writes the Result.

    The objective is always recomputed from the routes, and only improvements are recorded.
    """

    def __init__(self, instance: Instance, limits: Limits, observe: Observer, start: Routes | None = None) -> None:
        self.instance = instance
        self.limits = limits
        self.objective = math.inf
        self.bound = 0.0
        self.routes: Routes | None = None
        self._observe = observe
        self._trace: list[Event] = []
        self._began = time.perf_counter()
        if start is not None:
            self.incumbent(start)

    @property
    def elapsed(self) -> float:
        """Wall clock since the solve began [s]."""
        return time.perf_counter() - self._began

    @property
    def remaining(self) -> float:
        """Wall clock left under the time limit [s], never negative."""
        return max(0.0, self.limits.time - self.elapsed)

    def incumbent(self, routes: Routes) -> bool:
        """Offer routes; keep and stream them where they are better than the best so far."""
        routes = as_routes(routes)
        value = makespan(self.instance, routes)
        if value >= self.objective:
            return False
        self.objective, self.routes = value, routes
        self._stream(routes)
        return True

    def raise_bound(self, bound: float) -> bool:
        """Offer a valid lower bound [s]; keep and stream it where it is higher than the best so far."""
        if not bound > self.bound:
            return False
        self.bound = bound
        self._stream(None)
        return True

    def _stream(self, routes: Routes | None) -> None:
        objective = None if self.routes is None else self.objective
        bound = self.bound if self.bound > 0 else None
        event = Event(self.elapsed, objective, bound, routes)
        self._trace.append(Event(event.elapsed, objective, bound))
        self._observe(event)

    def result(
        self, stopped_by: str, *, proved: bool = False, tolerance: float = 0.0, message: str = "", **statistics: Any
    ) -> Result:
        """Write the Result: OPTIMAL where `proved`, else FEASIBLE or NO_SOLUTION.

        A bound is reported where the method gave one (or proved), cut off at the objective: within the tolerance
        rounding can put it a hair above.
        """
        found = Status.OPTIMAL if proved else Status.FEASIBLE
        has_bound = proved or self.bound > 0
        return Result(
            status=Status.NO_SOLUTION if self.routes is None else found,
            objective=None if self.routes is None else self.objective,
            bound=min(self.bound, self.objective) if has_bound else None,
            elapsed=self.elapsed,
            routes=self.routes,
            trace=tuple(self._trace),
            stopped_by=stopped_by,
            message=message,
            tolerance=tolerance,
            statistics=statistics,
        )
