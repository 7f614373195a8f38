"""What fixed tours take over the members of an ensemble of forecasts.

Routes and paths stay those planned in one forecast; each member is a wind they may meet instead. Of the makespans C
over members it is said: the mean, the greatest, and the conditional value at risk, that of the worst share α of them,

    CVaR_α = 1/α · (Σ of the greatest ⌊αM⌋ + (αM − ⌊αM⌋) · the next).

Members count alike. They are what may happen as far as the ensemble says so; no more is claimed.

Source: R. T. Rockafellar, S. Uryasev, J. Risk 2 (2000) 21–41.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats
from instances.environment.wind import WindField
from instances.environment.wind_forecast import Forecast
from instances.instance import Instance
from instances.paths import Paths
from instances.paths_clocked import tour_by_clock
from instances.routes import Routes, take_offs
from instances.scenario import Scenario
from instances.wind_flights import polyline_times

WORST = 0.2
"""Share α of the members that a conditional value at risk is over."""


@dataclass(frozen=True)
class Spread:
    """Makespans over members [s], in their order, and the one in the forecast that was planned with."""

    planned: float
    members: tuple[float, ...]

    @property
    def least(self) -> float:
        """Least over members [s]."""
        return min(self.members)

    @property
    def mean(self) -> float:
        """Mean over members [s]."""
        return float(np.mean(self.members))

    @property
    def worst(self) -> float:
        """Greatest over members [s]."""
        return max(self.members)

    @property
    def cvar(self) -> float:
        """Mean of the worst share `WORST` of members [s]."""
        return cvar(np.array(self.members), WORST)

    @property
    def words(self) -> str:
        """The spread in words."""
        return (
            f"over {len(self.members)} members of the ensemble the longest tour takes {self.least:.6g} to "
            f"{self.worst:.6g} s, {self.mean:.6g} s on average, {self.cvar:.6g} s over the worst {WORST:.0%}; "
            f"{self.planned:.6g} s in the forecast planned with"
        )

    def to_json(self) -> dict[str, object]:
        """Return the spread as JSON values."""
        return {"planned": self.planned, "members": list(self.members), "mean": self.mean, "worst": self.worst} | {
            "cvar": self.cvar
        }


@dataclass(frozen=True)
class Ensemble:
    """Paths between the nodes of an instance, the forecast they were planned in, and the airspeed [m/s]."""

    paths: Paths
    wind: Forecast
    speed: float

    @classmethod
    def of(cls, paths: Paths | None, scenario: Scenario | None) -> Ensemble | None:
        """Return the ensemble of a scenario and the paths planned in it; None where it has none, or UAVs differ."""
        wind = scenario.wind if scenario is not None and scenario.fleet.alike else None
        if paths is None or scenario is None or not isinstance(wind, Forecast) or not wind.members:
            return None
        return cls(paths, wind, scenario.speed)

    def flown(self, instance: Instance, routes: Routes) -> Spread:
        """Return what the longest tour of `routes` takes over the members; InputError where one is too strong."""
        begins = take_offs(instance, routes)
        over = spread(self.paths, routes, instance.n_tasks, self.wind, self.speed, begins)
        assert over is not None
        return over


def cvar(values: Floats, share: float) -> float:
    """Return the mean of the greatest `share` (above 0, at most 1) of `values`."""
    weight = np.clip(share * len(values) - np.arange(len(values)), 0.0, 1.0)
    return float((np.sort(values)[::-1] * weight).sum() / (share * len(values)))


def spread(
    paths: Paths,
    routes: Routes,
    n_tasks: int,
    wind: WindField | None,
    speed: float,
    begins: Sequence[float] | Floats | None = None,
) -> Spread | None:
    """Return the makespan of `routes`, their legs along `paths` as planned, over the members of `wind`; None for none.

    begins (m,) [s] : take-offs of the UAVs, 0 unless given; makespans count landings. InputError where a member is as
    strong as `speed` [m/s].
    """
    if not isinstance(wind, Forecast) or not wind.members:
        return None
    lines, begun = list[Floats](), list[float]()
    for uav, route in enumerate(routes):
        if route:
            depot = n_tasks + uav
            begun.append(0.0 if begins is None else float(begins[uav]))
            legs, _ = tour_by_clock(paths, (depot, *route, depot), wind, speed, begun[-1])
            lines.append(np.concatenate([legs[0][:1], *(leg[1:] for leg in legs)]))
    offsets = np.concatenate([[0], np.cumsum([len(line) for line in lines])]).astype(np.int64)
    which, at = np.arange(len(lines)), np.array(begun)
    found = [
        float((at + polyline_times(np.concatenate(lines), offsets, which, at, member, speed)).max(initial=0.0))
        for member in (wind, *wind.members)
    ]
    return Spread(found[0], tuple(found[1:]))
