"""What a person would fly otherwise, with the same UAVs, under the same rules.

All fly as many laps as the mission does.

lawnmower: the fewest lanes whose tours are at least as long as the mission's (`formulations.mapping.lawnmower`).
random: uniform random tasks, as many as make the tours at least as long; routed as the mission is.
greedy: as many tasks as the mission has, placed greedily; routed as the mission is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from formulations.kernel import SquaredExponential
from formulations.mapping.flight import Flight
from formulations.mapping.flight_check import RESOLUTION, margin
from formulations.mapping.heights import Altitude, heights_of
from formulations.mapping.lawnmower import best_lawnmower
from formulations.mapping.map_grid import MapGrid
from formulations.mapping.survey import promised_sd
from instances.arrays import Floats
from instances.environment.terrain import Terrain
from instances.extent import LEAST
from instances.scenario import Scenario
from workbench.jobs.machine import available_cores
from workbench.mission.belief import known_tau, map_kernel
from workbench.mission.costs import moving_costs
from workbench.mission.flight import fly, in_wind
from workbench.mission.place import kept_off, place_tasks, widened, zones_of
from workbench.mission.routes import solve
from workbench.mission.safety import room_to_fly
from workbench.mission.settings import Mission

MOST_TRIES = 3
"""Numbers of random tasks that are tried until the tours are long enough."""
MORE_TASKS = 1.75
"""So many times as many random tasks as placed ones make about equally long tours."""
AIM = 1.04
"""Tours aimed at so many times the wanted length seldom have to be drawn again for being too short."""


@dataclass(frozen=True, eq=False)
class Plan:
    """One way to fly: its name, how many tasks (or lanes) it has, the flights, and why nobody may fly it, or ""."""

    name: str
    count: int
    flights: list[Flight]
    refused: str = ""

    @property
    def length(self) -> float:
        """Flown length of all UAVs [m]."""
        return sum(flight.length for flight in self.flights)


Coming = Callable[[], list[Flight]]
"""Flights whose routes are being sought."""


class Baselines:
    """Makes the baselines of a mission whose own tours are `length` [m] long with all laps, routes beside one another.

    laps : how often each baseline flies its tours.
    """

    def __init__(
        self, mission: Mission, scenario: Scenario, ground: Terrain | None, length: float, laps: int = 1
    ) -> None:
        self.mission, self.scenario, self.ground, self.length, self.laps = mission, scenario, ground, length, laps
        self.region = widened(scenario, mission.clearance).free
        self.inner = kept_off(self.region, scenario.region, mission.clearance) or self.region

    def made(self) -> Iterator[list[Plan]]:
        """Yield the plans of each baseline asked for, in order; several where it is drawn."""
        makers = {"lawnmower": self.lawnmower, "random": self.random, "greedy": self.greedy}
        for name in self.mission.compare.baselines:
            yield makers[name]()

    def _plan(self, name: str, count: int, flights: list[Flight]) -> Plan:
        return Plan(name, count, flights, unflyable(self.mission, self.scenario, self.ground, flights))

    def lawnmower(self) -> list[Plan]:
        """Return the lawnmower that promises least uncertainty before take-off, of those that may be flown if any."""
        mission, scenario = self.mission, self.scenario
        promised = partial(
            promised_sd,
            points=MapGrid.over(scenario.region, 40).points,
            kernel=map_kernel(mission, SquaredExponential),
            noise_sd=mission.sensing.noise_sd,
            period=mission.sensing.period,
            tau=known_tau(mission),
        )

        def flown(flights: list[Flight]) -> list[Flight]:
            return [in_wind(flight, scenario).repeated(self.laps) for flight in flights]

        def worth(flights: list[Flight]) -> tuple[bool, float]:
            return bool(unflyable(mission, scenario, self.ground, flights)), promised(flown(flights))

        lanes, flights = best_lawnmower(
            scenario.free,
            scenario.depots,
            self.length / self.laps,
            worth,
            speed=mission.speed,
            radius=mission.flight.turning_radius,
        )
        return [self._plan("lawnmower", lanes, flown(flights))]

    def greedy(self) -> list[Plan]:
        """Return tasks placed greedily, with room for turns as the mission's have."""
        mission, count = self.mission, self.scenario.n_tasks
        points = place_tasks(mission, self.region, count, "greedy", {}).points
        if not self.inner.contains(points).all():
            points = place_tasks(mission, self.region, count, "greedy", {}, within=self.inner).points
        with ThreadPoolExecutor(1) as pool:
            return [self._plan("greedy", count, self.routed(pool, points)())]

    def random(self) -> list[Plan]:
        """Return draws of random tasks, each routed, so many that the tours are as long as the mission's."""
        with ThreadPoolExecutor(available_cores()) as pool:
            return [self._plan("random", plan.count, plan.flights) for plan in self._draws(pool)]

    def _draws(self, pool: Executor) -> list[Plan]:
        first = self._long_enough(pool, 0, math.ceil(MORE_TASKS * self.scenario.n_tasks))
        count = self._more(first.count, first.length)
        wanted = self.mission.compare
        others = range(1, min(wanted.draws, wanted.seeds))
        coming = [self.routed(pool, self._drawn(draw, count)) for draw in others]
        plans = [first]
        for draw, flights in zip(others, coming, strict=True):
            plan = Plan("random", count, flights())
            if plan.length < self.length:
                plan = self._long_enough(pool, draw, self._more(count, plan.length))
            plans.append(plan)
        return plans

    def _long_enough(self, pool: Executor, draw: int, count: int) -> Plan:
        """Return random tasks, `count` or, where the tours turn out too short, more."""
        for _ in range(MOST_TRIES):
            plan = Plan("random", count, self.routed(pool, self._drawn(draw, count))())
            if plan.length >= self.length:
                break
            count = self._more(count, plan.length)
        return plan

    def _more(self, count: int, length: float) -> int:
        """Return how many tasks make tours of the length aimed at, where `count` make `length` [m]."""
        return math.ceil(count * (AIM * self.length / length) ** 2)  # tours grow with the root of the count

    def _drawn(self, draw: int, count: int) -> Floats:
        return self.inner.sample(count, np.random.default_rng([self.mission.compare.seed, draw]))

    def routed(self, pool: Executor, points: Floats) -> Coming:
        """Return what waits for the flights to `points`, by the mission's own moving costs and solver."""
        mission, wanted = self.mission, self.mission.compare
        instance, paths = moving_costs(mission, self.scenario, points)
        solving = pool.submit(solve, mission, instance, wanted.time_limit, wanted.seed)

        def flights() -> list[Flight]:
            routes = solving.result().own["routes"]
            assert routes is not None
            room = room_to_fly(mission, self.scenario)
            flown = fly(mission, self.scenario, instance, paths, routes, room).flights
            return [flight.repeated(self.laps) for flight in flown]

        return flights


