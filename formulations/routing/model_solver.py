"""What the solvers share that write a model for an engine: CP-SAT, SCIP, OR-Tools routing.

Engines are given routes to beat: they cut off costs beyond them, scale by them and start from them. Where no routes
are known that the UAVs can fly, they are given a cost that none exceed.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.greedy import Greedy
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.simple_bounds import worst_makespan
from formulations.routing.solver import Result
from instances import Instance
from instances.routes import past_endurance, tour_costs


class ModelSolver(RecordedSolver):
    """A solver that begins from the start given or greedy routes, whichever are shorter.

    counters : the statistics that are 0 where there is nothing to search for.
    """

    counters: ClassVar[tuple[str, ...]] = ()

    def prepare(self, instance: Instance) -> None:
        """Compile the construction of the first routes."""
        Greedy().prepare(instance)

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Improve on the first routes, unless they cost nothing or took all the time."""
        first = Greedy().solve(recorder.instance, limits=Limits(time=max(recorder.remaining, 1e-9)))
        if first.routes is not None:
            recorder.incumbent(first.routes)
        if recorder.objective > 0 and recorder.remaining > 0:
            return self.improve(recorder, seed)
        nothing_done: dict[str, Any] = dict.fromkeys(self.counters, 0)
        if recorder.objective > 0:
            return recorder.result("time", **nothing_done)
        return recorder.result("proof" if self.proves else "finished", proved=self.proves, **nothing_done)

    @abstractmethod
    def improve(self, recorder: Recorder, seed: int) -> Result:
        """Look for better routes than the recorder's, of cost > 0, if any, and for bounds, in the time it has left."""


def cutoff(recorder: Recorder) -> float:
    """Return the cost [s], > 0, of the routes to beat, or `worst_makespan` where there are none."""
    return recorder.objective if recorder.routes is not None else worst_makespan(recorder.instance)


def too_long(instance: Instance, tours: Sequence[Sequence[int]]) -> list[int]:
    """Return the UAVs (0..m−1) whose tour exceeds their endurance; `tours` may leave tasks out."""
    if instance.endurance is None:
        return []
    beyond: list[int] = np.flatnonzero(past_endurance(instance, tour_costs(instance, tours))).tolist()
    return beyond
