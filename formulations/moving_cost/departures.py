"""Paths by departure: moving costs c_ij(t) [s] around walls in a wind that changes, at constant airspeed.

1. A method of moving costs plans all paths in the wind of take-off as if it stayed.
2. The same for `PLANS` moments in all, spread over the time that tours may take, each from scratch: begun with the
   paths of the moment before, `refined` took 1.6 times as long (50 tasks, drifting vortices) and stayed on the old
   sides of obstacles, up to 3.5 % dearer.
3. For each knot of departure the plan before it and the two after it, for a leg lasts, are flown from then on in the
   wind as it changes (`instances.wind_flights`), and the quickest counts. No path is claimed to be the best by the
   clock: one planned for a wind that stays is, where the wind changes, only a good one.
4. What a later departure would gain, c(t) > c(t + d) + d, is closed: c(t) ← min(c(t), c(t + d) + d), which `Travel`
   asks for. All plans together are "first in, first out" (`instances.paths_clocked`), so this promises nothing that
   they do not keep.

Knots, their error and how far they reach are those of `clocked`. A forecast's last frame is held, so after it costs
are those of a wind that stays.
"""

from __future__ import annotations

import dataclasses
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from formulations.moving_cost.clocked import clock_of, longest_at_take_off, reach_of
from formulations.moving_cost.costing import all_pairs, query_in
from formulations.moving_cost.effect import wind_effect
from formulations.moving_cost.fleet import classes_of, leg_costs
from formulations.moving_cost.method import MovingCostMethod, Progress, silent
from formulations.moving_cost.registry import DEFAULT, make_method
from instances import Instance, Travel
from instances.arrays import Floats
from instances.environment.wind_changing import ChangingWind
from instances.paths import Paths
from instances.scenario import Scenario
from instances.wind_flights import polyline_times

PLANS = 8
"""Moments for whose winds paths are planned."""
BESIDE = 3
"""Plans that are flown at a knot. With two, eight nodes among drifting vortices were off by 0.52 s on average and by
169 s at most between 33 knots, with three by 0.21 s and 38 s."""
KNOTS = 65
"""Knots of departure beyond which they are not halved any more."""
THREADS = 2
"""Plans made at once: `refined` is in a kernel or in numpy for most of its time, and each plan holds its own memory."""
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
            planned_for = np.array([0.0, *self.paths[g].departures])
            before = np.searchsorted(planned_for, times, side="right") - 1
            quickest = np.full((len(times), n * n), np.inf)
            for number, plan in enumerate((self.paths[g], *self.paths[g].later)):
                knots = np.flatnonzero((before <= number) & (number < before + BESIDE))
                begun = np.repeat(times[knots, None] + half, n, axis=1)
                quickest[knots] = np.minimum(quickest[knots], _flown(plan, begun, scenario.wind, speed))
            found[g] = [leg_costs(scenario, each.reshape(n, n)) for each in quickest]
        return found


def _flown(paths: Paths, begun: Floats, wind: ChangingWind, airspeed: float) -> Floats:
    """Return the times [s] of all paths begun at `begun` (k, n²) [s], all at once: few flights are as dear as many."""
    which = np.tile(np.arange(paths.n_nodes**2), len(begun))
    return polyline_times(paths.points, paths.offsets, which, begun.ravel(), wind, airspeed).reshape(begun.shape)


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

    paths = first = planned(0.0)
    progress(1 / (PLANS + 1), "planned for the wind of take-off")
    horizon = reach_of(scenario.wind, longest_at_take_off(PathClock(scenario, first)) + scenario.fleet.window)
    moments = np.linspace(0.0, horizon, PLANS)[1:].tolist()
    with ThreadPoolExecutor(THREADS) as pool:
        for done, (moment, new) in enumerate(zip(moments, pool.map(planned, moments), strict=True), 2):
            paths = [
                dataclasses.replace(each, later=(*each.later, plan), departures=(*each.departures, moment))
                for each, plan in zip(paths, new, strict=True)
            ]
            progress(done / (PLANS + 1), f"planned for the wind {moment:.0f} s later")
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
