"""Recorder: the clock, incumbent, bound and trace that every method keeps the same way; RecordedSolver begins one.

Linked recorders: two processes on one instance that share incumbent and bound as they find them.
"""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from multiprocessing.connection import Connection
from typing import Any, ClassVar

from formulations.limits import Limits
from formulations.routing.solver import Event, Observer, Result, Solver, Status, ignore
from instances import Instance, Routes, as_routes, objective


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
        """Offer complete routes; keep and stream them where the UAVs can fly them and they are the best so far."""
        routes = as_routes(routes)
        value = objective(self.instance, routes)
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

    def infeasible(self, message: str = "", **statistics: Any) -> Result:
        """Write the Result of a proof that the UAVs cannot fly all tasks."""
        return Result(
            Status.INFEASIBLE,
            elapsed=self.elapsed,
            trace=tuple(self._trace),
            stopped_by="proof",
            message=message or "No routes exist that the UAVs can fly.",
            statistics=statistics,
        )


class RecordedSolver(Solver):
    """A solver that says all it finds to a recorder, of the class `recorder`."""

    recorder: ClassVar[type[Recorder]] = Recorder

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Search with a recorder that knows `start`."""
        return self.search(self.recorder(instance, limits, observe, start), seed)

    @abstractmethod
    def search(self, recorder: Recorder, seed: int) -> Result:
        """Look for better routes than the recorder's and for bounds within its limits; write the recorder's result."""


class LinkedRecorder(Recorder):
    """A recorder that tells a peer what it learns, and learns from it whenever it is asked for the time left.

    Methods ask for `remaining` often, so that is where messages are read. Once bound and incumbent meet, or the peer is
    gone with a proof, no time remains.
    """

    link: Connection | None = None
    tolerance = 0.0
    met_by_peer = False

    @property
    def remaining(self) -> float:
        """Wall clock left [s]; 0 once bound and incumbent meet."""
        self.listen()
        return 0.0 if self.met_by_peer else super().remaining

    def _stream(self, routes: Routes | None) -> None:
        super()._stream(routes)
        self._tell(("bound", self.bound) if routes is None else ("routes", routes))

    def listen(self) -> None:
        """Take in what the peer has sent."""
        link, self.link = self.link, None  # what came from the peer is not sent back
        try:
            while link is not None and link.poll():
                kind, value = link.recv()
                if kind == "routes":
                    self.incumbent(value)
                elif kind == "bound":
                    self.raise_bound(value)
                elif kind == "proof":
                    self.tolerance, self.met_by_peer = value, True
        except (EOFError, OSError):  # the peer has ended; what it said stays
            link = None
        self.link = link

    def _tell(self, message: tuple[str, object]) -> None:
        if self.link is not None:
            try:
                self.link.send(message)
            except (BrokenPipeError, OSError):
                self.link = None

    def tell_proof(self, tolerance: float) -> None:
        """Say that routes and bound now meet within `tolerance` [s]."""
        self._tell(("proof", tolerance))
