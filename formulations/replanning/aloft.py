"""Where a fleet is in the middle of its flights, what it has spent, and the rules of the world it flies in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from shapely.geometry import Polygon

from formulations.mapping.flight import Flight
from formulations.replanning.onward import flown_until, rest_after
from formulations.replanning.spending import track_cost
from formulations.replanning.ways import Ways
from instances.arrays import Floats, Ints
from instances.environment.region import Region
from instances.environment.wind import Uniform, WindField
from instances.moving_cost import CostKind, CostMeasure

PASSED = 1.0
"""A task is passed where a track came so near [m]."""

Allowed = Callable[[Sequence[Flight], Sequence[Flight]], str]
"""Says why nobody may fly these flights, given whole and from now on, or ""."""


@dataclass(frozen=True, eq=False)
class World:
    """What holds from now on.

    ways : where legs may lead, and the wind. sites : where tasks may be placed. within : where turns are to stay, or
    None. allowed : the rules of the mission.
    """

    ways: Ways
    sites: Region
    within: Polygon | None
    allowed: Allowed

    @property
    def measure(self) -> CostMeasure:
        """What flying costs."""
        return self.ways.measure

    @property
    def windy(self) -> bool:
        """Whether the air moves."""
        return self.measure.wind != Uniform((0.0, 0.0))

    @property
    def clock_wind(self) -> WindField | None:
        """The wind that the clock of flights runs by; None where ground speed is held."""
        return self.measure.wind if self.measure.kind is CostKind.TIME else None


@dataclass(eq=False)
class Aloft:
    """A fleet in the air at `time` [s].

    flights : of each UAV, as planned to its end. tasks : that each was to pass, (k, 2) [m]. homes : (m, 2) [m].
    limits : endurance (m,) [s]. lost : UAVs that fly no more.
    """

    flights: list[Flight]
    tasks: list[Floats]
    homes: Floats
    limits: Floats
    time: float = 0.0

    def __post_init__(self) -> None:
        self.lost = set[int]()
        self._paid = np.zeros(len(self.flights))  # for what was flown before the wind last changed
        self._paid_for = [flown_until(flight, 0.0) for flight in self.flights]

    @property
    def active(self) -> list[int]:
        """UAVs that are in the air."""
        return [k for k, f in enumerate(self.flights) if k not in self.lost and f.duration > self.time]

    def flown(self, k: int) -> Flight:
        """Return what UAV k has flown."""
        return flown_until(self.flights[k], self.time)

    def rest(self, k: int) -> Flight:
        """Return what UAV k is to fly yet."""
        return rest_after(self.flights[k], self.flown(k))

    def spent(self, k: int, measure: CostMeasure) -> float:
        """Return what UAV k has spent [s], under `measure` since the wind last changed."""
        return float(self._paid[k]) + track_cost(rest_after(self.flown(k), self._paid_for[k]), measure)

    def settle(self, measure: CostMeasure) -> None:
        """Take what is flown as paid for under `measure`, after which another may hold."""
        self._paid = np.array([self.spent(k, measure) for k in range(len(self.flights))])
        self._paid_for = [self.flown(k) for k in range(len(self.flights))]

    def lose(self, k: int) -> None:
        """Let UAV k fly no more."""
        self.flights[k] = self.flown(k)
        self.lost.add(k)

    def ahead(self) -> Floats:
        """Return the tasks that no UAV has passed or that one passes again, (k, 2) [m]; those of lost ones, too."""
        left = [tasks[self._to_pass(k) > 0] for k, tasks in enumerate(self.tasks)]
        return np.concatenate(left) if left else np.empty((0, 2))

    @property
    def visits(self) -> int:
        """How often tasks are to be passed yet, once a lap."""
        return sum(int(self._to_pass(k).sum()) for k in range(len(self.tasks)))

    def _to_pass(self, k: int) -> Ints:
        """Return how often UAV k is to pass each of its tasks yet: at least once where it has not."""
        flown, tasks = self.flown(k), self.tasks[k]
        passed = (
            _passes(tasks, flown, flown.starts[:, :2]) > 0 if flown.length > 0 else np.zeros(len(tasks), dtype=bool)
        )
        rest = self.rest(k)
        again = _passes(tasks, rest, rest.starts[1:, :2]) if k in self.active and rest.length > 0 else 0
        return np.maximum(again, ~passed)


def _passes(tasks: Floats, flight: Flight, begins: Floats) -> Ints:
    """Return how often legs of `flight`, those that begin at `begins`, pass each of `tasks`; tasks are ends of legs."""
    ends = np.concatenate([begins, flight.poses(flight.length)[:, :2]])
    away = np.hypot(*(tasks[:, None] - ends[None]).transpose(2, 0, 1))
    return np.asarray((away <= PASSED).sum(axis=1))
