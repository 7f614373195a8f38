"""The nouns of selection: SelectionProblem, Record, the SelectionMethod protocol, Selection; and `select`.

    max f(S)   over sets S of tasks that the UAVs can fly: a partition of S into one tour a UAV, each with C_k ≤ L_k

where not all tasks can be flown. With modular prizes this is the team orienteering problem (Chao, Golden & Wasil,
EJOR 88, 1996), here with a depot, costs and an endurance of its own for every UAV; with information it is what can be
learned within endurance. A method only proposes routes and bounds: `Record` recomputes what routes are worth.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

from formulations.blas import one_thread
from formulations.limits import Limits
from formulations.routing.solver import Status
from formulations.selection.worth import Worth
from instances import InputError, Instance, Routes, as_routes, check_routes, tour_costs

TOLERANCE = 1e-6
"""Of the worth: selections better by less are neither looked for nor excluded."""

Observer = Callable[[float, float, float], None]
"""Is told elapsed [s], worth and bound at each improvement of either."""


@dataclass(frozen=True, eq=False)
class SelectionProblem:
    """Which of an instance's tasks to fly.

    Parameters
    ----------
    instance
        With the endurance that limits each UAV [s]; without it everything fits that can be flown at all.
    worth
        Of its tasks.

    Raises
    ------
    InputError
        Where they do not belong together, or costs change with time or states.
    """

    instance: Instance
    worth: Worth

    def __post_init__(self) -> None:
        n = self.instance.n_tasks
        if self.worth.n_tasks != n:
            raise InputError(f"there are {self.worth.n_tasks} prizes for the {n} tasks of {self.instance.name}")
        if axes := self.instance.axes & {"time", "states"}:
            raise InputError(f"{self.instance.name}: selection takes no costs that depend on {' and '.join(axes)}")


class Record:
    """The clock, the best routes, the bound and the trace that every method keeps the same way."""

    def __init__(self, problem: SelectionProblem, limits: Limits, observe: Observer | None = None) -> None:
        self.problem, self.limits = problem, limits
        self.routes: Routes = ((),) * problem.instance.n_depots
        self.value = 0.0
        self.upper = math.inf
        self.trace: list[tuple[float, float, float]] = []
        self._observe = observe
        self._began = time.perf_counter()

    @property
    def elapsed(self) -> float:
        """Wall clock since the method began [s]."""
        return time.perf_counter() - self._began

    @property
    def remaining(self) -> float:
        """Wall clock left [s], never negative."""
        return max(0.0, self.limits.time - self.elapsed)

    @property
    def tolerance(self) -> float:
        """How much better a selection may be that is not looked for."""
        return max(TOLERANCE * self.value + 2 * self.problem.worth.rounding, 1e-300)

    @property
    def wanted(self) -> float:
        """What a better selection is worth at least; a bound below it proves that there is none."""
        return self.value + (self.problem.worth.step or self.tolerance)

    @property
    def proved(self) -> bool:
        """Whether no selection is better."""
        return self.upper < self.wanted

    def offer(self, routes: Routes) -> bool:
        """Keep `routes` where they are feasible and worth more than the best so far."""
        tasks = [task for route in routes for task in route]
        value = self.problem.worth.value(tasks)
        if not value > self.value or check_routes(self.problem.instance, routes, all_tasks=False):
            return False
        self.routes, self.value = as_routes(routes), value
        self._tell()
        return True

    def lower(self, bound: float) -> None:
        """Keep a valid upper bound on the worth of every selection where it is below the best so far."""
        bound = self.problem.worth.bound(bound)
        if bound < self.upper:
            self.upper = bound
            self._tell()

    def _tell(self) -> None:
        self.trace.append((self.elapsed, self.value, self.upper))
        if self._observe is not None:
            self._observe(*self.trace[-1])


class SelectionMethod(Protocol):
    """A method of selection. Options are the fields of the (dataclass) implementation, each with a default.

    Subclass it explicitly to inherit the defaults of `accepts` and `prepare`.
    """

    def accepts(self, problem: SelectionProblem) -> str | None:
        """Return why this method does not take `problem`, in a sentence, or None where it does."""
        return None

    def prepare(self, problem: SelectionProblem) -> None:
        """Do what is not part of the search: imports, compilation of kernels. Not timed."""
        return None

    def search(self, problem: SelectionProblem, record: Record, seed: int) -> str:
        """Offer routes and bounds to `record`, better and better; return what ended it, as `Result.stopped_by`."""
        ...


@dataclass(frozen=True, eq=False)
class Selection:
    """The tasks worth flying within endurance.

    Parameters
    ----------
    problem
        What was asked.
    tasks
        Those chosen, in increasing order.
    routes
        One a UAV, over exactly these tasks.
    worth
        f(tasks), recomputed: prizes, or nats.
    bound
        No selection is worth more, valid in floating point.
    status
        OPTIMAL where that proves it, else FEASIBLE.
    method, seed, stopped_by
        Who found it, and how it ended.
    elapsed
        Wall clock [s].
    trace
        (elapsed [s], worth, bound) at each improvement.
    """

    problem: SelectionProblem
    tasks: tuple[int, ...]
    routes: Routes
    worth: float
    bound: float
    status: Status
    method: str
    seed: int = 0
    elapsed: float = 0.0
    stopped_by: str = "finished"
    trace: tuple[tuple[float, float, float], ...] = field(default=())

    @property
    def gap(self) -> float:
        """(bound − worth) / bound; 0 where nothing is to be had."""
        return max(0.0, (self.bound - self.worth) / self.bound) if self.bound > 0 else 0.0

    @property
    def left_out(self) -> tuple[int, ...]:
        """The tasks not chosen."""
        return tuple(i for i in self.problem.instance.tasks if i not in self.tasks)

    @property
    def everything(self) -> float:
        """What all tasks together would be worth."""
        return self.problem.worth.value(self.problem.instance.tasks)

    def summary(self) -> str:
        """One line for people."""
        n, unit = self.problem.instance.n_tasks, self.problem.worth.unit
        return (
            f"{self.status}: {len(self.tasks)} of {n} tasks, {self.worth:.6g} of {self.everything:.6g} ({unit}), "
            f"bound {self.bound:.6g} (gap {self.gap:.2%}), {self.elapsed:.2f} s, stopped by {self.stopped_by}"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the selection as JSON values; the digest is the instance's without endurance."""
        instance = self.problem.instance
        return {
            "instance": instance.name,
            "digest": replace(instance, endurance=None).digest,
            "endurance": [limit if math.isfinite(limit) else None for limit in instance.limits.tolist()],
            "method": self.method,
            "status": str(self.status),
            "tasks": list(self.tasks),
            "routes": [list(route) for route in self.routes],
            "tour_costs": tour_costs(instance, self.routes).tolist(),
            "worth": self.worth,
            "unit": self.problem.worth.unit,
            "bound": self.bound,
            "gap": self.gap,
            "left_out": list(self.left_out),
            "everything": self.everything,
            "about": dict(self.problem.worth.about),
            "seed": self.seed,
            "elapsed": self.elapsed,
            "stopped_by": self.stopped_by,
            "trace": [list(event) for event in self.trace],
        }


@one_thread()
def select(
    problem: SelectionProblem,
    method: SelectionMethod,
    name: str,
    *,
    seed: int = 0,
    limits: Limits | None = None,
    observe: Observer | None = None,
) -> Selection:
    """Run `method` on `problem` and return its best routes, with a bound whatever the method found.

    Raises InputError where the method does not take the problem.
    """
    from formulations.selection.simple_bounds import simple_bound  # here: it reads this module's nouns

    if why := method.accepts(problem):
        raise InputError(f"{name}: {why}")
    method.prepare(problem)
    record = Record(problem, limits or Limits(), observe)
    record.lower(simple_bound(problem))
    stopped_by = "proof" if record.proved else method.search(problem, record, seed)
    return Selection(
        problem=problem,
        tasks=tuple(sorted(task for route in record.routes for task in route)),
        routes=record.routes,
        worth=record.value,
        bound=max(record.upper, record.value),
        status=Status.OPTIMAL if record.proved else Status.FEASIBLE,
        method=name,
        seed=seed,
        elapsed=record.elapsed,
        stopped_by="proof" if record.proved else stopped_by,
        trace=tuple(record.trace),
    )
