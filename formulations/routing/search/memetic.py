"""`memetic`: annealed ruin-and-recreate with long cuts, inside a population with route crossover.

How it was chosen: several annealings and their children beat one long annealing, the more so the smaller the instance,
as long as each is deep enough; long tours need more depth. So the size of the population follows from the limit:
depth · n² / m steps go into one annealing, and where the limit allows fewer than three, all of it goes into one.
Parts: ruin.py, recreate.py (p-norm insertion), cuts.py (2-opt, Or-opt, 2-opt* and segments priced by prefix sums),
annealing.py (max C_k + ε · mean C_k), crossover.py, relief.py, population.py.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from typing import ClassVar

import numpy as np

from formulations.recorder import Recorder
from formulations.routing.search.annealing import POWERS, Habits
from formulations.routing.search.costs import both_ways
from formulations.routing.search.crossover import places
from formulations.routing.search.neighbours import NEAR_DEPOTS, NEAR_TASKS, neighbours
from formulations.routing.search.pace import Pace
from formulations.routing.search.population import Ground, Population
from formulations.routing.search.randomness import seeded
from formulations.routing.search.tours import from_routes, to_routes
from formulations.solver import Limits, Observer, Result, Solver, ignore
from instances import InputError, Instance, Routes

_PROBE = 0.01
"""Share of the limit after which the speed is known well enough to plan."""
_SHALLOWEST = 10_000
"""Steps of a founder's annealing, at least."""
_LEVELS, _SHORTEST = 40, 100
"""Temperature levels of one annealing, at least; steps at one level, at least."""


@dataclass(frozen=True)
class Memetic(Solver):
    """The state-of-the-art min-max search.

    removals : tasks taken out by one ruin, at most (1 to 20).
    strings : share of ruins that take strings of consecutive tasks; the others take nearest neighbours.
    cuts : share of steps that cut and rejoin long pieces of one or two tours.
    powers : how many of the guides Σ C_k^p, p = 1, 2, 5, 12, the recreation draws from (1 is the total alone).
    reliefs : share of the population's later stages that send a UAV elsewhere; the others are crossovers.
    depth : a founder's annealing takes depth · n² / m steps, at least 10 000, doubled at each new start.
    """

    removals: int = 12
    strings: float = 0.5
    cuts: float = 0.1
    powers: int = 4
    reliefs: float = 0.5
    depth: float = 5.0

    proves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for name, low, high in (
            ("removals", 1, NEAR_TASKS),
            ("strings", 0, 1),
            ("cuts", 0, 1),
            ("powers", 1, len(POWERS)),
            ("reliefs", 0, 1),
            ("depth", 0.01, float("inf")),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
                raise InputError(f"memetic: {name} must lie in {low}..{high}, got {value!r}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (or load them from numba's cache)."""
        small = Instance("warm-up", 1.0 - np.eye(6), 4, 2)
        Memetic(depth=0.01).solve(small, limits=Limits(time=3600.0, iterations=200))
        population = self._populations(small, 1, 0, None)[0]
        population.members = [population.best, population.best]
        population.child()
        population.relieved()

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Search until a limit; one annealing step is one iteration, counted in each of the `threads` populations."""
        recorder = Recorder(instance, limits, observe, start)
        populations = self._populations(instance, limits.threads, seed, start)
        pace = Pace(recorder)
        planned = False
        annealing = max(_SHALLOWEST, self.depth * instance.n_tasks**2 / instance.n_depots)
        most = max(_SHORTEST, int(annealing / _LEVELS))
        with ThreadPoolExecutor(limits.threads) as pool:
            while True:
                for population in populations:
                    if population.improved:
                        population.improved = False
                        recorder.incumbent(to_routes(population.best))
                if pace.stopped_by:
                    break
                now = pace.fraction
                if not planned and now >= _PROBE:
                    planned = True
                    for population in populations:
                        population.plan(annealing / pace.total_steps)
                _next_stages(populations, now)
                steps = pace.next_steps(most)
                if len(populations) == 1:
                    populations[0].advance(now, steps)
                else:
                    list(pool.map(Population.advance, populations, repeat(now), repeat(steps)))
                pace.took(steps)
        return recorder.result(pace.stopped_by, iterations=pace.iterations, stages=populations[0].stages)

    def _populations(self, instance: Instance, count: int, seed: int, start: Routes | None) -> list[Population]:
        costs = both_ways(instance.cost)
        near = neighbours(costs, instance.n_tasks, NEAR_TASKS, NEAR_DEPOTS)
        ground = Ground(costs, near, places(costs, instance.n_tasks))
        habits = Habits(self.removals, float(self.strings), float(self.cuts), self.powers)
        first = [from_routes(costs, start) if start is not None else None for _ in range(count)]
        return [
            Population(ground, habits, float(self.reliefs), seeded(seed, i), tours) for i, tours in enumerate(first)
        ]


def _next_stages(populations: list[Population], now: float) -> None:
    """End the stage of each population whose stage is over; it takes in the best tours of the one before it."""
    for i, population in enumerate(populations):
        if now >= population.end:
            population.next_stage(now, populations[i - 1].best if len(populations) > 1 else None)
