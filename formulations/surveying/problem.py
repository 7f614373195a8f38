"""The nouns of a survey: SurveyProblem, the Sensor, Tours, the SurveyPlanner protocol.

Each UAV k flies a closed polyline from its depot at constant speed over ground and measures every `spacing` metres of
it, the first time one spacing after take-off. No polyline may cost more than `length`, and none may leave the region.
In calm air a polyline costs its length; in a wind v0 C, where C is the paper's energy (`instances.moving_cost`): the
metres of calm air that would cost as much.
What is wanted is the map of least root mean square error; the field is known to the sensor alone.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from formulations.kernel import SquaredExponential
from formulations.limits import Limits
from formulations.mapping.map_grid import MapGrid
from instances.arrays import Floats
from instances.environment.region import Region
from instances.moving_cost import CostMeasure

TARGETS = 40
"""Cells along the region's longer side whose centres are where a plan is to make the field known."""


@dataclass(frozen=True, eq=False)
class SurveyProblem:
    """What is known before take-off.

    region; depots, shape (m, 2) [m], one UAV at each; length : most that a UAV's polyline may cost [m]; spacing :
    between two readings of a UAV [m]; kernel : what is believed of the field; noise_sd : σ_n of a reading, in the
    field's unit; measure : of energies in the wind, None in calm air.
    """

    region: Region
    depots: Floats
    length: float
    spacing: float
    kernel: SquaredExponential
    noise_sd: float
    measure: CostMeasure | None = None

    def costs(self, a: Floats, b: Floats) -> Floats:
        """Return what the straight legs `a` → `b` (k, 2) [m] cost [m], shape (k,)."""
        if self.measure is None:
            return np.asarray(np.hypot(*(b - a).T))
        return self.measure.speed * self.measure.segments(a, b)

    def cost_of(self, polyline: Floats) -> float:
        """Return what flying `polyline` (k, 2) [m] costs [m]."""
        return float(self.costs(polyline[:-1], polyline[1:]).sum()) if len(polyline) > 1 else 0.0

    @cached_property
    def is_convex(self) -> bool:
        """Whether every straight leg between places in the region stays inside."""
        polygon = self.region.polygon
        return bool(polygon.convex_hull.area - polygon.area <= 1e-9 * polygon.area)

    @cached_property
    def targets(self) -> Floats:
        """Where the field is to be known, shape (p, 2) [m]."""
        return MapGrid.over(self.region, TARGETS).points


Tours = Sequence[Floats]
"""For each depot, in their order, a closed polyline (k, 2) [m] from the depot and back; (0, 2) for who stays home."""


def travelled(polyline: ArrayLike) -> Floats:
    """Return how far [m] along `polyline` (k, 2) each vertex lies, shape (k,)."""
    p = np.asarray(polyline, dtype=float).reshape(-1, 2)
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(p, axis=0).T))]) if len(p) else np.empty(0)


def length_of(polyline: ArrayLike) -> float:
    """Return the length [m] of `polyline` (k, 2), 0 for none."""
    return float(travelled(polyline).max(initial=0.0))


def readings(polyline: ArrayLike, spacing: float) -> Floats:
    """Return where a UAV that flies `polyline` (k, 2) measures: every `spacing` [m], shape (n, 2) [m]."""
    p, s = np.asarray(polyline, dtype=float).reshape(-1, 2), travelled(polyline)
    at = spacing * np.arange(1, int(s.max(initial=0.0) / spacing + 1e-9) + 1)
    return np.column_stack([np.interp(at, s, p[:, axis]) for axis in (0, 1)]) if len(at) else np.empty((0, 2))


def noise(noise_sd: float, seed: int, uav: int, ticks: Sequence[int] | range) -> Floats:
    """Return the noise of a UAV's readings numbered `ticks` from 1: the same for the same seed, whoever measures."""
    draws = [np.random.default_rng([seed, uav, tick]).standard_normal() for tick in ticks]
    return noise_sd * np.array(draws)


@dataclass
class Sensor:
    """What measures the field during the flight, and remembers where it did.

    truth : the field's values at points (k, 2) [m], shape (k,).
    log : UAV, number of the reading from 1, x and y [m] of each.
    """

    truth: Callable[[Floats], Floats]
    noise_sd: float
    seed: int
    log: list[tuple[int, int, float, float]] = field(default_factory=list)

    def read(self, uav: int, first: int, positions: ArrayLike) -> Floats:
        """Return the readings `first`, `first` + 1, … of `uav`, at `positions` (k, 2) [m], shape (k,)."""
        p = np.asarray(positions, dtype=float).reshape(-1, 2)
        ticks = range(first, first + len(p))
        self.log += [(uav, tick, float(x), float(y)) for tick, (x, y) in zip(ticks, p, strict=True)]
        return self.truth(p) + noise(self.noise_sd, self.seed, uav, ticks)


class SurveyPlanner(ABC):
    """A way to fly. Options are the fields of the (dataclass) implementation, each with a default."""

    def accepts(self, problem: SurveyProblem) -> str | None:
        """Return why it does not plan `problem`, in a sentence, or None where it does."""
        return None

    def prepare(self, problem: SurveyProblem) -> None:
        """Do what is not part of the planning: imports, compilation. Not timed."""
        return None

    @abstractmethod
    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Return the tours flown. A plan that changes in flight reads `sensor` where it has flown, in order."""
