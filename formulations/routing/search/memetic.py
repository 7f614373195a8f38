"""`memetic`: annealed ruin-and-recreate with moves of long segments, inside a population with route crossover.

How it was chosen: several annealings and their children beat one long annealing, the more so the smaller the instance,
as long as each is deep enough; long tours need more depth. So the size of the population follows from the limit:
depth · n² / m steps go into one annealing, and where the limit allows fewer than three, all of it goes into one.
Where costs change with time the loop is that of `formulations.routing.clocked`, in one thread.
Endurance is kept by scaled costs (endurance.py); it may find no routes that can be flown, which proves nothing.
The package's docstring says what is where.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import repeat
from statistics import fmean
from typing import Any, ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.annealing import anneal
from formulations.routing.search.budget import Budget, Teller
from formulations.routing.search.chained_search import ChainedSearch
from formulations.routing.search.costs import Costs, search_costs, warm_up, warm_up_by_clock
from formulations.routing.search.decomposition import merge
from formulations.routing.search.edge_assembly import EdgeAssembly
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.energy import Objective, p_norm
from formulations.routing.search.lineage import Family
from formulations.routing.search.numbering import numbering
from formulations.routing.search.packing import Packing
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.parting import PartingParameters
from formulations.routing.search.perturbation import perturb
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded, uniform
from formulations.routing.search.recreate import GUIDES
from formulations.routing.search.stages import next_stages, share_best
from formulations.routing.search.states import searching as states
from formulations.routing.search.tours import duplicate, from_routes
from formulations.routing.search.trimming import TrimmingParameters
from formulations.routing.solver import Result
from instances import InputError, Instance, Routes
from instances.frozen import guiding

_DEFAULT = SearchParameters()


@dataclass(frozen=True)
class Memetic(RecordedSolver):
    """The state-of-the-art min-max search.

    removals : tasks taken out by one ruin, at most (1 to 20); of short tours from several depots five thirds as many,
        up to 20.
    strings : share of ruins that take strings of consecutive tasks; the others take nearest neighbours (0 to 1).
    cuts : share of steps that cut and rejoin long segments of one or two tours (0 to 1).
    powers : how many of the guides Σ C_k^p, p = 1, 2, 5, 12, 30, ∞, the recreation draws from; 1 is the total (1 to
        6).
    focuses : share of the population's later stages that search the longest tour and a few others alone, where all
        UAVs fly from one site (0 to 1).
    reliefs : share of the remaining ones that send a UAV elsewhere, the others are crossovers, where both bring what is
        new as often; else they are drawn in proportion to that (0 to 1).
    kicks : of each tour's order at the end of a stage, for each of its tasks; 0 leaves orders to the annealing (0
        to 1000).
    depth : a founder's annealing takes depth · n² / m steps, with several depots a quarter of them, no fewer than
        10 000 to 25 000, doubled at each new start (at least 0.01).
    decoupled : where nodes have several states, take the routes of straight legs with the best states put in
        afterwards: what a plan that ignores them comes to (true or false).
    static : where costs change with time, plan for those of take-off as if they stayed: what a plan that ignores the
        clock comes to (true or false).

    What else could be set is in `parameters`, of the class.
    """

    removals: int = _DEFAULT.annealing.removals
    strings: float = _DEFAULT.annealing.strings
    cuts: float = _DEFAULT.annealing.moves
    powers: int = _DEFAULT.annealing.guides
    focuses: float = _DEFAULT.population.decompositions
    reliefs: float = _DEFAULT.population.perturbations
    kicks: float = _DEFAULT.population.kicks
    depth: float = _DEFAULT.population.depth
    decoupled: bool = False
    static: bool = False

    proves: ClassVar[bool] = False
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance", "time", "states", "window", "metric"})
    parameters: ClassVar[SearchParameters] = _DEFAULT

    def __post_init__(self) -> None:
        ranges: dict[str, tuple[float, float]] = dict.fromkeys(("strings", "cuts", "focuses", "reliefs"), (0, 1))
        ranges |= {"removals": (1, self.parameters.neighbourhood.tasks), "powers": (1, len(GUIDES))}
        ranges |= {"kicks": (0, 1000), "depth": (0.01, float("inf"))}
        for name, (low, high) in ranges.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
                raise InputError(f"memetic: {name} must lie in {low}..{high}, got {value!r}")

    def accepts(self, instance: Instance) -> str | None:
        """Refuse states together with time or limited endurance."""
        others = instance.axes & {"time", "endurance"} if "states" in instance.axes else frozenset()
        return f"memetic takes states without {' or '.join(sorted(others))}" if others else None

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (or load them from numba's cache)."""
        if "states" in instance.axes:
            self.solve(states.warm_up(instance), limits=Limits(time=3600.0, iterations=100))
            instance = states.straight_legs(instance)
        if "time" in instance.axes:
            self.prepare(guiding(instance))
            clocked = warm_up_by_clock(instance, 6, 3)
            Memetic(depth=0.01).solve(clocked, limits=Limits(time=3600.0, iterations=200))
            return
        small = warm_up(instance, 6, 3)
        Memetic(depth=0.01).solve(small, limits=Limits(time=3600.0, iterations=200))
        population = self._populations(small, numbering(small, 0, math.inf).costs(small), 1, 0)[0]
        uniform(population.rng)
        next_stages([population], 1.0)
        population.family.members = [population.best, population.best]
        population.child()
        population.perturbed()
        part, parameters = population.decomposed(), population.parameters
        recreation = parameters.annealing.recreate
        perturb(part.data, part.tours, parameters.perturbation, recreation, population.rng)
        merge(population.data.costs, part.nodes, part.best, population.best)
        Packing().leaves_little(0.0, population.data)
        population.trimmed(duplicate(population.best), np.zeros(3, np.bool_), TrimmingParameters())
        if instance.by_metric is None:
            _prepare_parting(population)
        chain = parameters.chain
        if instance.by_metric is None and parameters.handover.ever(search_costs(instance), instance.n_tasks):
            ChainedSearch(population.data, population.best, chain, population.rng).advance(0.0, 1)
            how = parameters.assembly._replace(kicks=0.0, fewest=2)
            assembly = EdgeAssembly(population.data, chain, how, population.rng)
            for done in (0.0, how.made, how.made, 1.0, 1.0, 1.0):  # a ring, two pairs crossed, s falls twice, kicks
                assembly.advance(done, 1)

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Search until a limit; one annealing step is one iteration, counted in one of the `threads` threads."""
        if "states" in recorder.instance.axes and self.decoupled:
            return states.search_decoupled(recorder, seed, self._routes)
        if "states" in recorder.instance.axes:
            return states.search_states(recorder, seed, self._routes, states.StateSearch())
        if "time" in recorder.instance.axes and self.static:
            return self._planned_at_take_off(recorder, seed)
        if "time" in recorder.instance.axes:
            from formulations.routing.clocked.searches import memetic_by_clock  # here: others need no such kernels

            return memetic_by_clock(recorder, self, self._with_options(), seed)
        threads = recorder.limits.threads
        instance = recorder.instance
        limit = recorder.limits.time if recorder.limits.iterations is None else math.inf  # so that runs are repeatable
        numbers = numbering(instance, self.parameters.renumbered, limit)
        start = None if recorder.routes is None else numbers.of_search(recorder.routes)
        populations = self._populations(instance, numbers.costs(instance), threads, seed, start, recorder.objective)
        budget, level, telling = Budget(recorder, self.parameters.budget), self.parameters.budget.level, math.inf
        if instance.by_metric is not None:
            level, telling = max(level, instance.n_tasks // 10), self.parameters.budget.telling
        teller = Teller(recorder, telling, numbers)
        planned = False
        with ThreadPoolExecutor(threads) as pool:
            run: Callable[..., Iterator[Any]] = pool.map if threads > 1 else map
            while True:
                # nothing is shorter than tours that cost nothing, and what is done to the longest needs tasks on it
                stopped_by = budget.stopped_by or ("" if populations[0].incumbent > 0.0 else "finished")
                if any(population.improved for population in populations) and (teller.has_time or stopped_by):
                    for population in populations:
                        population.improved = False
                    teller.tell(populations[0].best)
                if stopped_by:
                    break
                now, step = budget.fraction, 1.0 / budget.total_steps
                if not planned and budget.has_probed:
                    planned = True
                    for population in populations:
                        population.plan(step)
                next_stages(populations, now, run)
                left = math.ceil((min(population.end for population in populations) - now) / step)
                window = budget.next_window(min(self.parameters.budget.levels * level, max(left, level)), level)
                taken = list(run(Population.run, populations, repeat(now), repeat(window), repeat(step)))
                share_best(populations)
                budget.took(fmean(taken))
        return recorder.result(stopped_by, iterations=budget.iterations, stages=populations[0].family.stages)

    def _planned_at_take_off(self, recorder: Recorder, seed: int) -> Result:
        """Return the routes found for the costs of take-off; by the clock they may be past endurance."""
        planned = self.solve(guiding(recorder.instance), limits=recorder.limits, seed=seed)
        if planned.routes is not None:
            recorder.incumbent(planned.routes)
        return recorder.result(planned.stopped_by, **planned.statistics)

    def _routes(self, instance: Instance, limits: Limits, seed: int) -> Routes | None:
        """Return the routes found of an instance without states."""
        return self.solve(instance, limits=limits, seed=seed).routes

    def _populations(
        self,
        instance: Instance,
        costs: Costs,
        threads: int,
        seed: int,
        start: Routes | None = None,
        objective: float = math.inf,
    ) -> list[Population]:
        """Return a population for each thread, of one family; `objective` [s] is that of the start.

        costs, start: by the numbers of the search (numbering.py).
        """
        parameters = self._with_options()
        if instance.by_metric is not None:
            parameters = replace(parameters, schedule=parameters.schedule.of_many(instance.n_depots))
        endurance = Endurance(instance, costs)
        endurance.refer(min(endurance.most, objective))
        data = problem_data(endurance.costs, instance.n_tasks, parameters.neighbourhood)
        family = Family(threads)
        starts = [None if start is None else from_routes(endurance.costs, start), *[None] * (threads - 1)]
        return [
            Population(data, endurance, parameters, seeded(seed, i), tours, family) for i, tours in enumerate(starts)
        ]

    def _with_options(self) -> SearchParameters:
        """Return the parameters with those that are options as they were set; numbers have the types kernels know."""
        annealing = self.parameters.annealing._replace(
            removals=self.removals, strings=float(self.strings), moves=float(self.cuts), guides=self.powers
        )
        shares = replace(
            self.parameters.population, decompositions=float(self.focuses), perturbations=float(self.reliefs)
        )
        population = replace(shares, kicks=float(self.kicks), depth=self.depth)
        return replace(self.parameters, annealing=annealing, population=population)


def _prepare_parting(population: Population) -> None:
    """Compile the kernels of costs by which UAVs differ, with which tasks are parted (parting.py)."""
    newcomer = population.parted(duplicate(population.best), PartingParameters())
    assert newcomer is not None
    assert newcomer.subproblem is not None
    objective, annealing = Objective(p_norm(2), 0.5), population.annealing
    best, fittest = duplicate(newcomer.tours), duplicate(newcomer.tours)
    data, tours = newcomer.subproblem.data, newcomer.tours
    anneal(data, tours, best, fittest, population.rng, 1, 1.0, objective, population.measure, annealing)
