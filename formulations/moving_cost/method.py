"""What a moving-cost method is and what it returns: a cost matrix and the paths behind it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind import WindField
from instances.moving_cost import CostKind, CostMeasure
from instances.paths import Paths

if TYPE_CHECKING:
    from formulations.moving_cost.wind_frames import WindFrames

Progress = Callable[[float, str], None]
"""Called now and then with the fraction done (0 to 1) and a few words on what is being done."""


def silent(fraction: float, words: str) -> None:
    """Report no progress."""


@dataclass(frozen=True, eq=False)
class Query:
    """Sub-problem 2 of the paper: paths and costs between every ordered pair of terminals, in a region and a wind.

    Parameters
    ----------
    terminals
        Shape (N, 2) [m], tasks first, then depots.
    region
        Without its no-fly zones.
    wind
        Stationary.
    v0
        The speed that is held constant [m/s]: over ground where the cost is energy, through the air where it is time.
    kind
        Energy or time.
    """

    terminals: Floats
    region: Region
    wind: WindField
    v0: float
    kind: CostKind = CostKind.ENERGY

    @property
    def measure(self) -> CostMeasure:
        """What a path costs."""
        return CostMeasure(self.kind, self.wind, self.v0)


@dataclass(frozen=True, eq=False)
class MovingCosts:
    """What a method found.

    Parameters
    ----------
    cost
        ``cost[i, j]`` [s] of the path from terminal i to terminal j, shape (N, N).
    paths
        The paths themselves [m].
    statistics
        The method's own figures, JSON values only.
    """

    cost: Floats
    paths: Paths
    statistics: Mapping[str, Any] = field(default_factory=dict)


class MovingCostMethod(Protocol):
    """A method for sub-problem 2. Options are the fields of the (dataclass) implementation, each with a default.

    In a wind that changes several objects of one method solve at once, in threads.
    """

    def solve(self, query: Query, progress: Progress = silent) -> MovingCosts:
        """Return costs and paths between all terminals.

        Parameters
        ----------
        query
            What is asked.
        progress
            Is told how far it is.

        Raises
        ------
        InputError
            For a wind at least as strong as the speed that is held constant (for energies, where it is no potential
            wind) and for a terminal that cannot be reached.
        """
        ...


@runtime_checkable
class PlansByClock(Protocol):
    """What a method may have besides: it plans by the clock where the wind changes, at constant airspeed."""

    def by_clock(self, query: Query, wind: WindFrames, moments: Floats, progress: Progress = silent) -> list[Paths]:
        """Return the paths between all terminals for departures at each of `moments` (k,) [s].

        Parameters
        ----------
        query
            What is asked, in the wind of take-off.
        wind
            As it changes.
        moments
            From 0 on, rising.
        progress
            Is told how far it is.

        Raises
        ------
        InputError
            For a terminal that cannot be reached.
        """
        ...
