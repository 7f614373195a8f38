"""`memetic`: annealed ruin-and-recreate with long cuts, inside a population with route crossover.

How it was chosen: several annealings and their children beat one long annealing, the more so the smaller the instance,
as long as each is deep enough; long tours need more depth. So the size of the population follows from the limit:
depth · n² / m steps go into one annealing, and where the limit allows fewer than three, all of it goes into one.
Parts: ruin.py, recreate.py (p-norm insertion), cuts.py (2-opt, Or-opt, 2-opt* and segments priced by prefix sums),
energy.py, annealing.py, focus.py, relief.py, crossover.py, intensify.py (single tours, order.py), population.py.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from typing import ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import Recorder
from formulations.routing.search.annealing import POWERS, Habits
from formulations.routing.search.focus import put_back
from formulations.routing.search.ground import survey
from formulations.routing.search.neighbours import NEAR_TASKS
from formulations.routing.search.pace import Pace
from formulations.routing.search.population import Population, Shares
from formulations.routing.search.randomness import seeded, uniform
from formulations.routing.search.relief import relieve
from formulations.routing.search.tours import from_routes, to_routes
from formulations.routing.solver import Observer, Result, Solver, ignore
from instances import InputError, Instance, Routes

_PROBE = 0.01
"""Share of the limit after which the speed is known well enough to plan."""
_STEPS_A_LEVEL = 250
"""Steps at one temperature, at most: the shortest annealing, of 10 000, has forty levels."""


@dataclass(frozen=True)
class Memetic(Solver):
    """The state-of-the-art min-max search.

    removals : tasks taken out by one ruin, at most (1 to 20).
    strings : share of ruins that take strings of consecutive tasks; the others take nearest neighbours.
    cuts : share of steps that cut and rejoin long pieces of one or two tours.
    powers : how many of the guides Σ C_k^p, p = 1, 2, 5, 12, 30, ∞, the recreation draws from (1: the total).
    focuses : share of the population's later stages that search the longest tour and a few others alone.
    reliefs : share of the remaining ones that send a UAV elsewhere; the others are crossovers.
    kicks : of each tour's order at the end of a stage, for each of its tasks; 0 leaves orders to the annealing.
    depth : a founder's annealing takes depth · n² / m steps, at least 10 000 to 25 000, doubled at each new start.
    """

    removals: int = 12
    strings: float = 0.5
    cuts: float = 0.1
    powers: int = len(POWERS)
    focuses: float = 0.6
    reliefs: float = 0.5
    kicks: float = 1.0
    depth: float = 2.0

    proves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for name, low, high in (
            ("removals", 1, NEAR_TASKS),
            ("strings", 0, 1),
            ("cuts", 0, 1),
            ("powers", 1, len(POWERS)),
            ("focuses", 0, 1),
            ("reliefs", 0, 1),
            ("kicks", 0, 1000),
            ("depth", 0.01, float("inf")),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
                raise InputError(f"memetic: {name} must lie in {low}..{high}, got {value!r}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (or load them from numba's cache)."""
        small = Instance("warm-up", 1.0 - np.eye(9), 6, 3)
        Memetic(depth=0.01).solve(small, limits=Limits(time=3600.0, iterations=200))
        population = self._populations(small, 1, 0, None)[0]
        uniform(population.rng)
        population.next_stage(0.0)
        population.members = [population.best, population.best]
        population.child()
        population.relieved()
        part = population.focused()
        relieve(part.ground.costs, part.ground.near, part.tours, population.rng)
        put_back(population.ground.costs, part.nodes, part.best, population.best)

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
                        population.plan(1.0 / pace.total_steps, self.depth)
                _next_stages(populations, now)
                steps = pace.next_steps(_STEPS_A_LEVEL)
                if len(populations) == 1:
                    populations[0].advance(now, steps)
                else:
                    list(pool.map(Population.advance, populations, repeat(now), repeat(steps)))
                pace.took(steps)
        return recorder.result(pace.stopped_by, iterations=pace.iterations, stages=populations[0].stages)

    def _populations(self, instance: Instance, count: int, seed: int, start: Routes | None) -> list[Population]:
        ground = survey(instance.cost, instance.n_tasks)
        habits = Habits(self.removals, float(self.strings), float(self.cuts), self.powers)
        shares = Shares(float(self.focuses), float(self.reliefs))
        kicks = float(self.kicks)
        first = [from_routes(ground.costs, start) if start is not None else None for _ in range(count)]
        return [Population(ground, habits, shares, kicks, seeded(seed, i), tours) for i, tours in enumerate(first)]


def _next_stages(populations: list[Population], now: float) -> None:
    """End the stage of each population whose stage is over; it takes in the best tours of the one before it."""
    for i, population in enumerate(populations):
        if now >= population.end:
            population.next_stage(now, populations[i - 1].best if len(populations) > 1 else None)
