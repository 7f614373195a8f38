"""Paths by departure: moving costs c_ij(t) [s] around walls in a wind that changes, at constant airspeed.

1. A method of moving costs plans all paths in the wind of take-off as if it stayed.
2. The same for `PLANS` moments in all, spread over the time that tours may take, each from scratch: begun with the
   paths of the moment before, `refined` took 1.6 times as long (50 tasks, drifting vortices) and stayed on the old
   sides of obstacles, up to 3.5 % dearer.
3. A method that plans by the clock (`method.PlansByClock`) adds a plan for departures at each of these moments, made
   in the wind as it changes: a tree of earliest arrivals for each node and moment.
4. For each knot of departure the plans for the moment before it and the two after it, for a leg lasts, are flown from
   then on in the wind as it changes (`instances.wind_flights`), and the quickest counts. Plans by the clock make no leg
   later, since the others are flown as well; among drifting vortices they make many quicker. No path is claimed to be
   the best.
5. What a later departure would gain, c(t) > c(t + d) + d, is closed: c(t) ← min(c(t), c(t + d) + d), which `Travel`
   asks for. All plans together are "first in, first out" (`instances.paths_clocked`), so this promises nothing that
   they do not keep.

Knots, their error and how far they reach are those of `clocked`. A forecast's last frame is held, so after it costs
are those of a wind that stays.
"""

from __future__ import annotations

import dataclasses
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from formulations.moving_cost.clocked import clock_of, longest_at_take_off, reach_of
from formulations.moving_cost.costing import all_pairs, distinct, query_in
from formulations.moving_cost.effect import wind_effect
from formulations.moving_cost.fleet import classes_of, leg_costs
from formulations.moving_cost.method import MovingCostMethod, PlansByClock, Progress, silent
from formulations.moving_cost.registry import DEFAULT, make_method
from formulations.moving_cost.wind_frames import wind_frames
from instances import Instance, Travel
from instances.arrays import Floats, Ints
from instances.environment.wind_changing import ChangingWind
from instances.paths import Paths
from instances.paths_clocked import beside
from instances.scenario import Scenario
from instances.wind_flights import polyline_times

PLANS = 8
"""Moments for whose winds paths are planned."""
BESIDE = 3
"""Moments whose plans are flown at a knot. With two, and plans for winds that stay alone, eight nodes among drifting
vortices were off by 0.52 s on average and by 169 s at most between 33 knots, with three by 0.21 s and 38 s."""
KNOTS = 65
"""Knots of departure beyond which they are not halved any more."""
THREADS = 2
"""Plans made, or parts of the flights flown, at once: most of their time they are in kernels or in numpy. Each plan
holds its own memory."""
AT_ONCE = 1 << 16
"""Flights that are flown by one call, about."""
PRECISION = 1e-4
"""Of paths by `refined`, unless it is told: far below what costs are off by between knots."""


@dataclass(frozen=True, eq=False)
class PathClock:
    """What legs take along planned paths, c(g, t, i, j) [s], at any departures.

    paths : of each class, with later ones.
    """

    scenario: Scenario
    paths: list[Paths]

    def at(self, times: Floats) -> Floats:
        """Return the costs (G, len(times), N, N) [s] of legs begun at `times` (k,) [s]; raises as `polyline_times`."""
        scenario, n = self.scenario, len(self.scenario.points)
        assert isinstance(scenario.wind, ChangingWind)
        half = np.zeros(n)
        half[: scenario.n_tasks] = 0.5 * np.asarray(scenario.fleet.service)
        speeds, _ = classes_of(scenario)
        found = np.zeros((len(speeds), len(times), n, n))
        for g, speed in enumerate(speeds):
            plan, knot = np.nonzero(beside(self.paths[g], times, BESIDE))
            took = _flown(self.paths[g], plan, times[knot, None] + half, scenario.wind, speed)
            quickest = np.full((len(times), n * n), np.inf)
            for q, each in zip(knot, took, strict=True):
                np.minimum(quickest[q], each, out=quickest[q])
            found[g] = [leg_costs(scenario, each.reshape(n, n)) for each in quickest]
        return found


def _flown(paths: Paths, plan: Ints, begun: Floats, wind: ChangingWind, airspeed: float) -> Floats:
    """Return the times (k, n²) [s] of all paths of each `plan` (k,), begun at `begun` (k, n) [s] where they lead from.

    plan : rising numbers of these paths and their later ones. As many at once as is good: few are as dear as many.
    """
    plans, each = (paths, *paths.later), np.arange(paths.n_nodes**2)

    def part(rows: Ints) -> Floats:
        first, last = plan[rows[0]], plan[rows[-1]]
        some = plans[first : last + 1]
        ends = np.cumsum([0, *(one.offsets[-1] for one in some)])
        offsets = np.concatenate([[0], *(one.offsets[1:] + end for one, end in zip(some, ends, strict=False))])
        which = ((plan[rows] - first)[:, None] * len(each) + each).ravel()
        points, then = np.concatenate([one.points for one in some]), np.repeat(begun[rows], paths.n_nodes, axis=1)
        return polyline_times(points, offsets, which, then.ravel(), wind, airspeed).reshape(-1, len(each))

    count = min(len(plan), max(THREADS, math.ceil(len(plan) * len(each) / AT_ONCE)))
    with ThreadPoolExecutor(THREADS) as pool:
        return np.concatenate(list(pool.map(part, np.array_split(np.arange(len(plan)), count))))


