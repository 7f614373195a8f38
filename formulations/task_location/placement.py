"""The nouns of sub-problem 1: PlacementProblem, Progress, the PlacementMethod protocol, Placement; and `place`.

    P_T* = argmax over P_T in A of I(y_T(P_T); y_o(P_o)),   |P_T| = n        (paper, eq. obj_tasklocation)

A method only proposes points: `place` checks that they lie in the region and recomputes what they are worth.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from formulations.blas import one_thread
from formulations.limits import Limits
from formulations.task_location.criterion import Convention
from formulations.task_location.variance_reduction import NAME, Goal, VarianceReduction
from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError, shown

CANDIDATES_PER_AXIS = 41
TRACE_STEP = 0.01
"""Improvements [nats] smaller than this share an event of the trace."""


class PlacementStatus(StrEnum):
    """What is known about a placement. None says optimal: the problem is non-convex and only bounded from above."""

    LOCALLY_SOLVED = "locally solved"
    """A stationary point within the method's tolerance; another start could end higher."""
    HEURISTIC = "heuristic"
    """Points in the region, and no more is known; also a local method that a limit stopped."""


@dataclass(frozen=True, eq=False)
class PlacementProblem:
    """Where to put n tasks in a region.

    Parameters
    ----------
    region
        A.
    criterion
        What is maximised: mutual information, or how far the mean variance falls (criterion "j").
    n_tasks
        n, from 1 to the number of `candidates`.
    candidates_per_axis
        The candidate sites are a lattice of so many points a side, border included, over the region's bounding box,
        those inside.

    Raises
    ------
    InputError
        Where n does not fit.
    """

    region: Region
    criterion: Goal
    n_tasks: int
    candidates_per_axis: int = CANDIDATES_PER_AXIS

    def __post_init__(self) -> None:
        n = self.n_tasks
        if not isinstance(n, (int, np.integer)) or isinstance(n, bool) or n < 1:
            raise InputError(f"placement: the number of tasks must be a whole number of at least 1, got {shown(n)}")
        if n > len(self.candidates):
            raise InputError(
                f"placement: {n} tasks do not fit: the region has {len(self.candidates)} candidate sites "
                f"({self.candidates_per_axis} × {self.candidates_per_axis} over its bounding box, those inside)"
            )

    @cached_property
    def candidates(self) -> Floats:
        """Candidate sites, shape (k, 2) [m]; a point of the interior is added where the lattice misses the region."""
        sites = lattice(self.region, self.candidates_per_axis)
        if len(sites):
            return sites
        inside = self.region.polygon.representative_point()
        return np.array([[inside.x, inside.y]])


def lattice(region: Region, per_axis: int) -> Floats:
    """Return the points of a per_axis × per_axis lattice over the bounding box that lie in `region`, (k, 2) [m]."""
    x0, y0, x1, y1 = region.bounds
    xs, ys = np.linspace(x0, x1, per_axis), np.linspace(y0, y1, per_axis)
    sites = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    return sites[region.contains(sites)]


class OutOfTime(Exception):  # noqa: N818 - a signal, not an error
    """Raised by `Progress.check` when the time limit is over."""


class Progress:
    """The clock, the best points and the trace that every method keeps the same way."""

    def __init__(self, limits: Limits, observe: Callable[[float, float, Floats], None] | None = None) -> None:
        self.limits = limits
        self.best: Floats | None = None
        self.value = -math.inf
        self.trace: list[tuple[float, float]] = []
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

    def offer(self, points: Floats, value: float) -> bool:
        """Keep, trace and stream `points` worth `value` [nats] where they beat the best so far."""
        if not value > self.value:
            return False
        self.best, self.value = np.array(points), value
        if len(self.trace) > 1 and value - self.trace[-2][1] < TRACE_STEP:
            self.trace.pop()  # steps too small to see would make thousands of events
        self.trace.append((self.elapsed, value))
        if self._observe is not None:
            self._observe(self.elapsed, value, self.best)
        return True

    def check(self) -> None:
        """Raise OutOfTime where the limit is over."""
        if self.elapsed > self.limits.time:
            raise OutOfTime


