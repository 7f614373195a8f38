"""`nlp`: the non-linear programme of sub-problem 1 in casadi, solved by IPOPT from several starts.

    max I(P)   s.t.  box of A ≤ p_i,  s(p_i) ≥ 0 for every task i,        P = (p_1, …, p_n)

where s is the exact signed distance to the border of A (positive inside), only present where A is not its own
bounding box. Along a straight edge s is linear, so its Hessian is left out; across a ridge, where two edges are
equally near, its gradient jumps, but there the constraint is not active unless A is thin. What IPOPT's tolerance
leaves outside is snapped into A at the end. (A cubic B-spline through distances on a lattice is smooth, but cuts
corners and loses narrow parts of A: up to 0.6 % of I on spiky regions.)

Objective, gradient and Hessian enter as casadi Callbacks with the closed forms of derivatives.py, the Hessian of the
Lagrangian as λ_f ∇²I. Unknowns are in length scales, z = x / l.

A start from nothing seldom ends highest; the best end so far with two tasks put elsewhere does more often (basin
hopping, Wales & Doye 1997, by relocations). In a rectangle such hops are many and cheap: each ascends by L-BFGS-B,
which knows the box, and IPOPT only ends the best. Elsewhere IPOPT ascends from random starts, then ends good hops.

Criterion "j" has its gradient in closed form; IPOPT then approximates the Hessian (limited memory).

Wächter & Biegler (2006), IPOPT; Andersson et al. (2019), CasADi.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from formulations.task_location.ascent import ascend, quasi_newton
from formulations.task_location.boundary import box, distance_gradient, is_rectangle
from formulations.task_location.derivatives import Expansion
from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.starts import greedy_start, relocated
from formulations.task_location.variance_reduction import Goal, Slopes, VarianceReduction, slopes_of
from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError

MOST, FEWEST = 80, 16
"""Ascents in a rectangle: 80 − 2 n, at least 16. With few tasks many ends are nearly as good as the best."""
QUASI_NEWTON = quasi_newton(500, ftol=1e-7)
"""How each is made; what it leaves to gain is IPOPT's."""
RANDOM_STARTS = 12
"""From nothing, the greedy one included, where the region is no rectangle: only these find the right arms."""
ALIKE = 1e-6
"""IPOPT ends a little inside the border [nats], where a task on it is worth more: that is the same end."""
SNAPPED = 1.0
"""A point moved farther [m] into the region at the end is not where IPOPT solved."""


