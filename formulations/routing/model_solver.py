"""What the solvers share that write a model for an engine: CP-SAT, SCIP, OR-Tools routing.

Engines are given routes to beat: they cut off costs beyond them, scale by them and start from them.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.greedy import greedy_routes
from formulations.routing.recorder import Recorder
from formulations.routing.solver import Observer, Result, Solver, ignore
from instances import Instance, Routes


class ModelSolver(Solver):
    """A solver that begins from the start given or greedy routes, whichever are shorter.

    counters : the statistics that are 0 where there is nothing to search for.
    """

    counters: ClassVar[tuple[str, ...]] = ()

    def prepare(self, instance: Instance) -> None:
        """Compile the construction of the first routes."""
        greedy_routes(Instance("warm-up", np.zeros((2, 2)), 1, 1))

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Search, unless the first routes cost nothing."""
        recorder = Recorder(instance, limits, observe, start)
        recorder.incumbent(greedy_routes(instance))
        if recorder.objective > 0:
            return self.search(recorder, seed)
        nothing_done: dict[str, Any] = dict.fromkeys(self.counters, 0)
        return recorder.result("proof" if self.proves else "finished", proved=self.proves, **nothing_done)

    @abstractmethod
    def search(self, recorder: Recorder, seed: int) -> Result:
        """Look for better routes than the recorder's, of cost > 0, and for bounds, in the time it has left."""
