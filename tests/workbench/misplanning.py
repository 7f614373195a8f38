"""Moving-cost methods that misbehave, for tests: named as ``misplanning:Class``. In calm air over open country."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from formulations.moving_cost.method import MovingCostMethod, MovingCosts, silent
from instances.paths import Paths


@dataclass(frozen=True)
class Honest(MovingCostMethod):
    """Flies straight; `delay` [s] of sleep makes it slow."""

    delay: float = 0.0

    def solve(self, query, progress=silent):
        found = self.straight(query)
        if len(query.terminals) > 2:  # two are asked for to prepare
            self.misbehave()
        return found

    def misbehave(self):
        time.sleep(self.delay)

    def straight(self, query):
        p, n = query.terminals, len(query.terminals)
        legs = [p[[i, j]] if i != j else np.empty((0, 2)) for i in range(n) for j in range(n)]
        return MovingCosts(np.hypot(*(p[:, None] - p[None]).transpose(2, 0, 1)) / query.v0, Paths.of(n, legs))


class Liar(Honest):
    """Says half of what its paths cost."""

    def solve(self, query, progress=silent):
        found = self.straight(query)
        return replace(found, cost=0.5 * found.cost)


class Crashes(Honest):
    def misbehave(self):
        raise RuntimeError("the dog ate the map")


class Hangs(Honest):
    def misbehave(self):
        time.sleep(3600)


class EatsMemory(Honest):
    def misbehave(self):
        eaten = []
        while True:
            eaten.append(b"x" * 20_000_000)
            time.sleep(0.02)