def unflyable(mission: Mission, scenario: Scenario, ground: Terrain | None, flights: list[Flight]) -> str:
    """Return why nobody may fly `flights`, by the rules that the mission's own are refused by; "" where they may be."""
    for uav, flight in enumerate(flights):
        if flight.length == 0.0:
            continue
        why = beyond(mission, scenario, flight) or too_low(mission, mission.altitude, ground, flight)
        if why:
            return f"UAV {uav} would {why}"
    return ""


def beyond(mission: Mission, scenario: Scenario, flight: Flight) -> str:
    """Return how `flight` (not of length 0) comes too near to the region's border or to no-fly zones, or ""."""
    room, wanted = margin(flight, scenario.region, zones_of(scenario)).distance, mission.flight.border_clearance
    if room >= wanted - RESOLUTION:
        return ""
    if room < 0.0:
        return f"be up to {-room:.1f} m outside the region or in a no-fly zone"
    return f"come within {room:.1f} m of the region's border or a no-fly zone"


def too_low(mission: Mission, altitude: Altitude, ground: Terrain | None, flight: Flight) -> str:
    """Return how `flight` (not of length 0), from its depot on, comes too near to the ground, or ""."""
    above = heights_of(flight, altitude, ground).clearance
    return f"come within {above:.1f} m of the ground" if above < mission.flight.clearance - LEAST else ""