def instance_by_clock(
    scenario: Scenario, method: str = DEFAULT, options: dict[str, Any] | None = None, progress: Progress = silent
) -> tuple[Instance, Paths]:
    """Return the Instance whose legs cost what they take in the changing wind of `scenario`, and the paths.

    Raises InputError as `costing.instance_of`.
    """
    assert isinstance(scenario.wind, ChangingWind)
    asked = {"precision": PRECISION, **(options or {})} if method == "refined" else options
    speeds, classes = classes_of(scenario)

    def planned(moment: float) -> list[Paths]:
        return [_planned(scenario, make_method(method, asked), speed, moment) for speed in speeds]

    first, rest = planned(0.0), list[list[Paths]]()
    progress(1 / (PLANS + 2), "planned for the wind of take-off")
    horizon = reach_of(scenario.wind, longest_at_take_off(PathClock(scenario, first)) + scenario.fleet.window)
    moments = np.linspace(0.0, horizon, PLANS)
    with ThreadPoolExecutor(THREADS) as pool:
        for moment, new in zip(moments[1:], pool.map(planned, moments[1:].tolist()), strict=True):
            rest.append(new)
            progress((1 + len(rest)) / (PLANS + 2), f"planned for the wind {moment:.0f} s later")
    paths = []
    for g, speed in enumerate(speeds):
        by_clock = _planned_by_clock(scenario, make_method(method, asked), speed, moments)
        planned_for = [*moments[1:].tolist(), *moments[: len(by_clock)].tolist()]
        later = (*(each[g] for each in rest), *by_clock)
        paths.append(dataclasses.replace(first[g], later=later, departures=tuple(planned_for)))
    progress((PLANS + 1) / (PLANS + 2), "planned by the clock")
    departures, costs, clock = clock_of(PathClock(scenario, paths), horizon, KNOTS)
    instance = Instance.of_travel(
        scenario.name,
        Travel(_closed(costs, departures), classes, departures, window=scenario.fleet.window),
        scenario.n_tasks,
        coordinates=scenario.points,
        provenance=_provenance(scenario, first[0], method, options) | {"clock": clock | {"plans": PLANS}},
        endurance=scenario.fleet.endurance,
    )
    return instance, dataclasses.replace(paths[0], others=tuple(paths[1:]))


def _planned(scenario: Scenario, planner: MovingCostMethod, speed: float, time: float) -> Paths:
    """Return the paths between all nodes in the wind of `time` [s], as if it stayed."""
    assert isinstance(scenario.wind, ChangingWind)
    query = dataclasses.replace(query_in(scenario, scenario.wind.at(time)), v0=speed)
    return all_pairs(query, planner).paths


def _planned_by_clock(scenario: Scenario, planner: MovingCostMethod, speed: float, moments: Floats) -> list[Paths]:
    """Return the paths for departures at `moments` (k,) [s] in the wind as it changes; none by a method that cannot."""
    assert isinstance(scenario.wind, ChangingWind)
    query = dataclasses.replace(query_in(scenario, scenario.wind.at(0.0)), v0=speed)
    places, of = distinct(query)
    if not isinstance(planner, PlansByClock) or len(places.terminals) == 1:
        return []
    x0, y0, x1, y1 = query.region.bounds
    across = float(np.hypot(x1 - x0, y1 - y0)) / speed
    wind = wind_frames(scenario.wind, query.region, speed, float(moments[-1]) + across)
    return [each.repeated(of, query.terminals) for each in planner.by_clock(places, wind, moments)]


def _closed(costs: Floats, departures: Floats) -> Floats:
    """Return `costs` (G, Q, N, N) [s] that no later departure undercuts."""
    closed = costs.copy()
    for q in range(len(departures) - 2, -1, -1):
        waited = closed[:, q + 1] + (departures[q + 1] - departures[q])
        closed[:, q] = np.minimum(closed[:, q], waited)
    return closed


def _provenance(scenario: Scenario, paths: Paths, method: str, options: dict[str, Any] | None) -> dict[str, Any]:
    """Return where the costs come from; the wind's effect is that of take-off's."""
    assert isinstance(scenario.wind, ChangingWind)
    query = query_in(scenario, scenario.wind.at(0.0))
    cost = query.measure.polylines(paths.points, paths.offsets).reshape(len(scenario.points), -1)
    made = {"method": method, **(options or {}), "cost": str(query.kind)}
    effect = dataclasses.asdict(wind_effect(query, cost))
    return {**scenario.provenance, "moving_cost": made, "wind_effect": effect}
