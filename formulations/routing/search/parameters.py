"""Parameters of the memetic search, all in one object; those of one idea stand beside its code.

They were tuned by hand on the instances that tests/benchmarks/search.py names (TUNED_ON), at its limits of 10 to 45 s,
and confirmed on the others there. A field with a figure was measured by itself (its `ablation`); one without was
settled together with others and is a sensible value rather than an optimum.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from formulations.routing.search.annealing import AnnealingParameters
from formulations.routing.search.budget import BudgetParameters
from formulations.routing.search.chain_moves import ChainParameters
from formulations.routing.search.decomposition import DecompositionParameters
from formulations.routing.search.edge_assembly import AssemblyParameters
from formulations.routing.search.growth import GrowthParameters
from formulations.routing.search.handover import HandoverParameters
from formulations.routing.search.local_search import LocalSearchParameters
from formulations.routing.search.part_search import PartParameters
from formulations.routing.search.perturbation import PerturbationParameters
from formulations.routing.search.problem_data import NeighbourhoodParameters, ProblemData
from formulations.routing.search.schedule import ScheduleParameters
from formulations.routing.search.strategy import ONE_SITE, SEVERAL_DEPOTS, Strategy


@dataclass(frozen=True)
class PopulationParameters:
    """Stages that renew members; one long annealing instead of a population gives 0.28 and 0.14.

    Figures: mean gaps in % with several depots and with one (measured.md); with all of them 0.07 and 0.00.

    decompositions: share of the later stages that search a subproblem, where the strategy has such.
    perturbations: share of the remaining ones that perturb a member, where that is as often new as children of
    crossover, which the others are; where it is seldomer new the odds fall as much.
    recent: weight of the last one in the rates that say how often they are new; 0 leaves the share as it is.
    kicks: double bridges of each tour at the end of a stage, for each of its tasks.
    depth: a founder's annealing takes depth · n² / m steps, or the share of them that the strategy says: long tours
    need more than their number of tasks says.
    least, per_task, enough: steps of a founder at least, `least` or `per_task` for each task up to `enough`; small
    instances gain more by new starts.
    child, perturbed: lengths of the stages of a child and of a perturbed member, in those of a founder: both keep most
    of their tours.
    same: solutions whose fitness differs by less than this share of the incumbent's longest tour are equals; a total
    tells less (energy.py).
    """

    decompositions: float = 0.6
    perturbations: float = 0.5
    recent: float = 0.03
    kicks: float = 1.0
    depth: float = 2.0
    least: int = 10_000
    per_task: int = 250
    enough: int = 25_000
    child: float = 0.5
    perturbed: float = 0.15
    same: float = 2e-7


@dataclass(frozen=True)
class SearchParameters:
    """All of them; what differs between several depots and one site is a strategy.

    renumbered: tasks of which fewer keep the numbers of the instance: their costs fit the cache, or nearly.
    """

    renumbered: int = 1000
    neighbourhood: NeighbourhoodParameters = field(default_factory=NeighbourhoodParameters)
    annealing: AnnealingParameters = field(default_factory=AnnealingParameters)
    local_search: LocalSearchParameters = field(default_factory=LocalSearchParameters)
    decomposition: DecompositionParameters = field(default_factory=DecompositionParameters)
    perturbation: PerturbationParameters = field(default_factory=PerturbationParameters)
    schedule: ScheduleParameters = field(default_factory=ScheduleParameters)
    population: PopulationParameters = field(default_factory=PopulationParameters)
    handover: HandoverParameters = field(default_factory=HandoverParameters)
    chain: ChainParameters = field(default_factory=ChainParameters)
    assembly: AssemblyParameters = field(default_factory=AssemblyParameters)
    growth: GrowthParameters = field(default_factory=GrowthParameters)
    parts: PartParameters = field(default_factory=PartParameters)
    budget: BudgetParameters = field(default_factory=BudgetParameters)
    several_depots: Strategy = SEVERAL_DEPOTS
    one_site: Strategy = ONE_SITE

    def strategy(self, data: ProblemData) -> Strategy:
        """Return the strategy for an instance."""
        strategy = self.one_site if np.all(data.site == 0) else self.several_depots
        return strategy.on(data)

    def by(self, strategy: Strategy) -> SearchParameters:
        """Return these with ruins, perturbations and energies as a strategy on an instance has them."""
        short = strategy.short
        if short is None:
            return self
        removals = min(round(short.removals * self.annealing.removals), self.neighbourhood.tasks)
        even, peaked = self.schedule.mean_weight
        weight, perturbed = (short.mean * even, short.mean * peaked), short.perturbed * self.schedule.perturbed
        return replace(
            self,
            annealing=self.annealing._replace(removals=removals),
            perturbation=self.perturbation._replace(bounded=short.bounded),
            schedule=replace(self.schedule, mean_weight=weight, perturbed=perturbed),
        )
