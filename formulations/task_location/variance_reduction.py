"""Criterion "j": how far readings at the tasks lower the weighted mean variance of the field at the test points.

    max ½ log(J(∅)/J(P_T)),   J(P) = Σ_g w_g var(f(g) | y(P)) / Σ_g w_g                             [nats]

J is what optimal design calls A-optimality of the predictions, and kriging the integrated mean square error (Sacks,
Schiller & Welch 1989): where a test point counts ten times, a variance there does. Under (b) a weight is a number of
noisy readings instead, and of those the first already says nearly all: weights hardly act there. Half the logarithm is
taken so that the number is one of nats, as information is: it is that of one Gaussian whose variance falls from J(∅) to
J. `formulations.average_variance` has J, its gradient and the bound that no n readings pass.

A reading at x beside those at S lowers J by Σ_g w_g c(g, x)² / (c(x, x) + σ²), c the posterior covariance given S.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cholesky, solve_triangular

from formulations.average_variance import AverageVariance
from formulations.kernel import SquaredExponential
from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.derivatives import Expansion
from instances.arrays import Floats

NAME = "j"
"""What the criterion is called beside the conventions of mutual information."""
CLEARLY = 1e-9
"""Of J: an exchange that lowers it by less is none."""


class Slopes(NamedTuple):
    """What a goal is worth [nats] and its gradient [nats/m], shape (n, 2)."""

    value: float
    gradient: Floats


@dataclass(frozen=True, eq=False)
class VarianceReduction:
    """½ log(J₀/J) as a function of the task locations; `information` has kernel, test points, weights and noise."""

    information: Criterion

    @property
    def kernel(self) -> SquaredExponential:
        """Prior covariance of the field."""
        return self.information.kernel

    @property
    def noise_sd(self) -> float:
        """σ_n of a task reading."""
        return self.information.noise_sd

    @property
    def tests(self) -> Floats:
        """Test points, shape (m, 2) [m]."""
        return self.information.tests

    @property
    def scales(self) -> Floats:
        """(l_x, l_y) [m], shape (2,)."""
        return self.information.scales

    def under(self, convention: Convention) -> Criterion:
        """Return the mutual information of the same tests under a noise convention."""
        return self.information.under(convention)

    @cached_property
    def judged(self) -> AverageVariance:
        """J."""
        about = self.information
        return AverageVariance(about.kernel, about.noise_sd, about.tests, about.weights)

    @cached_property
    def before(self) -> float:
        """J(∅), in the field's unit squared."""
        return self.judged.value(np.empty((0, 2)))

    def value(self, points: ArrayLike) -> float:
        """Return ½ log(J₀/J) [nats] for `points` (n, 2) [m]."""
        return 0.5 * math.log(self.before / self.judged.value(points))

    def upper_bound(self, count: int) -> float:
        """Return what no `count` points are worth more than [nats], wherever they are, replicates included."""
        return 0.5 * math.log(self.before / self.judged.lower_bound(count))

    def slopes(self, points: Floats) -> Slopes:
        """Return ½ log(J₀/J) and its gradient at `points` (n, 2) [m]."""
        left, gradient = self.judged(points)
        return Slopes(0.5 * math.log(self.before / left), -0.5 * gradient / left)


Goal = Criterion | VarianceReduction
"""What a placement maximises."""


def information_of(goal: Goal) -> Criterion:
    """Return the mutual information that a goal is, or that of the same tests and noise under (b)."""
    return goal.information if isinstance(goal, VarianceReduction) else goal


def slopes_of(goal: Goal, points: Floats) -> Slopes | Expansion:
    """Return value and gradient of a goal at `points` (n, 2) [m]; of mutual information the Hessian, too."""
    return goal.slopes(points) if isinstance(goal, VarianceReduction) else Expansion(goal, points)


class VarianceChoice:
    """Chooses among candidate sites: the best one more, and the best one in place of another."""

    def __init__(self, goal: VarianceReduction, candidates: Floats, chosen: list[int] | None = None) -> None:
        self.chosen = list(chosen or ())
        self._candidates, self._noise = candidates, goal.noise_sd**2
        self._own = goal.kernel.variance(candidates)
        self._kernel = goal.kernel
        roots = np.sqrt(goal.judged.shares)[:, None]
        self._to_tests = roots * goal.kernel(goal.tests, candidates)

    def add(self) -> None:
        """Choose one more."""
        self.chosen.append(int(np.argmax(self._decreases(self.chosen))))

    def improve(self, i: int) -> bool:
        """Put the best candidate in place of ``chosen[i]``; return whether that is another one, clearly better."""
        rest = self.chosen[:i] + self.chosen[i + 1 :]
        decrease = self._decreases(rest)
        best, now = int(np.argmax(decrease)), self.chosen[i]
        if not decrease[best] > decrease[now] * (1 + CLEARLY):
            return False
        self.chosen[i] = best
        return True

    def _decreases(self, taken: list[int]) -> Floats:
        """Return by how much a reading at each candidate lowers J beside those `taken`; −∞ for these."""
        cross, own = self._to_tests, self._own
        if taken:
            rows = self._kernel(self._candidates[taken], self._candidates)
            covariance = rows[:, taken] + self._noise * np.eye(len(taken))
            factor = cholesky(covariance, lower=True, check_finite=False)
            half = solve_triangular(factor, rows, lower=True, check_finite=False)
            tests = solve_triangular(factor, self._to_tests[:, taken].T, lower=True, check_finite=False)
            cross, own = cross - tests.T @ half, np.maximum(own - np.einsum("ij,ij->j", half, half), 0.0)
        decrease = np.einsum("gx,gx->x", cross, cross) / (own + self._noise)
        decrease[taken] = -np.inf
        return np.asarray(decrease)
