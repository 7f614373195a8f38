"""What an extra UAV or battery is worth: the changes to a fleet that are tried, and what their results tell.

The gain is how much shorter the longest tour becomes. With optima z and z' before and after, and of each the objective
and a bound, it is at least bound − objective' and at most objective − bound'; where both are proved it is exact. No
change makes routes longer, so it is at least 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from formulations.routing.fewest_uavs import of_uavs
from formulations.routing.symmetries import shared_depots
from instances import Instance, Routes

BATTERIES = 2
"""Batteries of the UAV that gets one more: its endurance is multiplied by this."""


@dataclass(frozen=True, eq=False)
class Change:
    """A change to the fleet: in words, to which UAV (0..m−1), and the instance with it."""

    words: str
    uav: int
    instance: Instance

    def start(self, routes: Routes) -> Routes:
        """Return routes of the fleet as it was as routes of this one."""
        return (*routes, *[()] * (self.instance.n_depots - len(routes)))


def changes(instance: Instance) -> Iterator[Change]:
    """Yield a UAV more at each depot and a battery more, each once for UAVs that can be exchanged."""
    everyone = tuple(range(instance.n_depots))
    first = [group[0] - instance.n_tasks for group in shared_depots(instance)]
    for k in first:
        yield Change(f"one more UAV like UAV {k}", k, of_uavs(instance, (*everyone, k)))
    for k in first:
        if math.isfinite(instance.limits[k]):
            limits = instance.limits.copy()
            limits[k] *= BATTERIES
            yield Change(f"one more battery for UAV {k}", k, replace(instance, endurance=limits))


def gain(
    before: tuple[float | None, float | None], after: tuple[float | None, float | None]
) -> tuple[float, float | None]:
    """Return the least and the greatest that the gain can be [s], None where that is not known.

    before, after : objective and bound [s] of the fleet as it was and with the change; None where unknown.
    """
    (objective, bound), (objective_after, bound_after) = before, after
    least = 0.0 if bound is None or objective_after is None else max(0.0, bound - objective_after)
    return least, None if objective is None else objective - (bound_after or 0.0)
