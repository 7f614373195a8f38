"""Costs that change with time: c_ij(t) [s] of legs over open country in a wind that changes, at constant airspeed.

Legs are those of `instances.wind_arrivals`: the quickest ways where the wind is the same everywhere, else straight
tracks. `Travel` is linear in the departure between knots, which are set as close as needed:

    ω·Δt ≤ 0.08 rad        where the wind changes at an angular rate ω: whole tours are then off by about 2·10⁻⁴
    halved                 in any wind, until legs halfway between knots are off by at most 2·10⁻³ of their time, or
                           of the mean leg's where that is longer

What it is off by at most, halfway between all knots, is stated in ``provenance["clock"]``. The knots reach half as far
again as the longest of greedy tours in the wind of take-off; after the last one costs stay what they are.

Service s_i is spent half on the way in, half on the way out: c'_ij(t) = s_i/2 + c_ij(t + s_i/2) + s_j/2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from formulations.moving_cost.fleet import classes_of, leg_costs
from formulations.routing.greedy import greedy_routes
from instances import Instance, Travel, makespan
from instances.arrays import Floats
from instances.environment.wind_changing import ChangingWind
from instances.environment.wind_forecast import Forecast
from instances.errors import InputError
from instances.scenario import Scenario
from instances.wind_arrivals import leg_times

MOST_NEEDED = 2000
"""Knots of departure at most, however fast a wind turns."""
ANGLE = 0.08
"""Greatest angle ω·Δt [rad] between knots."""
FIRST = 9
"""Knots to begin with where a wind has no rate."""
MOST = 257
"""Knots beyond which they are not halved any more."""
ERROR = 2e-3
"""Share of a leg's time, or of the mean leg's, that it may be off by."""
REACH = 1.5
"""How far knots reach, in longest tours of greedy."""


class Clock(Protocol):
    """What legs between all nodes of a scenario take, c(g, t, i, j) [s], at any departures."""

    @property
    def scenario(self) -> Scenario:
        """Where it is flown."""
        ...

    def at(self, times: Floats) -> Floats:
        """Return the costs (G, len(times), N, N) [s] of legs begun at `times` (k,) [s]."""
        ...


@dataclass(frozen=True, eq=False)
class LegClock:
    """What legs between all nodes of a scenario take, c(g, t, i, j) [s], at any departures."""

    scenario: Scenario

    def at(self, times: Floats) -> Floats:
        """Return the costs (G, len(times), N, N) [s] of legs begun at `times` (k,) [s]; InputError as `leg_times`."""
        scenario, p = self.scenario, self.scenario.points
        assert isinstance(scenario.wind, ChangingWind)
        n = len(p)
        i, j = np.nonzero(~np.eye(n, dtype=bool))
        service = np.zeros(n)
        service[: scenario.n_tasks] = scenario.fleet.service
        departures = (times[:, None] + 0.5 * service[i]).ravel()
        a, b = np.tile(p[i], (len(times), 1)), np.tile(p[j], (len(times), 1))
        found = np.zeros((len(classes_of(scenario)[0]), len(times), n, n))
        for g, speed in enumerate(classes_of(scenario)[0]):
            raw = np.zeros((len(times), n, n))
            raw[:, i, j] = leg_times(a, b, departures, scenario.wind, speed).reshape(len(times), -1)
            found[g] = [leg_costs(scenario, cost) for cost in raw]
        return found


def clocked_instance(scenario: Scenario) -> Instance:
    """Return the instance whose legs cost what they take in the changing wind of `scenario`, `cost` = "time".

    Raises InputError for a wind as strong as an airspeed and for no-fly zones, which these legs do not go around.
    """
    if scenario.no_fly:
        raise InputError(f"scenario {scenario.name}: no legs around no-fly zones are known in a wind that changes")
    legs = LegClock(scenario)
    assert isinstance(scenario.wind, ChangingWind)
    departures, costs, clock = clock_of(
        legs, reach_of(scenario.wind, longest_at_take_off(legs) + scenario.fleet.window)
    )
    return Instance.of_travel(
        scenario.name,
        Travel(costs, classes_of(scenario)[1], departures, window=scenario.fleet.window),
        scenario.n_tasks,
        coordinates=scenario.points,
        provenance={**scenario.provenance, "clock": clock},
        endurance=scenario.fleet.endurance,
    )


def longest_at_take_off(legs: Clock) -> float:
    """Return the longest of greedy tours [s] in the wind of take-off, or a positive time where all are in one place."""
    scenario = legs.scenario
    travel = Travel(legs.at(np.zeros(1)), classes_of(scenario)[1])
    instance = Instance.of_travel("take-off", travel, scenario.n_tasks)
    return makespan(instance, greedy_routes(instance)) or 1.0


def reach_of(wind: ChangingWind, longest: float) -> float:
    """Return how far knots reach [s] where greedy tours take up to `longest` [s]: to a forecast's end at most."""
    return min(REACH * longest, wind.lasts) if isinstance(wind, Forecast) else REACH * longest


def clock_of(legs: Clock, horizon: float, most: int = MOST) -> tuple[Floats, Floats, dict[str, Any]]:
    """Return knots (Q,) [s] up to `horizon`, costs (G, Q, N, N) [s] at them, and what an instance says of its clock.

    most : knots beyond which they are not halved any more. What is said: knots, step [s]; error [s], halfway between
    knots; lasts [s], how long a forecast does.
    """
    wind = legs.scenario.wind
    rate = getattr(wind, "rate", None)
    count = FIRST if rate is None else 1 + max(1, math.ceil(rate * horizon / ANGLE))
    if count > MOST_NEEDED:
        raise InputError(
            f"the wind turns by {rate:g} rad/s, which asks for {count} knots of departure in {horizon:.0f} s; "
            f"costs can have {MOST_NEEDED}"
        )
    times = np.linspace(0.0, horizon, count)
    costs = legs.at(times)
    while True:
        between = legs.at(0.5 * (times[:-1] + times[1:]))
        off = np.abs(0.5 * (costs[:, :-1] + costs[:, 1:]) - between)
        if 2 * len(times) > most or (off <= ERROR * np.maximum(between, between.mean())).all():
            break
        times = np.linspace(0.0, horizon, 2 * len(times) - 1)
        both = np.empty((len(costs), len(times), *costs.shape[2:]))
        both[:, ::2], both[:, 1::2] = costs, between
        costs = both
    clock = {"knots": len(times), "step": float(times[1]), "error": float(off.max())}
    return times, costs, clock | ({"lasts": wind.lasts} if isinstance(wind, Forecast) else {})