@dataclass(frozen=True)
class Nlp(PlacementMethod):
    """casadi and IPOPT with closed-form gradient and Hessian.

    starts : number of ascents, the first from the greedy choice after exchanges; 0 for 80 − 2 n, at least 16, in a
        rectangle; elsewhere 12, and then half as many hops as there.
    iterations : at most so many a start (at least 0).
    tolerance : IPOPT's scaled optimality error (above 0).
    """

    starts: int = 0
    iterations: int = 100
    tolerance: float = 1e-6

    def __post_init__(self) -> None:
        if not self.tolerance > 0:
            raise InputError(f"nlp: tolerance must be positive, got {self.tolerance:g}")

    def prepare(self, problem: PlacementProblem) -> None:
        """Load IPOPT, which casadi does on first use."""
        ca.has_nlpsol("ipopt")

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the end of every ascent; locally solved where IPOPT says so of the best."""
        model = Model(problem, self.iterations, self.tolerance)
        rng = np.random.default_rng(seed)
        status = PlacementStatus.HEURISTIC
        begins: Iterable[Floats] = self._starts(problem, progress, rng)
        if is_rectangle(problem.region):
            begins = [self._hop(problem, progress, rng)]
        for begin in begins:
            points, converged = model.solve(begin, progress.remaining)
            snapped = problem.region.snap(points)
            value = problem.criterion.value(snapped)
            if progress.offer(snapped, value) or value >= progress.value - ALIKE:
                stationary = converged and float(np.abs(snapped - points).max()) < SNAPPED
                status = PlacementStatus.LOCALLY_SOLVED if stationary else PlacementStatus.HEURISTIC
        return status

    def _hop(self, problem: PlacementProblem, progress: Progress, rng: np.random.Generator) -> Floats:
        """Return the best end of all ascents by L-BFGS-B; offer each."""
        begin = best = greedy_start(problem, progress.remaining)
        progress.offer(best, problem.criterion.value(best))  # it may be all there is
        for _ in range(self.starts or max(FEWEST, MOST - 2 * problem.n_tasks)):
            end = problem.region.snap(ascend(problem, begin, progress, QUASI_NEWTON)[0])
            if progress.offer(end, problem.criterion.value(end)):
                best = end
            begin = relocated(problem.region, best, rng)
        return best

    def _starts(self, problem: PlacementProblem, progress: Progress, rng: np.random.Generator) -> Iterator[Floats]:
        """Yield the greedy start, random ones, and the ends of hops by L-BFGS-B, snapped, that are the best so far."""
        yield greedy_start(problem, progress.remaining)
        for _ in range(1, self.starts or RANDOM_STARTS):
            progress.check()
            yield problem.region.sample(problem.n_tasks, rng)
        for _ in range(0 if self.starts else max(FEWEST, MOST - 2 * problem.n_tasks) // 2):
            assert progress.best is not None
            begin = relocated(problem.region, progress.best, rng)
            end = problem.region.snap(ascend(problem, begin, progress, QUASI_NEWTON)[0])
            if problem.criterion.value(end) > progress.value:
                yield end


class Model:
    """The programme for one problem: built once, solved from many starts."""

    def __init__(self, problem: PlacementProblem, iterations: int, tolerance: float) -> None:
        criterion, n = problem.criterion, problem.n_tasks
        self._scales = criterion.scales
        self._box = box(problem.region, self._scales, n)
        z, p = ca.MX.sym("z", 2 * n), ca.MX.sym("p", 0)
        weight_f = ca.MX.sym("lam_f")
        # casadi does not keep Callbacks alive: they must stay referenced as long as the solver is used
        self._callbacks = objective(criterion, n)
        value, gradient, *curvature = (callback(z) for callback in self._callbacks)
        self._border = [] if is_rectangle(problem.region) else inside(problem.region, self._scales, n)
        constraint = self._border[0](z) if self._border else ca.MX(0, 1)
        weight_g = ca.MX.sym("lam_g", constraint.shape[0])
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
        if self._border:
            options["jac_g"] = ca.Function("jac_g", [z, p], [constraint, self._border[1](z)])
        if curvature:
            entries = ca.triu(weight_f * curvature[0])
            options["hess_lag"] = ca.Function("hess_lag", [z, p, weight_f, weight_g], [entries])
        else:
            options["ipopt.hessian_approximation"] = "limited-memory"
        self._build = {"x": z, "p": p, "f": value, "g": constraint}
        self._options = options
        self._solver = ca.nlpsol("placement", "ipopt", self._build, options)

    def solve(self, begin: Floats, seconds: float) -> tuple[Floats, bool]:
        """Return the end of one start, shape (n, 2) [m], and whether IPOPT calls it locally solved."""
        solver = self._solver
        if math.isfinite(seconds):
            solver = ca.nlpsol(
                "placement", "ipopt", self._build, {**self._options, "ipopt.max_wall_time": max(seconds, 1e-3)}
            )
        rows = self._build["g"].shape[0]
        done = solver(
            x0=(begin / self._scales).ravel(),
            lbx=self._box.lb,
            ubx=self._box.ub,
            lbg=np.zeros(rows),
            ubg=np.full(rows, np.inf),
        )
        points = np.array(done["x"]).reshape(-1, 2) * self._scales
        return points, bool(solver.stats()["success"])


class _Callback(ca.Callback):
    """A numpy function of the unknowns as a casadi function; it returns an array, or the nonzeros of `sparsity`."""

    def __init__(self, name: str, function: Callable[[Floats], Any], n: int, sparsity: ca.Sparsity) -> None:
        ca.Callback.__init__(self)
        self._function, self._n, self._sparsity = function, n, sparsity
        self.construct(name, {})

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(2 * self._n, 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        return self._sparsity

    def eval(self, arg: Sequence[ca.DM]) -> list[Any]:
        return [self._function(np.array(arg[0]).reshape(-1, 2))]


def objective(goal: Goal, n: int) -> list[_Callback]:
    """Return the negative goal, its gradient and, of I, its Hessian as casadi functions of z = x / l, shape (2n, 1).

    IPOPT asks for them one after another at the same z, so what was found last is kept.
    """
    scales = goal.scales
    both = np.tile(scales, n)
    last: tuple[bytes, Slopes | Expansion] | None = None

    def at(z: Floats) -> Slopes | Expansion:
        nonlocal last
        key = z.tobytes()
        if last is None or last[0] != key:
            last = key, slopes_of(goal, z * scales)
        return last[1]

    def hessian(z: Floats) -> Floats:
        here = at(z)
        assert isinstance(here, Expansion)
        return -here.hessian * both * both[:, None]

    callbacks = [
        _Callback("value", lambda z: -at(z).value, n, ca.Sparsity.dense(1, 1)),
        _Callback("gradient", lambda z: -(at(z).gradient * scales).ravel(), n, ca.Sparsity.dense(2 * n, 1)),
    ]
    if isinstance(goal, VarianceReduction):
        return callbacks
    return [*callbacks, _Callback("hessian", hessian, n, ca.Sparsity.dense(2 * n, 2 * n))]


def inside(region: Region, scales: Floats, n: int) -> list[_Callback]:
    """Return s(p_i) in length scales, shape (n, 1), and its Jacobian (n, 2n) as casadi functions of z = x / l."""
    unit = float(scales.min())
    points = np.arange(n)
    sparsity = ca.Sparsity.triplet(n, 2 * n, np.repeat(points, 2).tolist(), list(range(2 * n)))

    def slope(z: Floats) -> ca.DM:
        return ca.DM(sparsity, (distance_gradient(region, z * scales) * scales / unit).ravel())

    return [
        _Callback("inside", lambda z: region.signed_distance(z * scales) / unit, n, ca.Sparsity.dense(n, 1)),
        _Callback("inside_slope", slope, n, sparsity),
    ]
