"""`random`: n points uniform in the region, as in the paper's Fig. 1; the floor of the comparison."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress


@dataclass(frozen=True)
class Random(PlacementMethod):
    """Uniform random points."""

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer one draw."""
        points = problem.region.sample(problem.n_tasks, np.random.default_rng(seed))
        progress.offer(points, problem.criterion.value(points))
        return PlacementStatus.HEURISTIC
