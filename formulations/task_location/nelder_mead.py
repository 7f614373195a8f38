"""`nelder-mead`: the paper's own choice, MATLAB's fminsearch (Nelder & Mead 1965; Lagarias et al. 1998).

scipy's implementation has fminsearch's coefficients, initial simplex (5 % a coordinate), tolerances (1e-4 in both
unknowns and value) and limits (200 evaluations and iterations an unknown). Points outside the region are worth what
their nearest points of the region are worth. Two forms of the same number, under convention (b):

* "literal": ½ log[det(K_T + σ_n²I) det(K_o + σ_o²W⁻¹) / det K], K the (n + m) × (n + m) covariance of all readings,
  each evaluation from scratch, as the paper's eq. MI is handed to the optimiser;
* "reduced": the n × n form of criterion.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.variance_reduction import Goal, VarianceReduction
from instances.arrays import Floats
from instances.errors import InputError

FORMS = ("reduced", "literal")


@dataclass(frozen=True)
class NelderMead(PlacementMethod):
    """The simplex search of the paper from one random start.

    form : "reduced" (n × n) or "literal" ((n + m) × (n + m), convention (b) only).
    """

    form: str = "reduced"

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise InputError(f"nelder-mead: form must be one of {', '.join(FORMS)}, got '{self.form}'")

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer every new best vertex; heuristic, as a simplex that has shrunk proves nothing."""
        criterion, region = problem.criterion, problem.region
        scales = criterion.scales
        worth = _literal(criterion).value if self.form == "literal" else criterion.value

        def negative(z: Floats) -> float:
            points = region.snap(z.reshape(-1, 2) * scales)
            value = worth(points)
            progress.offer(points, value)
            progress.check()
            return -value

        begin = region.sample(problem.n_tasks, np.random.default_rng(seed)) / scales
        minimize(negative, begin.ravel(), method="Nelder-Mead")
        return PlacementStatus.HEURISTIC


def _literal(goal: Goal) -> JointForm:
    if isinstance(goal, VarianceReduction):
        raise InputError("nelder-mead: the literal form is one of mutual information; criterion j needs form=reduced")
    return JointForm(goal)


class JointForm:
    """Mutual information as the paper writes it: three determinants, of all n + m readings (with the noise of (b))."""

    def __init__(self, criterion: Criterion) -> None:
        if criterion.convention is not Convention.BOTH_NOISY:
            raise InputError("nelder-mead: the literal form needs criterion b: without test noise det(K_o) is 0")
        self._criterion = criterion
        assert criterion.weights is not None
        self._test_noise = criterion.test_noise / criterion.weights

    def value(self, points: Floats) -> float:
        """Return I [nats] for `points` (n, 2) [m]."""
        criterion, n = self._criterion, len(points)
        every = np.concatenate([points, criterion.tests])
        joint = criterion.kernel(every, every) + np.diag(
            np.concatenate([np.full(n, criterion.noise), self._test_noise])
        )
        tasks, tests = joint[:n, :n], joint[n:, n:]
        _, logs = zip(*(np.linalg.slogdet(matrix) for matrix in (tasks, tests, joint)), strict=True)
        return 0.5 * float(logs[0] + logs[1] - logs[2])
