"""`nlp`: the non-linear programme of sub-problem 1 in casadi, solved by IPOPT from several starts.

    max I(P)   s.t.  box of A ≤ p_i,  s(p_i) ≥ 0 for every task i,        P = (p_1, …, p_n)

where s is the signed distance to the border of A (positive inside), a cubic B-spline through a lattice of exact
distances, and only present where A is not its own bounding box. The spline errs by metres near corners, so the
points found are snapped into A at the end.

Objective, gradient and Hessian enter as casadi Callbacks with the closed forms of derivatives.py: the Hessian of the
Lagrangian is λ_f ∇²I from there plus the constraint's part by casadi's own differentiation. Against letting casadi
differentiate log det this saves a factor of 30 at n = 40, and IPOPT with an exact Hessian needs a third of the
iterations that L-BFGS needs. Unknowns are in length scales, z = x / l.

Wächter & Biegler (2006), IPOPT; Andersson et al. (2019), CasADi.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from formulations.task_location.boundary import is_rectangle
from formulations.task_location.criterion import Array, Criterion
from formulations.task_location.derivatives import Expansion
from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.starts import starts
from instances.environment.region import Region

LATTICE = 61
"""Points a side at which the signed distance is exact."""


@dataclass(frozen=True)
class Nlp(PlacementMethod):
    """casadi and IPOPT with closed-form gradient and Hessian.

    starts : number of starts: the greedy choice after exchanges, then random ones; 0 for n / 5, from 2 to 8.
    iterations : at most so many a start.
    tolerance : IPOPT's scaled optimality error.
    """

    starts: int = 0
    iterations: int = 100
    tolerance: float = 1e-6
    status: ClassVar[PlacementStatus] = PlacementStatus.LOCALLY_SOLVED

    def prepare(self, problem: PlacementProblem) -> None:
        """Load IPOPT, which casadi does on first use."""
        ca.has_nlpsol("ipopt")

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the snapped end of every start; locally solved where IPOPT says so of the best."""
        criterion, region = problem.criterion, problem.region
        model = Model(problem, self.iterations, self.tolerance)
        status = PlacementStatus.HEURISTIC
        for begin in starts(problem, self.starts or min(max(2, problem.n_tasks // 5), 8), seed):
            progress.check()
            points, converged = model.solve(begin, progress.remaining)
            points = region.snap(points)
            if progress.offer(points, criterion.value(points)):
                status = PlacementStatus.LOCALLY_SOLVED if converged else PlacementStatus.HEURISTIC
        return status


class Model:
    """The programme for one problem: built once, solved from many starts."""

    def __init__(self, problem: PlacementProblem, iterations: int, tolerance: float) -> None:
        criterion, n = problem.criterion, problem.n_tasks
        self._scales = criterion.scales
        x0, y0, x1, y1 = problem.region.bounds
        self._low = np.tile(np.array([x0, y0]) / self._scales, n)
        self._high = np.tile(np.array([x1, y1]) / self._scales, n)
        z, p = ca.MX.sym("z", 2 * n), ca.MX.sym("p", 0)
        weight_f = ca.MX.sym("lam_f")
        # casadi does not keep Callbacks alive: they must stay referenced as long as the solver is used
        self._callbacks = objective(criterion, n)
        value, gradient, curvature = (callback(z) for callback in self._callbacks)
        constraint = ca.MX(0, 1) if is_rectangle(problem.region) else self._inside(problem.region, z, n)
        weight_g = ca.MX.sym("lam_g", constraint.shape[0])
        second = weight_f * curvature
        options: dict[str, Any] = {
            "grad_f": ca.Function("grad_f", [z, p], [value, gradient]),
            "no_nlp_grad": True,
            "calc_lam_p": False,
            "print_time": False,
            "ipopt.max_iter": iterations,
            "ipopt.tol": tolerance,
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.bound_relax_factor": 0.0,
        }
        if constraint.shape[0]:
            jacobian = ca.jacobian(constraint, z)
            options["jac_g"] = ca.Function("jac_g", [z, p], [constraint, jacobian])
            second += ca.hessian(ca.dot(weight_g, constraint), z)[0]
        options["hess_lag"] = ca.Function("hess_lag", [z, p, weight_f, weight_g], [ca.triu(second)])
        self._build = {"x": z, "p": p, "f": value, "g": constraint}
        self._options = options
        self._solver = ca.nlpsol("placement", "ipopt", self._build, options)

    def _inside(self, region: Region, z: ca.MX, n: int) -> ca.MX:
        """Return s(p_i) in length scales, a column of n."""
        low, high = self._low[:2], self._high[:2]
        xs, ys = (np.linspace(low[d], high[d], LATTICE) for d in (0, 1))
        nodes = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
        distance = region.signed_distance(nodes * self._scales) / self._scales.min()
        # casadi wants the first coordinate to run fastest
        flat = distance.reshape(LATTICE, LATTICE).ravel(order="F")
        spline = ca.interpolant("s", "bspline", [xs.tolist(), ys.tolist()], flat.tolist())
        return spline.map(n)(ca.reshape(z, 2, n)).T

    def solve(self, begin: Array, seconds: float) -> tuple[Array, bool]:
        """Return the end of one start, shape (n, 2) [m], and whether IPOPT calls it locally solved."""
        solver = self._solver
        if math.isfinite(seconds):
            solver = ca.nlpsol(
                "placement", "ipopt", self._build, {**self._options, "ipopt.max_wall_time": max(seconds, 1e-3)}
            )
        rows = self._build["g"].shape[0]
        done = solver(
            x0=(begin / self._scales).ravel(),
            lbx=self._low,
            ubx=self._high,
            lbg=np.zeros(rows),
            ubg=np.full(rows, np.inf),
        )
        points = np.array(done["x"]).reshape(-1, 2) * self._scales
        return points, bool(solver.stats()["success"])


class _Callback(ca.Callback):
    """A numpy function of the unknowns as a casadi function."""

    def __init__(self, name: str, function: Callable[[Array], Any], n: int, shape: tuple[int, int]) -> None:
        ca.Callback.__init__(self)
        self._function, self._n, self._shape = function, n, shape
        self.construct(name, {})

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(2 * self._n, 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(*self._shape)

    def eval(self, arg: Sequence[ca.DM]) -> list[Any]:
        return [self._function(np.array(arg[0]).reshape(-1, 2))]


def objective(criterion: Criterion, n: int) -> tuple[_Callback, _Callback, _Callback]:
    """Return −I, its gradient and its Hessian as casadi functions of z = x / l, shape (2n, 1).

    IPOPT asks for the three one after another at the same z, so the last expansion is kept.
    """
    scales = criterion.scales
    both = np.tile(scales, n)
    last: tuple[bytes, Expansion] | None = None

    def at(z: Array) -> Expansion:
        nonlocal last
        key = z.tobytes()
        if last is None or last[0] != key:
            last = key, Expansion(criterion, z * scales)
        return last[1]

    return (
        _Callback("value", lambda z: -at(z).value, n, (1, 1)),
        _Callback("gradient", lambda z: -(at(z).gradient * scales).ravel(), n, (2 * n, 1)),
        _Callback("hessian", lambda z: -at(z).hessian * both * both[:, None], n, (2 * n, 2 * n)),
    )
