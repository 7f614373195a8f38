"""Where the local methods begin."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Iterator

import numpy as np

from formulations.limits import Limits
from formulations.task_location.greedy_swap import GreedySwap
from formulations.task_location.placement import OutOfTime, PlacementProblem, Progress, lattice
from instances.arrays import Floats
from instances.environment.region import Region

COARSE = 21
"""Points a side of the lattice for the greedy start."""


def greedy_start(problem: PlacementProblem, seconds: float = math.inf) -> Floats:
    """Return the greedy choice after exchanges (n, 2) [m], as far as these come in so many `seconds`.

    It is over a coarse lattice where that has room for the tasks: the local method does the rest.
    """
    if len(lattice(problem.region, COARSE)) >= 2 * problem.n_tasks:
        problem = dataclasses.replace(problem, candidates_per_axis=COARSE)
    inner = Progress(Limits(time=max(seconds, 1e-9)))
    with contextlib.suppress(OutOfTime):
        GreedySwap().search(problem, inner, 0)
    assert inner.best is not None
    return inner.best


def relocated(region: Region, points: Floats, rng: np.random.Generator) -> Floats:
    """Return `points` (n, 2) [m] with two of them, drawn, put to places drawn from the whole of `region`."""
    moved = np.array(points)
    which = rng.choice(len(points), min(2, len(points)), replace=False)
    moved[which] = region.sample(len(which), rng)
    return moved


def starts(problem: PlacementProblem, count: int, seed: int, seconds: float) -> Iterator[Floats]:
    """Yield `count` starts (n, 2) [m]: the greedy one within so many `seconds` first, then uniform random points."""
    yield greedy_start(problem, seconds)
    rng = np.random.default_rng(seed)
    for _ in range(count - 1):
        yield problem.region.sample(problem.n_tasks, rng)
