"""`greedy-swap`: greedy, then exchange one task at a time for the best candidate until none gains (Fedorov 1972).

For task i, with the others S = T∖{i} fixed, I(S ∪ {x}) = I(S) + ½ log[(k(x|S) + σ²) / (c(x|S) + σ²)]: one Cholesky
factor of S for either kernel and one triangular solve against all candidates give the best x at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from formulations.task_location.criterion import Criterion
from formulations.task_location.greedy import greedy_of, posterior_variance
from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.variance_reduction import VarianceChoice
from instances.arrays import Floats


@dataclass(frozen=True)
class GreedySwap(PlacementMethod):
    """Greedy and best exchanges.

    sweeps : at most so many passes over all tasks (at least 0).
    """

    sweeps: int = 20

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the greedy choice and each improved one; deterministic, so `seed` is not used."""
        criterion, sites = problem.criterion, problem.candidates
        chosen = greedy_of(criterion, sites, problem.n_tasks)
        progress.offer(sites[chosen], criterion.value(sites[chosen]))
        exchange = (
            Exchange(criterion, sites, chosen)
            if isinstance(criterion, Criterion)
            else VarianceChoice(criterion, sites, chosen)
        )
        for _ in range(self.sweeps):
            improved = False
            for i in range(problem.n_tasks):
                progress.check()
                improved |= exchange.improve(i)
            if not improved:
                break
            points = sites[exchange.chosen]
            progress.offer(points, criterion.value(points))
        return PlacementStatus.HEURISTIC


class Exchange:
    """Replaces chosen candidates by better ones; keeps k(chosen, all) and c(chosen, all) up to date."""

    def __init__(self, criterion: Criterion, candidates: Floats, chosen: list[int]) -> None:
        self.chosen = list(chosen)
        self._criterion, self._candidates = criterion, candidates
        self._phi = criterion.features(candidates)
        self._own = criterion.kernel.variance(candidates)
        self._prior = criterion.kernel(candidates[chosen], candidates)
        self._posterior = criterion.posterior(self._prior, self._phi[:, chosen], self._phi)
        self._posterior_own = posterior_variance(criterion, self._phi, self._own)

    def improve(self, i: int) -> bool:
        """Put the best candidate in place of ``chosen[i]``; return whether that is another one, clearly better."""
        noise = self._criterion.noise
        rest = [j for j in range(len(self.chosen)) if j != i]
        taken = [self.chosen[j] for j in rest]
        prior = _left(self._own, self._prior[rest], taken, noise)
        posterior = _left(self._posterior_own, self._posterior[rest], taken, noise)
        gain = np.log(prior + noise) - np.log(posterior + noise)
        gain[taken] = -np.inf
        best = int(np.argmax(gain))
        if not gain[best] > gain[self.chosen[i]] + 1e-9:
            return False
        self.chosen[i] = best
        self._prior[i] = self._criterion.kernel(self._candidates[best][None], self._candidates)[0]
        self._posterior[i] = self._criterion.posterior(self._prior[i], self._phi[:, best], self._phi)
        return True


def _left(own: Floats, rows: Floats, taken: list[int], noise: float) -> Floats:
    """Return the variance left at every candidate by noisy readings at `taken`, of which `rows` are the kernel rows."""
    if not taken:
        return own
    factor = np.linalg.cholesky(rows[:, taken] + noise * np.eye(len(taken)))
    half = solve_triangular(factor, rows, lower=True, check_finite=False)
    return np.maximum(own - np.einsum("ij,ij->j", half, half), 0.0)
