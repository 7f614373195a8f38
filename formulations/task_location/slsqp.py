"""`slsqp`: sequential least-squares quadratic programming (Kraft 1988) with the closed-form gradient.

    max I(P)  s.t.  box of A,  s(p_i) ≥ 0

with the exact signed distance s to the border of A; its gradient is the unit vector from the nearest border point
(towards it, outside). Dense QPs make it slow beyond some forty tasks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import Bounds, minimize

from formulations.task_location.boundary import distance_gradient, is_rectangle
from formulations.task_location.derivatives import Expansion
from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.starts import starts
from instances.arrays import Floats


@dataclass(frozen=True)
class Slsqp(PlacementMethod):
    """SLSQP from several starts.

    starts : number of starts, ≥ 1: the greedy choice after exchanges, then random ones.
    iterations : at most so many a start.
    """

    starts: int = 4
    iterations: int = 200
    status: ClassVar[PlacementStatus] = PlacementStatus.LOCALLY_SOLVED

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the snapped end of every start."""
        criterion, region, n = problem.criterion, problem.region, problem.n_tasks
        scales = criterion.scales
        x0, y0, x1, y1 = region.bounds
        box = Bounds(np.tile(np.array([x0, y0]) / scales, n), np.tile(np.array([x1, y1]) / scales, n))
        status = PlacementStatus.HEURISTIC

        def negative(z: Floats) -> tuple[float, Floats]:
            progress.check()
            here = Expansion(criterion, z.reshape(-1, 2) * scales)
            return -here.value, -(here.gradient * scales).ravel()

        inside: list[Any] = []
        if not is_rectangle(region):
            inside = [
                {
                    "type": "ineq",
                    "fun": lambda z: region.signed_distance(z.reshape(-1, 2) * scales) / scales.min(),
                    "jac": lambda z: (
                        _jacobian(distance_gradient(region, z.reshape(-1, 2) * scales) * scales) / scales.min()
                    ),
                }
            ]
        for begin in starts(problem, self.starts, seed):
            done = minimize(
                negative,
                (begin / scales).ravel(),
                jac=True,
                method="SLSQP",
                bounds=box,
                constraints=inside,
                options={"maxiter": self.iterations, "ftol": 1e-8},
            )
            points = region.snap(done.x.reshape(-1, 2) * scales)
            if progress.offer(points, criterion.value(points)):
                status = PlacementStatus.LOCALLY_SOLVED if done.success else PlacementStatus.HEURISTIC
        return status


def _jacobian(rows: Floats) -> Floats:
    """Return the (n, 2n) matrix whose row i holds rows[i] in the columns of point i."""
    n = len(rows)
    jacobian = np.zeros((n, n, 2))
    jacobian[np.arange(n), np.arange(n)] = rows
    return jacobian.reshape(n, 2 * n)