class PlacementMethod(Protocol):
    """A method for sub-problem 1. Options are the fields of the (dataclass) implementation, each with a default.

    Subclass it explicitly to inherit `prepare`.
    """

    def prepare(self, problem: PlacementProblem) -> None:
        """Do what is not part of the search: imports and the like. Not timed."""
        return None

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer points inside the region to `progress`, better and better, and return what is known of the best."""
        ...


def share_of(value: float, certificate: float) -> float:
    """Return value / certificate; 1 where nothing can be learned, as under a noise that drowns the signal."""
    return value / certificate if certificate > 0 else 1.0


@dataclass(frozen=True, eq=False)
class Placement:
    """Task locations and what they are worth.

    Parameters
    ----------
    points
        P_T, shape (n, 2) [m], inside the region.
    mutual_information
        Under convention (b) [nats], whatever was maximised; `information` has b, a and ig.
    method, status, seed
        Who found it and what is known.
    elapsed
        Wall clock of the search alone [s].
    certificate
        No placement of n tasks in the region has more mutual information (b) [nats]; None where not asked.
    information
        Under each convention, by its name [nats].
    trace
        (elapsed [s], criterion that was maximised [nats]), improvements only.
    stopped_by
        What ended the search: "finished" or "time".
    maximised
        The criterion that was maximised: b, a, ig or j.
    average_variance, average_variance_bound
        Where j was: J, the weighted mean variance that is left at the test points, in the field's unit squared, and
        what no n readings leave less than; else None.
    """

    points: Floats
    mutual_information: float
    method: str
    status: PlacementStatus
    seed: int = 0
    elapsed: float = 0.0
    certificate: float | None = None
    information: Mapping[str, float] = field(default_factory=dict)
    trace: tuple[tuple[float, float], ...] = ()
    stopped_by: str = "finished"
    maximised: str = Convention.BOTH_NOISY
    average_variance: float | None = None
    average_variance_bound: float | None = None

    @property
    def ratio(self) -> float | None:
        """mutual_information / certificate, ≤ 1; None without a certificate."""
        return None if self.certificate is None else share_of(self.mutual_information, self.certificate)

    def summary(self) -> str:
        """One line for people."""
        bound = "" if self.certificate is None else f", {self.ratio:.1%} of the bound {self.certificate:.4g}"
        left = ""
        if self.average_variance is not None and self.average_variance_bound is not None:
            sd, least = math.sqrt(self.average_variance), math.sqrt(self.average_variance_bound)
            left = f", leaving a weighted rms sd of {sd:.4g} where at least {least:.4g} must stay ({least / sd:.1%})"
        return (
            f"{self.method} ({self.status}): {len(self.points)} tasks worth {self.mutual_information:.4f} nats"
            f"{bound}{left}, {self.elapsed:.2f} s"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the placement as JSON values."""
        said = {
            "method": self.method,
            "status": str(self.status),
            "points": self.points.tolist(),
            "mutual_information": self.mutual_information,
            "certificate": self.certificate,
            "elapsed": self.elapsed,
            "ratio": self.ratio,
            "information": dict(self.information),
            "maximised": str(self.maximised),
            "seed": self.seed,
            "stopped_by": self.stopped_by,
            "trace": [list(event) for event in self.trace],
        }
        if self.average_variance is not None:
            said |= {"average_variance": self.average_variance, "average_variance_bound": self.average_variance_bound}
        return said


@one_thread()
def place(
    problem: PlacementProblem,
    method: PlacementMethod,
    name: str,
    *,
    seed: int = 0,
    limits: Limits | None = None,
    certificate: float | None = None,
    observe: Callable[[float, float, Floats], None] | None = None,
) -> Placement:
    """Run `method` on `problem` and return its best points, checked and worth recomputed.

    certificate [nats] : an upper bound to report beside them (certificate.py).
    observe : called with (elapsed, value, points) at each improvement.
    Raises InputError for a negative seed, RuntimeError where the method offers nothing or points outside the region.
    """
    if seed < 0:
        raise InputError(f"placement: the seed must not be negative, got {seed}")
    method.prepare(problem)
    progress = Progress(limits or Limits(time=math.inf), observe)
    stopped_by = "finished"
    try:
        status = method.search(problem, progress, seed)
    except OutOfTime:
        status, stopped_by = PlacementStatus.HEURISTIC, "time"
    elapsed = progress.elapsed
    if progress.best is None:
        raise RuntimeError(f"{name} offered no points")
    found = appraised(problem, checked_points(problem, progress.best, name), name, status)
    return replace(
        found,
        seed=seed,
        elapsed=elapsed,
        certificate=certificate,
        trace=tuple(progress.trace),
        stopped_by=stopped_by,
    )


def appraised(problem: PlacementProblem, points: Floats, method: str, status: PlacementStatus) -> Placement:
    """Return what `points` of the region, found by `method`, are worth."""
    goal = problem.criterion
    worth = {str(c): goal.under(c).value(points) for c in Convention}
    found = Placement(
        points=points,
        mutual_information=worth[Convention.BOTH_NOISY],
        method=method,
        status=status,
        information=worth,
        maximised=NAME if isinstance(goal, VarianceReduction) else goal.convention,
    )
    if not isinstance(goal, VarianceReduction):
        return found
    left, least = goal.judged.value(points), goal.judged.lower_bound(len(points))
    return replace(found, average_variance=left, average_variance_bound=least)


def checked_points(problem: PlacementProblem, points: Floats, name: str) -> Floats:
    """Return `points` made read-only; RuntimeError where they are not n points of the region."""
    if points.shape != (problem.n_tasks, 2):
        raise RuntimeError(f"{name} offered points of shape {points.shape} for {problem.n_tasks} tasks")
    # a point snapped to a slanted border is inside only up to rounding
    outside = ~problem.region.contains(points) & (problem.region.signed_distance(points) < -1e-6)
    if outside.any():
        i = int(np.flatnonzero(outside)[0])
        raise RuntimeError(f"{name} offered point {i} outside the region: {points[i].tolist()}")
    points.setflags(write=False)
    return points
