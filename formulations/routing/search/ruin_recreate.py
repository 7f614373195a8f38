"""`ruin-recreate`: one annealed trajectory of ruin and recreate, the honest intermediate baseline of `memetic`.

Each step removes up to `removals` related tasks (ruin.py), inserts them where they raise a p-norm of the tours least
(recreate.py) and accepts the result by simulated annealing (annealing.py, energy.py, schedule.py) over the given limit.
Endurance is kept by scaled costs (endurance.py); it may find no routes that can be flown, which proves nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from formulations.limits import Limits
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.annealing import AnnealingParameters, anneal
from formulations.routing.search.budget import Budget, BudgetParameters
from formulations.routing.search.costs import search_costs, warm_up, warm_up_by_clock
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.recreate import construct
from formulations.routing.search.schedule import Schedule, ScheduleParameters
from formulations.routing.search.strategy import SEVERAL_DEPOTS
from formulations.routing.search.tours import duplicate, empty_tours, from_routes, reprice, to_routes
from formulations.routing.solver import Result
from instances import InputError, Instance

_NEAREST = NeighbourhoodParameters()


@dataclass(frozen=True)
class RuinRecreate(RecordedSolver):
    """Annealed ruin-and-recreate.

    removals : tasks taken out by one ruin, at most (1 to 20).
    """

    removals: int = 12

    proves: ClassVar[bool] = False
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance", "time", "window", "metric"})

    def __post_init__(self) -> None:
        if not 1 <= self.removals <= _NEAREST.tasks:
            raise InputError(f"ruin-recreate: removals must lie in 1..{_NEAREST.tasks}, got {self.removals}")

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (or load them from numba's cache)."""
        if "time" in instance.axes:
            self.solve(warm_up_by_clock(instance, 2, 1), limits=Limits(time=3600.0, iterations=100))
            return
        self.solve(warm_up(instance, 2, 1), limits=Limits(time=3600.0, iterations=1))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Anneal until a limit; one step is one iteration."""
        instance = recorder.instance
        if "time" in instance.axes:
            from formulations.routing.clocked.searches import (
                ruin_recreate_by_clock,
            )  # here: others need no such kernels

            return ruin_recreate_by_clock(recorder, self.removals, seed)
        endurance = Endurance(instance, search_costs(instance))
        endurance.refer(min(endurance.most, recorder.objective))
        data = problem_data(endurance.costs, instance.n_tasks, _NEAREST)
        how = AnnealingParameters(removals=self.removals, moves=0.0)
        rng = seeded(seed)
        if recorder.routes is not None:
            tours = from_routes(data.costs, recorder.routes)
        else:
            tours = empty_tours(instance.n_tasks, instance.n_depots)
            construct(data, tours, how.recreate, rng)
        best, fittest = duplicate(tours), duplicate(tours)
        recorder.incumbent(to_routes(best))
        parameters, measure = ScheduleParameters(), SEVERAL_DEPOTS.measure
        schedule = Schedule(parameters.founder, parameters.softness[0], parameters.final)
        budget = Budget(recorder, BudgetParameters())
        while not budget.stopped_by:
            if endurance.follow(best.cost):
                for each in (tours, best, fittest):
                    reprice(data.costs, each)
            longest = float(best.cost.max())
            temperature, objective = schedule.at(budget.fraction, best, longest, parameters)
            steps = budget.next_steps()
            anneal(data, tours, best, fittest, rng, steps, temperature, objective, measure, how)
            budget.took(steps)
            if best.cost.max() < longest:
                recorder.incumbent(to_routes(best))
        return recorder.result(budget.stopped_by, iterations=budget.iterations)
