"""`l-bfgs-b`: the bound-constrained quasi-Newton method of Byrd, Lu, Nocedal & Zhu (1995) from several starts.

It knows only the bounding box: outside a non-rectangular region the points are snapped to it at the end of a start.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import Bounds, minimize

from formulations.task_location.derivatives import Expansion
from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.starts import starts
from instances.arrays import Floats


@dataclass(frozen=True)
class LBfgsB(PlacementMethod):
    """L-BFGS-B with the closed-form gradient.

    starts : number of starts, ≥ 1: the greedy choice after exchanges, then random ones.
    iterations : at most so many a start.
    """

    starts: int = 8
    iterations: int = 500
    status: ClassVar[PlacementStatus] = PlacementStatus.LOCALLY_SOLVED

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the snapped end of every start."""
        scales = problem.criterion.scales
        x0, y0, x1, y1 = problem.region.bounds
        box = Bounds(
            np.tile(np.array([x0, y0]) / scales, problem.n_tasks), np.tile(np.array([x1, y1]) / scales, problem.n_tasks)
        )
        status = PlacementStatus.HEURISTIC

        def negative(z: Floats) -> tuple[float, Floats]:
            progress.check()
            here = Expansion(problem.criterion, z.reshape(-1, 2) * scales)
            return -here.value, -(here.gradient * scales).ravel()

        for begin in starts(problem, self.starts, seed):
            done = minimize(
                negative,
                (begin / scales).ravel(),
                jac=True,
                method="L-BFGS-B",
                bounds=box,
                options={"maxiter": self.iterations, "maxcor": 20},
            )
            points = done.x.reshape(-1, 2) * scales
            snapped = problem.region.snap(points)
            if progress.offer(snapped, problem.criterion.value(snapped)):
                stationary = done.success and np.array_equal(points, snapped)
                status = PlacementStatus.LOCALLY_SOLVED if stationary else PlacementStatus.HEURISTIC
        return status
