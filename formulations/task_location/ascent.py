"""`l-bfgs-b` and `slsqp`: ascent along the closed-form gradient by scipy, from several starts.

* l-bfgs-b, the bound-constrained quasi-Newton method of Byrd, Lu, Nocedal & Zhu (1995), knows only the bounding box:
  outside a non-rectangular region the points are snapped to it at the end of a start.
* slsqp, sequential least-squares quadratic programming (Kraft 1988), keeps to the region,

    max I(P)  s.t.  box of A,  s(p_i) ≥ 0

  with the exact signed distance s to the border of A; its gradient is the unit vector from the nearest border point
  (towards it, outside). Dense QPs make it slow beyond some forty tasks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import minimize

from formulations.task_location.boundary import box, distance_gradient, is_rectangle
from formulations.task_location.placement import OutOfTime, PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.starts import starts
from formulations.task_location.variance_reduction import slopes_of
from instances.arrays import Floats

Settings = dict[str, Any]
"""What `scipy.optimize.minimize` is told besides objective, start and box."""


def quasi_newton(iterations: int, **more: float) -> Settings:
    """Return the settings of L-BFGS-B with at most so many iterations; more : scipy's, such as ftol."""
    return {"method": "L-BFGS-B", "options": {"maxiter": iterations, "maxcor": 20, **more}}


def ascend(problem: PlacementProblem, begin: Floats, progress: Progress, settings: Settings) -> tuple[Floats, bool]:
    """Return where the ascent from `begin` ends, (n, 2) [m], in the bounding box; and whether it converged.

    Raises OutOfTime.
    """
    criterion, scales = problem.criterion, problem.criterion.scales

    def negative(z: Floats) -> tuple[float, Floats]:
        progress.check()
        here = slopes_of(criterion, z.reshape(-1, 2) * scales)
        return -here.value, -(here.gradient * scales).ravel()

    bounds = box(problem.region, scales, problem.n_tasks)
    done = minimize(negative, (begin / scales).ravel(), jac=True, bounds=bounds, **settings)
    return done.x.reshape(-1, 2) * scales, bool(done.success)


@dataclass(frozen=True)
class LBfgsB(PlacementMethod):
    """L-BFGS-B with the closed-form gradient.

    starts : number of starts: the greedy choice after exchanges, then random ones (at least 0, 0 meaning 1).
    iterations : at most so many a start (at least 0).
    """

    starts: int = 8
    iterations: int = 500

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the snapped end of every start."""
        criterion, settings = problem.criterion, self.settings(problem)
        status = PlacementStatus.HEURISTIC
        for begin in starts(problem, self.starts, seed, progress.remaining):
            try:
                points, success = ascend(problem, begin, progress, settings)
            except OutOfTime:
                progress.offer(begin, criterion.value(begin))  # the first one may be all there is
                raise
            snapped = problem.region.snap(points)
            if progress.offer(snapped, criterion.value(snapped)):
                solved = success and ("constraints" in settings or np.array_equal(points, snapped))
                status = PlacementStatus.LOCALLY_SOLVED if solved else PlacementStatus.HEURISTIC
        return status

    def settings(self, problem: PlacementProblem) -> Settings:
        """Return what `scipy.optimize.minimize` is told besides objective, start and box."""
        return quasi_newton(self.iterations)


@dataclass(frozen=True)
class Slsqp(LBfgsB):
    """SLSQP with the closed-form gradient; its options mean what those of l-bfgs-b do."""

    starts: int = 4
    iterations: int = 200

    def settings(self, problem: PlacementProblem) -> Settings:
        """Return what `scipy.optimize.minimize` is told, with the border as a constraint where the box is not all."""
        region, scales = problem.region, problem.criterion.scales
        inside: dict[str, Any] = {
            "type": "ineq",
            "fun": lambda z: region.signed_distance(z.reshape(-1, 2) * scales) / scales.min(),
            "jac": lambda z: block_diag(*distance_gradient(region, z.reshape(-1, 2) * scales) * scales) / scales.min(),
        }
        options = {"maxiter": self.iterations, "ftol": 1e-8}
        return {"method": "SLSQP", "constraints": [] if is_rectangle(region) else [inside], "options": options}
