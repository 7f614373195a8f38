"""One re-plan: fit, place what remains given what is known, route from where the UAVs are, accept what is better.

1. The planning model, a squared exponential, is fitted to all samples S by restricted likelihood, as the map's is. What
   was believed at take-off is kept until S refutes it (refuted.py): a fit to few samples misses by more than it does.
2. r tasks are placed by I(y_T; y_o | y_S) (conditional.py) or by how far the average variance falls (remaining.py),
   for up to TRIES values of r about the most whose routes endurance allows.
3. They are routed by min-max from the present positions to the homes (open_routes.py) and flown from the present poses.
4. Accepted is the plan that promises the least mean posterior variance after the whole rest of the flight, if every UAV
   keeps its endurance, no rule is broken, and it promises less than the plan in the air.

With hyperparameters known the posterior variance does not depend on what is measured, and the best plan in flight is
the rest of the best plan at take-off (A. Krause, C. Guestrin, Nonmyopic Active Learning of Gaussian Processes, 2007).
All that re-planning gains, it gains through the hyperparameters, and through what has happened.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from time import process_time

import numpy as np

from formulations.average_variance import AverageVariance
from formulations.kernel import SquaredExponential
from formulations.mapping.flight import Flight
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_model import MapModel, Offered, choose_model
from formulations.polish.path_polish import PolishProblem, polish
from formulations.polish.straight_legs import StraightLegs
from formulations.replanning.aloft import Aloft, World
from formulations.replanning.conditional import ConditionalInformation, Worth, place_remaining
from formulations.replanning.onward import fly_on
from formulations.replanning.open_routes import OpenRoutes, empty_routes, open_routes
from formulations.replanning.refuted import REFUTED, ahead
from formulations.replanning.remaining import RemainingVariance
from formulations.replanning.spending import track_cost
from formulations.replanning.ways import Legs
from formulations.task_location.placement import lattice
from instances.arrays import Floats
from instances.errors import InputError

TRIES = 3
"""Numbers of tasks that are tried, at most."""
SITES = 21
"""Points a side of the lattice from which tasks are chosen greedily."""
LEAST = 10
"""So many tasks are thought of, at least, however few are ahead."""
QUICK = 1000
"""Steps of the search of routes while the number of tasks is sought."""
TURNS = 0.995
"""Share of what endurance leaves that routes of straight legs are to need where turns are flown: they cost 0.3 %."""
LENGTHS = (0.04, 0.75)
"""Length scales are fitted between these shares of the sites' extent: few samples tell of none beyond them."""
CROWDED = 6.0
"""Turning radii between waypoints, at least, where polish splits legs."""
LESS = 1.0 - 1e-9
"""A promise is less where it is below this share."""
SMOOTH = Offered((SquaredExponential,))
"""Planning stays with the squared exponential, whose derivatives it needs."""


@dataclass(frozen=True, eq=False)
class Planner:
    """How re-plans are made.

    model : believed before the first sample; offered : what fits choose from; noise_sd : σ_n of a sample; period [s] :
    between two samples of a UAV; tests : points (m, 2) [m] by which tasks are placed; targets : points (p, 2) [m] at
    which the field is to be known; test_weights, weights : of these, (m,) and (p,), 1 each unless given.
    by_variance : whether tasks are placed by the average variance of the targets, not by information about the tests.
    polish : whether waypoints are moved for what is sensed along the path (`formulations.polish`), too.
    """

    model: MapModel
    noise_sd: float
    period: float
    tests: Floats
    targets: Floats
    test_weights: Floats | None = None
    weights: Floats | None = None
    by_variance: bool = False
    offered: Offered = SMOOTH
    polish: bool = False


@dataclass(frozen=True, eq=False)
class Plan:
    """One way to go on: flights as a whole and from now on, tasks of each UAV, least left of endurance [s], promise.

    lines : the polyline (k, 2) [m] that each UAV in the air is to follow.
    """

    flights: list[Flight]
    rests: list[Flight]
    tasks: list[Floats]
    lines: list[Floats]
    left: float
    promised: float


@dataclass(frozen=True, eq=False)
class Replan:
    """What was decided at `time` [s], why, and what it changed.

    reason : what it was made for. samples : so many were known. model : that it was planned by. before, after : average
    posterior variance promised by the plan in the air and by the best that was tried, NaN where none may be flown.
    tried : number of tasks of each plan and what became of it. accepted, why : whether it is flown now. old, new : the
    rests of the flights. elapsed : processor time it took [s].
    """

    time: float
    reason: str
    samples: int
    model: MapModel
    before: float
    after: float
    tried: list[tuple[int, str]]
    accepted: bool
    why: str
    old: list[Flight] = field(default_factory=list)
    new: list[Flight] = field(default_factory=list)
    elapsed: float = 0.0


