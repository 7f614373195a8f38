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

from formulations.recorder import Recorder
from formulations.routing.search.annealing import anneal
from formulations.routing.search.neighbours import Neighbours, neighbours
from formulations.routing.search.pace import Pace
from formulations.routing.search.randomness import seeded
from formulations.routing.search.recreate import construct
from formulations.routing.search.tours import Tours, copy_tours, empty_tours, from_routes, to_routes
from formulations.solver import Limits, Observer, Result, Solver, ignore
from instances import InputError, Instance, Routes

NEAR_TASKS = 20
NEAR_DEPOTS = 128


def near_nodes(instance: Instance) -> Neighbours:
    """Return the neighbour lists of `instance`."""
    return neighbours(instance.cost, instance.n_tasks, NEAR_TASKS, NEAR_DEPOTS)


@dataclass(frozen=True)
class RuinRecreate(Solver):
    """Annealed ruin-and-recreate.

    removals : tasks taken out at once, at most.
    hot, cold : first and last temperature, as shares of the longest tour.
    even, peaked : first and last share ε of the mean tour in the energy.
    """

    removals: int = 12
    hot: float = 1e-2
    cold: float = 1e-5
    even: float = 0.5
    peaked: float = 0.02

    proves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        if not 1 <= self.removals <= NEAR_TASKS:
            raise InputError(f"ruin-recreate: removals must lie in 1..{NEAR_TASKS}, got {self.removals}")
        for high, low in (("hot", "cold"), ("even", "peaked")):
            if not getattr(self, high) >= getattr(self, low) > 0:
                raise InputError(
                    f"ruin-recreate: {high} ≥ {low} > 0 is needed, got {getattr(self, high)} and {getattr(self, low)}"
                )

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
        near = near_nodes(instance)
        rng = seeded(seed)
        tours = _first_tours(instance, near, rng, start)
        best = empty_tours(instance.n_tasks, instance.n_depots)
        copy_tours(tours, best)
        recorder.incumbent(to_routes(best))
        pace = Pace(recorder)
        while not pace.stopped_by:
            done, longest = pace.fraction, best.cost.max()
            temperature = longest * self.hot * (self.cold / self.hot) ** done
            evenness = self.even * (self.peaked / self.even) ** done
            steps = pace.next_steps()
            anneal(instance.cost, near, tours, best, rng, steps, temperature, evenness, self.removals)
            pace.took(steps)
            if best.cost.max() < longest:
                recorder.incumbent(to_routes(best))
        return recorder.result(pace.stopped_by, iterations=pace.iterations)


def _first_tours(instance: Instance, near: Neighbours, rng: NDArray[np.uint64], start: Routes | None) -> Tours:
    if start is not None:
        return from_routes(instance.cost, start)
    tours = empty_tours(instance.n_tasks, instance.n_depots)
    construct(instance.cost, near, tours, rng)
    return tours
