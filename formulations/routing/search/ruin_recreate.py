"""`ruin-recreate`: one annealed trajectory of ruin and recreate, the honest intermediate baseline of `memetic`.

Each step takes up to `removals` related tasks out (ruin.py), puts them back where they hurt a p-norm of the tours least
(recreate.py) and keeps the result by simulated annealing on max C_k + ε · mean C_k (annealing.py). Temperature and ε
fall geometrically over the given limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from formulations.limits import Limits
from formulations.routing.recorder import Recorder
from formulations.routing.search import cooling
from formulations.routing.search.annealing import POWERS, Habits, anneal
from formulations.routing.search.costs import Costs, both_ways
from formulations.routing.search.neighbours import NEAR_DEPOTS, NEAR_TASKS, Neighbours, neighbours
from formulations.routing.search.pace import Pace
from formulations.routing.search.randomness import seeded
from formulations.routing.search.recreate import construct
from formulations.routing.search.tours import Tours, copy_tours, empty_tours, from_routes, to_routes
from formulations.routing.solver import Observer, Result, Solver, ignore
from instances import InputError, Instance, Routes


@dataclass(frozen=True)
class RuinRecreate(Solver):
    """Annealed ruin-and-recreate.

    removals : tasks taken out at once, at most (1 to 20).
    """

    removals: int = 12

    proves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        if not 1 <= self.removals <= NEAR_TASKS:
            raise InputError(f"ruin-recreate: removals must lie in 1..{NEAR_TASKS}, got {self.removals}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (or load them from numba's cache)."""
        small = Instance("warm-up", 1.0 - np.eye(3), 2, 1)
        self.solve(small, limits=Limits(time=3600.0, iterations=1))

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Anneal until a limit; one step is one iteration."""
        recorder = Recorder(instance, limits, observe, start)
        costs = both_ways(instance.cost)
        near = neighbours(costs, instance.n_tasks, NEAR_TASKS, NEAR_DEPOTS)
        habits = Habits(self.removals, strings=0.5, cuts=0.0, powers=len(POWERS))
        rng = seeded(seed)
        tours = _first_tours(instance, costs, near, rng, start)
        best, fittest = (empty_tours(instance.n_tasks, instance.n_depots) for _ in range(2))
        copy_tours(tours, best)
        copy_tours(tours, fittest)
        recorder.incumbent(to_routes(best))
        manner = cooling.Manner(cooling.HOT, cooling.SOFT[0], cooling.COARSE)
        pace = Pace(recorder)
        while not pace.stopped_by:
            done, longest = pace.fraction, best.cost.max()
            temperature, aim = cooling.cool(best, longest, done, manner)
            steps = pace.next_steps()
            anneal(costs, near, tours, best, fittest, rng, steps, temperature, aim, habits)
            pace.took(steps)
            if best.cost.max() < longest:
                recorder.incumbent(to_routes(best))
        return recorder.result(pace.stopped_by, iterations=pace.iterations)


def _first_tours(
    instance: Instance, costs: Costs, near: Neighbours, rng: NDArray[np.uint64], start: Routes | None
) -> Tours:
    if start is not None:
        return from_routes(costs, start)
    tours = empty_tours(instance.n_tasks, instance.n_depots)
    construct(costs, near, tours, rng)
    return tours