class Replanner:
    """Makes one re-plan for the fleet `aloft` in `world`.

    samples : positions (N, 2) [m], values (N,) and times (N,) [s]. model : believed until now.
    """

    def __init__(
        self, planner: Planner, aloft: Aloft, world: World, samples: tuple[Floats, Floats, Floats], model: MapModel
    ) -> None:
        self.began = process_time()
        self.planner, self.aloft, self.world = planner, aloft, world
        self.known, self.values, self.times = samples
        fitted = fit(planner, world, model, samples)
        believed = model is planner.model and ahead(fitted, model, planner.noise_sd, *samples) <= REFUTED
        self.model = model if believed else fitted
        self.uavs = aloft.active
        self.here = np.array([aloft.flown(k).poses(aloft.flown(k).length)[0, :2] for k in self.uavs]).reshape(-1, 2)
        self.spent = np.array([aloft.spent(k, world.measure) for k in self.uavs])
        self.limits = aloft.limits[self.uavs]
        self.tried: list[tuple[int, str]] = []

    def promised(self, flights: Sequence[Flight]) -> float:
        """Return the average posterior variance at the targets after all that `flights` are to measure yet."""
        process = GaussianProcess(self.model, self.planner.noise_sd, self.planner.targets)
        process.extend(self.known, self.values, self.times)
        for flight in flights:
            times, positions = flight.measurements(self.planner.period)
            coming = times > self.aloft.time + 1e-9
            process.extend(positions[coming], np.zeros(coming.sum()), times[coming])
        return float(np.average(process.posterior().sd ** 2, weights=self.planner.weights))

    def best(self, again: Floats | None = None, *, broken: bool = False) -> list[Plan]:
        """Return the plans within endurance, the one that promises least variance first.

        again : tasks of the plan in the air to route anew, before others are placed. broken : it can be flown no more.
        """
        found = []
        if again is not None and len(again):
            found.append(self._plan(again)[0])
        sites, worth, seen = lattice(self.world.sites, SITES), self._worth(), set[int]()
        order = worth.greedy(sites, min(len(sites), max(LEAST, 2 * self.aloft.visits)))
        count = self._fitting(order)
        while len(seen) < TRIES and 0 < count <= len(order) and count not in seen:
            seen.add(count)
            plan, share = self._plan(place_remaining(worth, self.world.sites, order[:count]))
            found.append(plan)
            expected = int(count * share)
            count = min(expected, count - 1) if plan is None else max(expected, count + 1)
        plans = [plan for plan in found if plan is not None]
        begin = plans if broken else [self._aloft(), *plans]
        if self.planner.polish and begin:
            plans += self._polished(min(begin, key=lambda plan: plan.promised))
        return sorted(plans, key=lambda plan: plan.promised)

    def home(self) -> Plan:
        """Return the plan by which all fly straight home, whatever endurance says; InputError where there is no way."""
        legs = self._legs(np.empty((0, 2)))
        found = empty_routes(legs.cost, 0, self.spent, self.limits)
        if not np.isfinite(found.left).all():
            k = self.uavs[int(np.argmin(found.left))]
            raise InputError(f"at {self.aloft.time:g} s there is no way home for UAV {k}")
        return self._flown(legs, np.empty((0, 2)), found)

    def _worth(self) -> Worth:
        landing, planner = max(flight.duration for flight in self.aloft.flights), self.planner
        if planner.by_variance:
            return RemainingVariance(self._judged, landing)
        ages, kernel = (landing - self.times) / self.model.tau, self.model.kernel
        return ConditionalInformation(kernel, planner.tests, self.known, self._reading_sd, ages, planner.test_weights)

    @property
    def _judged(self) -> AverageVariance:
        planner, model = self.planner, self.model
        return AverageVariance(
            model.kernel, self._reading_sd, planner.targets, planner.weights, self.known, model.tau, self.times
        )

    @property
    def _reading_sd(self) -> float:
        return float(np.hypot(self.planner.noise_sd, self.model.nugget_sd))

    def _legs(self, tasks: Floats) -> Legs:
        return self.world.ways.between(np.concatenate([tasks, self.here, self.aloft.homes[self.uavs]]))

    def _fitting(self, order: Floats) -> int:
        """Return how many tasks of `order`, from its first, routes within endurance can hold, by bisection."""
        cost, ends = self._legs(order).cost, len(order) + np.arange(2 * len(self.uavs))
        low, high = 0, len(order) + 1
        while high - low > 1:
            count = (low + high) // 2
            some = np.concatenate([np.arange(count), ends])
            routes = open_routes(cost[np.ix_(some, some)], count, self.spent, self.limits, QUICK)
            low, high = (count, high) if self._fits(routes) else (low, count)
        return low

    def _fits(self, found: OpenRoutes) -> bool:
        """Say whether routes of straight legs leave room for turns within endurance."""
        there, turned = self.limits - self.spent, self.aloft.flights[0].radius > 0
        return bool((there - found.left <= (TURNS if turned else 1.0) * there).all())

    def _plan(self, tasks: Floats) -> tuple[Plan | None, float]:
        """Return the plan by `tasks`, None where endurance is too short; and how many times as many would just fit."""
        legs = self._legs(tasks)
        found = open_routes(legs.cost, len(tasks), self.spent, self.limits)
        plan = self._flown(legs, tasks, found) if found.left.min() >= 0 else None
        left = found.left.min() if plan is None else plan.left
        home = empty_routes(
            legs.cost, len(tasks), self.spent, self.limits
        ).left  # beyond it tours grow with the root of r
        share = float((home / np.maximum(home - found.left, 1e-9)).min().clip(0.0, 2.0) ** 2)
        if plan is None or left < 0:
            self.tried.append((len(tasks), f"needs {-left:.1f} s more than the endurance"))
            return None, share
        self.tried.append((len(tasks), f"promises an sd of {np.sqrt(plan.promised):.4g}"))
        return plan, share

    def _aloft(self) -> Plan:
        """Return the plan in the air as a plan."""
        aloft, rests = self.aloft, [self.aloft.rest(k) for k in range(len(self.aloft.flights))]
        lines = [
            np.concatenate([self.here[i : i + 1], rests[k].starts[1:, :2], aloft.homes[k : k + 1]])
            for i, k in enumerate(self.uavs)
        ]
        return Plan(aloft.flights, rests, aloft.tasks, lines, 0.0, self.promised(aloft.flights))

    def _polished(self, plan: Plan) -> list[Plan]:
        """Return `plan` polished, where that makes it another within endurance."""
        kernel, world, planner = self.model.kernel, self.world, self.planner
        room, first = world.ways.region, self.aloft.flights[0]
        legs = StraightLegs.of(world.measure if world.windy else None, room, world.measure.speed, first.speed)
        budgets = np.maximum(self.limits - self.spent, 0.0)
        flown = self._costs if first.radius > 0 or world.windy else None
        problem = PolishProblem(
            self._judged, legs, planner.period, plan.lines, budgets, room, world.sites, flown, self.aloft.time
        )
        apart = max(0.5 * min(kernel.length_scales), planner.period * first.speed, CROWDED * first.radius)
        done = polish(problem, spacing=apart, warm=True)
        if not done.moved.any():
            return []
        found = self._along([_legs_of(path) for path in done.paths], [path[1:-1] for path in done.paths])
        if found.left < 0:
            return []
        count = sum(len(path) - 2 for path in done.paths)
        self.tried.append((count, f"polished, promises an sd of {np.sqrt(found.promised):.4g}"))
        return [found]

    def _costs(self, uav: int, path: Floats) -> tuple[float, bool]:
        """Return what flying on along `path` costs [s]; whether it may be flown is asked of the whole plan."""
        k, world = self.uavs[uav], self.world
        return track_cost(fly_on(self.aloft.flown(k), _legs_of(path), world.within)[1], world.measure), True

    def _flown(self, legs: Legs, tasks: Floats, found: OpenRoutes) -> Plan:
        """Return the flights along `found`."""
        n, m = len(tasks), len(self.uavs)
        lines = []
        for i, route in enumerate(found.routes):
            stops = (n + i, *route, n + m + i)
            lines.append([legs.path(a, b) for a, b in pairwise(stops)])
        return self._along(lines, [tasks[list(route)] for route in found.routes])

    def _along(self, lines: Sequence[list[Floats]], tasks: Sequence[Floats]) -> Plan:
        """Return the flights along the legs `lines` of each UAV in the air, which pass `tasks`."""
        aloft, world = self.aloft, self.world
        flights, rests = list(aloft.flights), [aloft.rest(k) for k in range(len(aloft.flights))]
        own, left = [np.empty((0, 2)) for _ in flights], []
        for i, k in enumerate(self.uavs):
            flights[k], rests[k] = fly_on(aloft.flown(k), lines[i], world.within, world.clock_wind)
            own[k] = tasks[i]
            left.append(self.limits[i] - self.spent[i] - track_cost(rests[k], world.measure))
        over = [np.concatenate([line[0][:1], *(leg[1:] for leg in line)]) for line in lines]
        return Plan(flights, rests, own, over, min(left), self.promised(flights))


def fit(planner: Planner, world: World, model: MapModel, samples: tuple[Floats, Floats, Floats]) -> MapModel:
    """Return the planning model of greatest restricted likelihood of `samples`, `model` itself where they are too few.

    samples : positions (N, 2) [m], values (N,) and times (N,) [s].
    """
    x0, y0, x1, y1 = world.sites.bounds
    low, high = (share * max(x1 - x0, y1 - y0) for share in LENGTHS)
    return choose_model(model, replace(planner.offered, lengths=(low, high)), planner.noise_sd, *samples).model


def _legs_of(path: Floats) -> list[Floats]:
    """Return the straight legs of `path` (w + 1, 2) [m]."""
    return [path[i : i + 2] for i in range(len(path) - 1)]
