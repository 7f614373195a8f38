"""The Solver protocol and what a solver says: Status, Event, Limits, Result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, ClassVar, Protocol

from formulations.limits import Limits
from instances import Instance, Routes
from instances.travel import AXES


class Status(StrEnum):
    """What is known at the end. Which limit ended the run is another field, ``Result.stopped_by``."""

    OPTIMAL = "OPTIMAL"
    """Routes, and a proof that none is shorter by more than ``Result.tolerance``."""
    FEASIBLE = "FEASIBLE"
    """Routes without that proof."""
    INFEASIBLE = "INFEASIBLE"
    """A proof that no routes exist; only where some leg cannot be flown or endurance is limited can there be one."""
    NO_SOLUTION = "NO_SOLUTION"
    """A limit was hit before any routes were found."""
    KILLED = "KILLED"
    """The run ignored its limit, or was ended from outside, and was killed; what it had streamed is kept."""
    ERROR = "ERROR"
    """The run crashed, or claimed something that the independent check refutes."""


@dataclass(frozen=True)
class Event:
    """One point of the anytime trace.

    Parameters
    ----------
    elapsed
        Since the solve began [s].
    objective
        Of the best routes so far [s], or None.
    bound
        The best valid lower bound so far [s], or None.
    routes
        Of a new incumbent, so that a killed run keeps them, else None.
    """

    elapsed: float
    objective: float | None
    bound: float | None
    routes: Routes | None = None


Observer = Callable[[Event], None]


@dataclass(frozen=True)
class Result:
    """How a solve ended.

    Parameters
    ----------
    status
        What is known.
    objective
        C_max of `routes` [s], or None.
    bound
        A valid lower bound on the optimum of the float instance [s], or None.
    elapsed
        Wall clock of the solve alone [s]; imports and compilation belong to ``Solver.prepare``.
    routes
        The best routes, or None.
    trace
        Events in order, without routes.
    stopped_by
        "proof", "time", "iterations", "memory", "finished" (a method that just ends), "killed", "error".
    message
        One sentence for people, or "".
    tolerance
        OPTIMAL means objective − bound ≤ tolerance [s] (CP-SAT's integer scaling included).
    statistics
        The method's own figures (rounds, cuts, columns, which part proved it), JSON values only.
    """

    status: Status
    objective: float | None = None
    bound: float | None = None
    elapsed: float = 0.0
    routes: Routes | None = None
    trace: tuple[Event, ...] = ()
    stopped_by: str = ""
    message: str = ""
    tolerance: float = 0.0
    statistics: Mapping[str, Any] = field(default_factory=dict)

    @property
    def gap(self) -> float | None:
        """(objective − bound) / objective, dimensionless; 0 where the objective is 0; None where one is unknown."""
        if self.objective is None or self.bound is None:
            return None
        return (self.objective - self.bound) / self.objective if self.objective > 0 else 0.0

    def summary(self) -> str:
        """One line for people."""
        value = "no routes" if self.objective is None else f"longest tour {self.objective:.6g} s"
        bound = "" if self.bound is None else f", bound {self.bound:.6g} s (gap {self.gap or 0:.2%})"
        return f"{self.status}: {value}{bound}, {self.elapsed:.2f} s, stopped by {self.stopped_by or 'nothing'}"


def ignore(event: Event) -> None:
    """Observe nothing."""


class Solver(Protocol):
    """A method for the MMMDMTSP. Options are the fields of the (dataclass) implementation, each with a default.

    Subclass it explicitly to inherit the defaults of `accepts` and `prepare`.
    """

    proves: ClassVar[bool]
    """Whether the method can end OPTIMAL."""
    axes: ClassVar[frozenset[str]] = frozenset()
    """What it takes beyond one matrix of costs: names of `instances.travel.AXES`. See `refusal`."""

    def accepts(self, instance: Instance) -> str | None:
        """Return why this method does not take `instance`, in a sentence, or None where it does."""
        return None

    def prepare(self, instance: Instance) -> None:
        """Do what is not part of the solve: imports, compilation of kernels. Not timed."""

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Solve `instance` within `limits`, streaming events to `observe`.

        Parameters
        ----------
        instance
            Costs in seconds; only of axes that the method takes, and which it accepts.
        limits
            What it may use.
        seed
            Of all that is drawn at random.
        observe
            Called with every better incumbent or bound.
        start
            Feasible routes to begin from; methods that cannot use them ignore them, none may end worse than them, and
            a bad start must never change what an exact method proves.

        Returns
        -------
        Result
            Nothing of which is believed: routes are checked and costs computed again.
        """
        ...


ABLE = {
    "metric": "memetic, ruin-recreate and greedy can",
    "fleet": "memetic and exact can",
    "endurance": "memetic and exact can",
    "time": "exact, branch-and-price, subset-dp, memetic, ruin-recreate, ga and greedy can",
    "states": "memetic and exact can",
    "window": "memetic, ruin-recreate, ga, greedy, exact and subset-dp can",
}
"""Who to turn to, for each axis of an instance."""


def refusal(solver: Solver, instance: Instance) -> str | None:
    """Return why `solver` does not take `instance`, in a sentence: an axis it lacks, or its own reason; or None."""
    has: frozenset[str] = getattr(solver, "axes", frozenset())
    for axis, words in AXES.items():
        if axis in instance.axes - has:
            return f"the instance has {words} ('{axis}'), which this solver cannot take; {ABLE[axis]}"
    if {"metric", "endurance"} <= instance.axes:
        return "the instance has limited endurance and too many nodes for a matrix of costs; no solver takes both"
    return solver.accepts(instance)
