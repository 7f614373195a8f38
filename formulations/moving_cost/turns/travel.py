"""Instances whose legs lead from heading to heading: Dubins lengths over the speed, or of sectors what is below them.

    c[(i, a), (j, b)] = L((P_i, h_a) → (P_j, h_b)) / v

In a steady wind headings are those of the air, v is the airspeed and L the way through the air (`wind`).

With headings the instance is the discretised problem: its routes can be flown in the time that they cost. With sectors
that cover all headings the same legs at interval lengths are a relaxation: its optimum is below that of every choice
of headings (Manyam & Rathinam, arXiv 1506.08752), and reaches it like 1/H in the number H of sectors.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from formulations.moving_cost.turns.headings import HeadingStates, sectors
from formulations.moving_cost.turns.interval import interval_lengths
from formulations.moving_cost.turns.wind import wind_lengths
from instances import Instance, Travel
from instances.arrays import Floats
from instances.environment.wind import Uniform
from instances.errors import InputError
from instances.extent import positive
from instances.metrics import distances
from instances.wind_triangle import zermelo_times

KEY = "turns"
"""Of what an instance's provenance says of its headings."""


@dataclass(frozen=True)
class Turns:
    """How a UAV turns: its least turning radius [m], its speed through the air [m/s] and the steady wind [m/s]."""

    radius: float
    speed: float
    wind: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        positive(self.radius, "radius [m]")
        positive(self.speed, "speed [m/s]")
        if not (strength := math.hypot(*self.wind)) < self.speed:
            raise InputError(
                f"wind: it blows with {strength:.3g} m/s, not less than the airspeed of {self.speed:.3g} m/s: nobody "
                "gets everywhere in it"
            )

    @property
    def drift(self) -> tuple[float, float]:
        """The wind over the airspeed."""
        return self.wind[0] / self.speed, self.wind[1] / self.speed

    @property
    def calm(self) -> bool:
        """Whether there is no wind."""
        return self.wind == (0.0, 0.0)

    def straight_times(self, points: Floats) -> Floats:
        """Return what straight legs between `points` (N, 2) [m] take [s], (N, N): less than any with turns."""
        if self.calm:
            return distances(points) / self.speed
        i, j = np.indices((len(points), len(points))).reshape(2, -1)
        away = points[j] - points[i]
        return zermelo_times(points[i], away, Uniform(self.wind), self.speed).reshape(len(points), -1)

    def lengths(self, points: Floats, states: HeadingStates) -> Floats:
        """Return the lengths [m] through the air of the quickest legs between states at `points` [m], (S, S)."""
        said = np.asarray(points, dtype=float), states.nodes, states.lows, states.widths, self.radius
        return interval_lengths(*said) if self.calm else wind_lengths(*said, *self.drift)


def turning_instance(
    name: str,
    points: Floats,
    n_tasks: int,
    turns: Turns,
    states: HeadingStates,
    *,
    closed: bool = False,
    provenance: Mapping[str, Any] | None = None,
) -> Instance:
    """Return the instance of tasks, then depots at `points` [m], (N, 2), flown over with `states`.

    closed : whether a UAV must land with the heading it took off with. In wind states have one heading or any.
    """
    length = turns.lengths(points, states)
    m = len(points) - n_tasks
    travel = Travel((length / turns.speed)[None, None], np.zeros(m, dtype=np.int64), nodes=states.nodes, closed=closed)
    return Instance.of_travel(
        name, travel, n_tasks, coordinates=points, provenance={**(provenance or {}), **said_of(turns, states)}
    )


def said_of(turns: Turns, states: HeadingStates) -> dict[str, Any]:
    """Return what an instance's provenance says of its turns and headings, for `turns_of`."""
    free = states.widths > 0
    said = {
        "radius": turns.radius,
        "speed": turns.speed,
        "headings": [None if any_ else heading for heading, any_ in zip(states.lows.tolist(), free, strict=True)],
    }
    return {KEY: said | ({} if turns.calm else {"wind": list(turns.wind)})}


def turns_of(instance: Instance) -> tuple[Turns, HeadingStates] | None:
    """Return how the UAVs of an instance turn in calm air and its states' headings; None in wind or where not told.

    It is what relaxations over sectors start from, which know no wind yet.
    """
    known = steady_turns_of(instance)
    return known if known is not None and known[0].calm else None


def steady_turns_of(instance: Instance) -> tuple[Turns, HeadingStates] | None:
    """Return how the UAVs of an instance turn, in which wind, and the headings of its states; None where not told."""
    said = instance.provenance.get(KEY)
    if not isinstance(said, Mapping) or instance.travel is None or instance.coordinates is None:
        return None
    try:
        u, v = said.get("wind", (0.0, 0.0))
        turns = Turns(said["radius"], said["speed"], (float(u), float(v)))
        free = np.array([heading is None for heading in said["headings"]])
        lows = np.array([0.0 if heading is None else float(heading) for heading in said["headings"]])
    except (KeyError, TypeError, ValueError, InputError):
        return None
    if lows.shape != instance.travel.nodes.shape or not np.isfinite(lows).all():
        return None
    return turns, HeadingStates(instance.travel.nodes, lows, np.where(free, 2 * np.pi, 0.0))


def relaxed(instance: Instance, count: int) -> Instance | None:
    """Return the relaxation of an instance over `count` sectors of headings a task, depots free; None as `turns_of`."""
    known = turns_of(instance)
    if known is None or instance.coordinates is None:
        return None
    states = sectors(instance.n_tasks, instance.n_depots, count)
    return turning_instance(instance.name, instance.coordinates, instance.n_tasks, known[0], states)
