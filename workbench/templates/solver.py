"""nearest-first: every UAV in turn takes the nearest task that is left. A solver to begin from.

Try it:    workbench generate uniform --tasks 8 --depots 2 --out given
           workbench compare given --solvers {name}:NearestFirst,greedy --time-limit 5 --out runs/{name}
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from formulations.limits import Limits
from formulations.routing.recorder import Recorder
from formulations.routing.solver import Observer, Result, Solver, ignore
from instances import Instance, Routes


@dataclass(frozen=True)
class NearestFirst(Solver):
    """Options are the fields of the class, each with a default that decides its type: `first` is the UAV to begin."""

    proves: ClassVar[bool] = False  # whether it can end OPTIMAL
    first: int = 0

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Return routes; the recorder streams them and computes what they cost."""
        recorder = Recorder(instance, limits, observe, start)
        routes: list[list[int]] = [[] for _ in instance.depots]
        left, uav = set(instance.tasks), self.first % instance.n_depots
        while left and recorder.remaining > 0:
            here = routes[uav][-1] if routes[uav] else instance.n_tasks + uav
            nearest = min(left, key=lambda task: float(instance.cost[here, task]))
            routes[uav].append(nearest)
            left.remove(nearest)
            uav = (uav + 1) % instance.n_depots
        if left:
            return recorder.result("time")
        recorder.incumbent(tuple(map(tuple, routes)))
        return recorder.result("finished")
