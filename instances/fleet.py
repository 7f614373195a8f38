"""Fleet: what a scenario says of its UAVs, its tasks and the ends of its tours beyond the paper.

A scenario has one depot for each UAV, so that several at one place are several depots there.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from instances import extent
from instances.arrays import Floats
from instances.errors import InputError, shown

MOST_UAVS = 10_000


class Return(StrEnum):
    """Where a tour ends."""

    OWN = "own"
    ANY = "any"
    NONE = "none"


@dataclass(frozen=True, eq=False)
class Fleet:
    """How UAVs differ, how long tasks take, and where tours end; by default as in the paper.

    speeds : (m,) [m/s], or None where all fly at the scenario's.
    endurance : L_k (m,) [s], +inf where unlimited, or None where all are.
    service : s_i (n,) [s] spent at each task, one number for all, or 0.
    returns : where tours end.
    turning_radii : least turning radii (m,) [m], legs being Dubins paths between headings, or None where turns do not
        count.
    window : longest wait before take-off [s], where costs change with time.
    """

    speeds: Floats | None = None
    endurance: Floats | None = None
    service: Floats | float = 0.0
    returns: Return = Return.OWN
    turning_radii: Floats | None = None
    window: float = 0.0

    @property
    def alike(self) -> bool:
        """Whether legs cost all UAVs what their paths do: one speed, no service, no turns, home to the own depot."""
        plain = self.speeds is None and self.turning_radii is None and not np.any(self.service)
        return plain and self.returns is Return.OWN

    def checked(self, n_tasks: int, n_depots: int) -> Fleet:
        """Return the fleet as arrays that fit a scenario of this size; InputError names what does not."""
        speeds, endurance, radii = (
            _numbers(value, label, n_depots, "UAVs", positive=True)
            for value, label in (
                (self.speeds, "speed [m/s]"),
                (self.endurance, "endurance [s]"),
                (self.turning_radii, "turning_radius [m]"),
            )
        )
        for finite, label in ((speeds, "speed [m/s]"), (radii, "turning_radius [m]")):
            if finite is not None and np.isinf(finite).any():
                raise InputError(f"{label} must be finite, got {shown(finite.tolist())}")
        one = isinstance(self.service, (int, float)) and not isinstance(self.service, bool)
        service = _numbers([self.service] if one else self.service, "service [s]", 1 if one else n_tasks, "tasks")
        assert service is not None
        if service.max() > extent.LARGEST:
            raise InputError(f"service [s] must be at most {extent.LARGEST:g}, got {shown(self.service)}")
        if not 0 <= self.window <= extent.LARGEST:
            raise InputError(f"window [s] must be from 0 to {extent.LARGEST:g}, got {shown(self.window)}")
        own = float(service[0]) if one else service
        return Fleet(speeds, endurance, own, Return(self.returns), radii, float(self.window))

    def to_toml(self, n_depots: int) -> dict[str, Any]:
        """Return the keys of a scenario file with one depot for each UAV; none where all is as in the paper."""
        table: dict[str, Any] = {}
        if np.any(self.service):
            table["service"] = self.service if isinstance(self.service, float) else self.service.tolist()
        if self.window:
            table["window"] = self.window
        if self.returns is not Return.OWN:
            table["return"] = str(self.returns)
        if not (self.speeds is None and self.endurance is None and self.turning_radii is None):
            table["uav"] = [{"depot": k} | self._of_uav(k) for k in range(n_depots)]
        return table

    def _of_uav(self, k: int) -> dict[str, float]:
        said = {"speed": self.speeds, "endurance": self.endurance, "turning_radius": self.turning_radii}
        return {key: float(v[k]) for key, v in said.items() if v is not None and np.isfinite(v[k])}


def _numbers(value: Any, label: str, count: int, of: str, *, positive: bool = False) -> Floats | None:
    """Return `count` numbers, each of at least 0 or more than that; None where nothing is said."""
    if value is None:
        return None
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        numbers = np.empty(0)
    if numbers.shape != (count,) or not ((numbers > 0) if positive else (numbers >= 0)).all():
        wanted = "positive" if positive else "at least 0"
        raise InputError(f"{label} must be {count} numbers for the {count} {of}, each {wanted}, got {shown(value)}")
    numbers.setflags(write=False)
    return numbers
