"""`grid`: the n points of a regular lattice, what a surveyor would draw; a floor for the others."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from formulations.task_location.placement import PlacementMethod, PlacementProblem, PlacementStatus, Progress, lattice
from instances.arrays import Floats
from instances.environment.region import Region


@dataclass(frozen=True)
class Grid(PlacementMethod):
    """Centres of equal cells, as square as they come in length scales."""

    def search(self, problem: PlacementProblem, progress: Progress, seed: int) -> PlacementStatus:
        """Offer the lattice; deterministic, so `seed` is not used."""
        points = regular_points(problem.region, problem.n_tasks, problem.criterion.scales)
        progress.offer(points, problem.criterion.value(points))
        return PlacementStatus.HEURISTIC


def regular_points(region: Region, n: int, scales: Floats) -> Floats:
    """Return n cell centres of a lattice over the bounding box, (n, 2) [m].

    Of all lattices with exactly n centres inside, the one with the squarest cells (by `scales`), up to 3 : 1; where
    there is none, the first with more than n, less those nearest to the border.
    """
    x0, y0, x1, y1 = region.bounds
    most = 2 * math.ceil(math.sqrt(n * (x1 - x0) * (y1 - y0) / region.area)) + 2
    best, squarest, spare = None, math.log(3.0), None
    for columns in range(1, most + 1):
        for rows in range(1, most + 1):
            width, height = (x1 - x0) / columns / scales[0], (y1 - y0) / rows / scales[1]
            skew = abs(math.log(width / height))
            if skew > squarest or columns * rows < n:
                continue
            centres = region.cell_centres(columns, rows)
            if len(centres) == n:
                best, squarest = centres, skew
            elif len(centres) > n and (spare is None or len(centres) < len(spare)):
                spare = centres
    if best is not None:
        return best
    if spare is None:  # a region so thin that only finer lattices meet it
        per_axis = next(k for k in range(most, 1_000_000, most) if len(lattice(region, k)) >= n)
        spare = lattice(region, per_axis)
    inmost = np.argsort(-region.signed_distance(spare), kind="stable")[:n]
    return spare[np.sort(inmost)]
