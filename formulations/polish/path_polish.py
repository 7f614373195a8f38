"""Path polish: the waypoints of tours moved for what is sensed along them, the order of visits fixed.

A plan of whole tasks leaves endurance unused and senses on its legs what it did not ask for. Here the tasks become
waypoints, legs are split, and all of them move for J, the average variance that the samples of the paths leave:

1. L-BFGS-B on the objective (objective.py), ρ rising; first with samples held at their shares of the legs, which is
   smooth, then with samples by the clock, which is what is flown.
2. What is flown costs more than straight legs, for its turns. Budgets of straight legs are lowered by the difference
   and step 1 is gone on with, until flights fit.
3. A path that still costs too much or leaves the room is drawn back towards the one it began as, as far as need be.

The paths that are returned fit, or are those that were given. Nothing is claimed beyond a local optimum; for what any
paths could reach see `formulations.path_bound`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from scipy.optimize import minimize
from shapely.geometry import Polygon

from formulations.average_variance import AverageVariance
from formulations.blas import one_thread
from formulations.polish.objective import Objective
from formulations.polish.sampling import Samples, count_of, times_of
from formulations.polish.straight_legs import StraightLegs
from formulations.task_location.boundary import box, is_rectangle
from instances.arrays import Bools, Floats
from instances.environment.region import Region
from instances.errors import InputError
from instances.paths import NEAR

FIRST = ((1e1, True), (1e2, True), (1e2, False), (1e3, False), (1e4, False), (1e5, False))
"""Rounds: ρ, and whether samples are held."""
LATER = ((1e3, True), (1e4, False), (1e5, False))
"""Rounds from paths that are polished nearly."""
STEPS = 50
"""Steps of L-BFGS-B in a round at most: a round later samples sit elsewhere."""
WARM_STEPS = 25
"""The same where paths were polished before: maps in flight are no worse, in two thirds of the time."""
SLACK = 2e-4
"""Share of a budget that straight legs leave: a penalty lets them pass it by less."""
FITS = 4
"""Times that budgets of straight legs are lowered until flights fit."""
HALVINGS = 8
"""Bisections of how far a path that does not fit is drawn back."""


@dataclass(frozen=True, eq=False)
class PolishProblem:
    """Paths to polish.

    judged : what stays unknown; readings that are there already are its `known`.
    legs : what straight legs cost and how long they take.
    period : time between two samples of a UAV [s], the first one period after its start.
    paths : of each UAV the places it flies over from where it is to its home, (w + 1, 2) [m]; none for one that stays
        there. Both ends stay, whatever is between them moves.
    budgets : what the flight of each UAV may still cost [s], (m,).
    room : where legs are to stay. inner : where waypoints are to, for turns to have room; all of `room` unless given.
    flown : UAV and waypoints (w + 1, 2) [m] to the cost [s] of the flight over them, and whether it can be flown;
        None where straight legs are flown.
    start : when the paths are begun [s], by the clock of `judged`; looked at where the field drifts.

    Raises InputError naming what does not fit.
    """

    judged: AverageVariance
    legs: StraightLegs
    period: float
    paths: Sequence[Floats]
    budgets: Floats
    room: Region
    inner: Region | None = None
    flown: Callable[[int, Floats], tuple[float, bool]] | None = None
    start: float = 0.0

    def __post_init__(self) -> None:
        if not self.period > 0:
            raise InputError(f"polish: the sensing period must be positive, got {self.period} s")
        object.__setattr__(self, "paths", [np.asarray(path, dtype=float).reshape(-1, 2) for path in self.paths])
        object.__setattr__(self, "budgets", np.asarray(self.budgets, dtype=float).reshape(-1))
        if len(self.budgets) != len(self.paths) or not (self.budgets >= 0).all() or np.isinf(self.budgets).any():
            raise InputError(f"polish: {len(self.paths)} paths need as many finite budgets [s], got {self.budgets}")

    def samples(self, paths: Sequence[Floats]) -> tuple[Floats, Floats]:
        """Return where `paths` are sampled, flown straight, (n, 2) [m], and when, (n,) [s]."""
        found, counts = [np.empty((0, 2))], list[int]()
        for path in paths:
            if len(path) > 1:
                durations = self.legs(path).duration
                counts.append(count_of(float(durations.sum()), self.period))
                found.append(Samples.along(path, durations, self.period, counts[-1]).places)
        return np.concatenate(found), self.start + times_of(counts, self.period)

    def value(self, paths: Sequence[Floats]) -> float:
        """Return J after `paths`, flown straight."""
        return self.judged.value(*self.samples(paths))

    def cost(self, uav: int, path: Floats) -> tuple[float, bool]:
        """Return what the flight of `uav` along `path` costs [s], and whether it can be flown in the room."""
        if len(path) < 2:
            return 0.0, True
        cost, flies = (float(self.legs(path).cost.sum()), True) if self.flown is None else self.flown(uav, path)
        return cost, flies and bool(shapely.covers(self._widened, shapely.linestrings(path)))

    def fits(self, uav: int, path: Floats) -> bool:
        """Say whether `uav` may fly `path`."""
        cost, flies = self.cost(uav, path)
        return flies and cost <= self.budgets[uav]

    @cached_property
    def _widened(self) -> Polygon:
        room = self.room.polygon.buffer(NEAR)
        shapely.prepare(room)
        return room


@dataclass(frozen=True, eq=False)
class Polished:
    """What came of it.

    paths : of each UAV the waypoints from its start to its home, (w + 1, 2) [m]. before, after : J of straight flight
    along the given paths and these. costs : of the flights [s], (m,). moved : which UAVs fly other paths than given.
    """

    paths: list[Floats]
    before: float
    after: float
    costs: Floats
    moved: Bools = field(default_factory=lambda: np.empty(0, dtype=bool))


@one_thread()
def polish(problem: PolishProblem, *, spacing: float | None = None, warm: bool = False) -> Polished:
    """Return the paths of `problem` polished; those of UAVs for which nothing better fits are as given.

    spacing : legs longer than this [m] are split; half the shorter length scale unless given.
    warm : the paths were polished before and little has changed since: fewer rounds.
    """
    longest = 0.5 * min(problem.judged.kernel.length_scales) if spacing is None else spacing
    if not longest > 0:
        raise InputError(f"polish: the spacing of waypoints must be positive, got {longest} m")
    given = problem.paths
    begin = [split(path, longest) if len(path) > 1 else path for path in given]
    before = problem.value(given)
    flying = [k for k, path in enumerate(begin) if len(path) > 2 and problem.budgets[k] > 0]
    paths = list(given)
    if flying:
        found = _Search(problem, begin, flying, WARM_STEPS if warm else STEPS).run(LATER if warm else FIRST)
        for k in flying:
            paths[k] = found[k]
    after = problem.value(paths)
    if not after < before:
        paths, after = list(given), before
    moved = np.array([path is not old for path, old in zip(paths, given, strict=True)], dtype=bool)
    return Polished(paths, before, after, np.array([problem.cost(k, p)[0] for k, p in enumerate(paths)]), moved)


def split(path: Floats, longest: float) -> Floats:
    """Return `path` (w + 1, 2) [m] with every leg cut into equal parts no longer than `longest` [m]."""
    parts = [path[:1]]
    for a, b in pairwise(path):
        count = max(1, int(np.ceil(np.hypot(*(b - a)) / longest - 1e-9)))
        parts.append(a + (np.arange(1, count + 1) / count)[:, None] * (b - a))
    return np.concatenate(parts)


class _Search:
    """Steps 1 to 3 from `begin`, for the UAVs `flying`, in rounds of `steps`; the paths of the others stay."""

    def __init__(self, problem: PolishProblem, begin: list[Floats], flying: list[int], steps: int) -> None:
        self.problem, self.begin, self.flying, self.steps = problem, begin, flying, steps
        self._inner = problem.inner or problem.room
        self._room = None if is_rectangle(problem.room) else problem.room.polygon
        self._within = None if is_rectangle(self._inner) else self._inner.polygon

    def run(self, rounds: Sequence[tuple[float, bool]]) -> dict[int, Floats]:
        """Return the polished paths by UAV."""
        budgets = self.problem.budgets[self.flying]
        excess = np.array([self._excess(k, self.begin[k]) for k in self.flying])
        paths = [self.begin[k] for k in self.flying]
        for attempt in range(FITS):
            allowed = np.maximum(budgets * (1.0 - SLACK) - excess, 0.05 * budgets)
            paths = self._lowered(paths, allowed, rounds if attempt == 0 else LATER[1:])
            found = np.array([self._excess(k, path) for k, path in zip(self.flying, paths, strict=True)])
            if (found <= excess + SLACK * budgets).all():
                break
            excess = np.maximum(excess, found)
        return {k: self._drawn_back(k, path) for k, path in zip(self.flying, paths, strict=True)}

    def _excess(self, uav: int, path: Floats) -> float:
        """Return what turns cost beyond straight legs [s]."""
        return max(0.0, self.problem.cost(uav, path)[0] - float(self.problem.legs(path).cost.sum()))

    def _lowered(self, paths: list[Floats], allowed: Floats, rounds: Sequence[tuple[float, bool]]) -> list[Floats]:
        problem = self.problem
        fixed = [path for k, path in enumerate(self.begin) if k not in self.flying]
        places, times = problem.samples(fixed)
        judged = replace(
            problem.judged,
            known=np.concatenate([problem.judged.known, places]),
            known_times=np.concatenate([problem.judged.known_times, times]),
        )
        for weight, held in rounds:
            # J of a field that drifts hardly changes far from its best: held rounds are as if it stayed
            seen = replace(judged, tau=math.inf) if held else judged
            legs, period, rooms = problem.legs, problem.period, (self._room, self._within)
            objective = Objective(seen, legs, period, paths, allowed, weight, *rooms, held, problem.start)
            begin = objective.begin
            done = minimize(
                objective,
                begin,
                jac=True,
                method="L-BFGS-B",
                bounds=box(self._inner, np.asarray(judged.kernel.length_scales), len(begin) // 2),
                options={"maxiter": self.steps, "maxcor": 20},
            )
            paths = objective.moved(done.x)
        return paths

    def _drawn_back(self, uav: int, path: Floats) -> Floats:
        """Return `path`, drawn back towards its beginning as far as need be; the path given where nothing else fits."""
        problem, first = self.problem, self.begin[uav]
        if problem.fits(uav, path):
            return path
        kept, share, step = problem.paths[uav], 0.0, 0.5
        for _ in range(HALVINGS):
            between = first + (share + step) * (path - first)
            if problem.fits(uav, between):
                kept, share = between, share + step
            step *= 0.5
        return kept
