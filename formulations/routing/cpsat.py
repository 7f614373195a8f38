"""One CP-SAT search: parameters, streaming of solutions and bounds.

Google's CP-SAT through OR-Tools. With one worker a search that ends by itself is deterministic for a seed; with
several, or ended by the clock, it is not (google/or-tools#4195).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

from ortools.sat.python import cp_model

from formulations.routing.recorder import Recorder
from formulations.routing.scaling import ScaledCosts

Values = Callable[[cp_model.IntVar], int]
"""The value of a variable in a solution."""


Ending = Literal["solved", "infeasible", "limit"]
"""How a search ended: the integer model is solved to proof, it has no solution, or neither is known."""


class _Watch(cp_model.CpSolverSolutionCallback):
    """Hands every solution to `on_solution`."""

    def __init__(self, on_solution: Callable[[Values], object]) -> None:
        super().__init__()
        self._on_solution = on_solution

    def on_solution_callback(self) -> None:
        """Called by CP-SAT at every improving solution."""
        self._on_solution(self.value)


def search(
    model: cp_model.CpModel,
    scaled: ScaledCosts,
    recorder: Recorder,
    seed: int,
    on_solution: Callable[[Values], object],
    conflicts: int | None = None,
) -> Ending:
    """Solve `model` in the time the recorder has left, streaming its bounds there and its solutions to `on_solution`.

    Raises RuntimeError where CP-SAT refuses the model or calls one infeasible that holds the incumbent.
    """

    def on_bound(bound: float) -> None:
        recorder.raise_bound(scaled.bound(bound))

    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = max(recorder.remaining, 1e-3)
    solver.parameters.num_workers = recorder.limits.threads
    solver.parameters.random_seed = seed % 2**31
    solver.parameters.presolve_inclusion_work_limit = 0  # google/or-tools#5293
    if conflicts is not None:
        solver.parameters.max_number_of_conflicts = conflicts
    solver.best_bound_callback = on_bound
    status = solver.solve(model, _Watch(on_solution))
    if status == cp_model.INFEASIBLE and recorder.routes is None:
        return "infeasible"
    if status in (cp_model.MODEL_INVALID, cp_model.INFEASIBLE):
        raise RuntimeError(f"CP-SAT ended {solver.status_name(status)} on a model that has a solution")
    bound = solver.best_objective_bound
    if math.isfinite(bound):
        on_bound(bound)
    return "solved" if status == cp_model.OPTIMAL else "limit"
