"""`greedy`: add the candidate of largest information gain, n times (Krause, Singh & Guestrin 2008, Alg. 1).

Adding x to S gains ½ log[(k(x|S) + σ²) / (c(x|S) + σ²)], where k(·|S) and c(·|S) are the variances left by the noisy
readings at S under the prior and the posterior kernel (criterion.py). Both are kept up to date by one Cholesky row
a step, O(N n) in all for N candidates, so no lazy queue is needed. Under criterion "j" the site is added that lowers
the weighted mean variance most (variance_reduction.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress
from formulations.task_location.variance_reduction import Goal, VarianceChoice
from instances.arrays import Floats


@dataclass(frozen=True)
class Greedy(PlacementMethod):
    """Greedy over the candidate sites."""

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the greedy choice; deterministic, so `seed` is not used."""
        chosen = greedy_of(problem.criterion, problem.candidates, problem.n_tasks)
        points = problem.candidates[chosen]
        progress.offer(points, problem.criterion.value(points))
        return PlacementStatus.HEURISTIC


def greedy_of(goal: Goal, candidates: Floats, count: int) -> list[int]:
    """Return the indices of `count` candidates, the one that raises `goal` most first."""
    if isinstance(goal, Criterion):
        return greedy_choice(goal, candidates, count)
    choice = VarianceChoice(goal, candidates)
    for _ in range(count):
        choice.add()
    return choice.chosen


def greedy_choice(criterion: Criterion, candidates: Floats, count: int) -> list[int]:
    """Return the indices of `count` candidates, in greedy order."""
    phi = criterion.features(candidates)
    prior_left = criterion.kernel.variance(candidates)
    posterior_left = posterior_variance(criterion, phi, prior_left)
    prior_rows = np.zeros((count, len(candidates)))  # rows of L⁻¹ K(S, candidates)
    posterior_rows = np.zeros((count, len(candidates)))
    noise = criterion.noise
    free = np.ones(len(candidates), dtype=bool)
    chosen: list[int] = []
    for step in range(count):
        gain = np.log((prior_left + noise) / (np.maximum(posterior_left, 0.0) + noise))
        best = int(np.argmax(np.where(free, gain, -np.inf)))
        chosen.append(best)
        free[best] = False
        prior = criterion.kernel(candidates[best][None], candidates)[0]
        posterior = criterion.posterior(prior, phi[:, best], phi)
        for rows, left, row in ((prior_rows, prior_left, prior), (posterior_rows, posterior_left, posterior)):
            row -= rows[:step, best] @ rows[:step]
            row /= np.sqrt(max(left[best], 0.0) + noise)
            rows[step] = row
            left -= row * row
    return chosen


def posterior_variance(criterion: Criterion, phi: Floats, prior: Floats) -> Floats:
    """Return c(x_i, x_i) from the features φ(x_i) and `prior`, k(x_i, x_i), shape (N,); 0 for IG."""
    if criterion.convention is Convention.INFORMATION_GAIN:
        return np.zeros(phi.shape[1])
    return np.asarray(np.maximum(prior - np.einsum("ri,ri->i", phi, phi), 0.0))
