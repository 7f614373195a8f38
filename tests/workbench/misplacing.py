"""Placement methods that misbehave, for tests: named as ``misplacing:Class``."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from formulations.task_location.placement import PlacementMethod, PlacementStatus


@dataclass(frozen=True)
class Honest(PlacementMethod):
    """Offers the region's first candidates; `delay` [s] of sleep makes it slow."""

    status: ClassVar[PlacementStatus] = PlacementStatus.HEURISTIC
    delay: float = 0.0

    def search(self, problem, progress, seed):
        points = problem.candidates[: problem.n_tasks]
        progress.offer(points, problem.criterion.value(points))
        time.sleep(self.delay)
        return self.status


class Liar(Honest):
    """Streams points worth less than it says, then goes."""

    def search(self, problem, progress, seed):
        progress.offer(problem.candidates[: problem.n_tasks], 99.0)
        os._exit(0)


class Stray(Honest):
    """Streams points outside the region, then goes."""

    def search(self, problem, progress, seed):
        progress.offer(problem.candidates[: problem.n_tasks] - np.array([1.0, 0.0]), 1.0)
        os._exit(0)


class Crashes(Honest):
    def search(self, problem, progress, seed):
        super().search(problem, progress, seed)
        raise RuntimeError("the dog ate the covariance")


class Hangs(Honest):
    def search(self, problem, progress, seed):
        super().search(problem, progress, seed)
        time.sleep(3600)


class EatsMemory(Honest):
    def search(self, problem, progress, seed):
        super().search(problem, progress, seed)
        eaten = []
        while True:
            eaten.append(b"x" * 20_000_000)
            time.sleep(0.02)
