"""Population: a few good solutions, renewed by annealed founders and annealed offspring.

A stage anneals one newcomer. The first stages make founders from scratch; later ones perturb a member
(perturbation.py) or cross two (crossover.py), whichever brought what is new more often (lineage.py), or, at
one site, search some tours of one alone (decomposition.py) or reheat it (strategy.py), and where many UAVs fly anneal
under a cap or search the tours beside a trimmed one (packing.py); where few UAVs fly long tours from several depots
most of the time goes to long founders.
At the end of a stage every tour of the newcomer gets a better order (local_search.py), and it is taken in (lineage.py).
The longer nothing is new, the more annealings part tasks (parting.py), or are fine or compact (schedule.py), and at one
site the more solutions from scratch are quenched (strategy.py).
Each thread has its own newcomer, and all have the same members (lineage.py) and best tours (stages.py).
Where tours from one site are long handover.py says when the population ends: few UAVs have one founder, and then edge
assembly (edge_assembly.py), which a chained local search ends (chained_search.py); that alone follows where more fly,
in turn with searches of parts where it does not begin hot (part_search.py), and after tours have grown anew where the
farthest task decides (growth.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from formulations.routing.search.annealing import anneal
from formulations.routing.search.budget import Window
from formulations.routing.search.chained_search import ChainedSearch
from formulations.routing.search.crossover import crossover
from formulations.routing.search.decomposition import Subproblem, around, merge, subproblem
from formulations.routing.search.edge_assembly import EdgeAssembly
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.energy import fitness
from formulations.routing.search.growth import Growth
from formulations.routing.search.lineage import Family, Lineage, Successes
from formulations.routing.search.local_search import intensify
from formulations.routing.search.packing import CappedSchedule, Packing
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.part_search import PartSearch
from formulations.routing.search.parting import PartingParameters, part_two
from formulations.routing.search.perturbation import perturb
from formulations.routing.search.problem_data import ProblemData, grain_of
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import construct
from formulations.routing.search.schedule import Schedule
from formulations.routing.search.tours import Tours, duplicate, empty_tours
from formulations.routing.search.trimming import TrimmingParameters, trim
from instances.arrays import Bools


@dataclass(frozen=True)
class Newcomer:
    """What a stage anneals: tours, of a subproblem or the whole, from a first temperature on, and the stage's length.

    first: in mean legs; length: as a fraction of the limit; successes: where it is to be noted whether it was new, with
    a weight of `recent`; aside (m,): which tours were trimmed and are not searched.
    """

    tours: Tours
    first: float
    length: float
    subproblem: Subproblem | None = None
    successes: Successes | None = None
    recent: float = 0.0
    aside: Bools | None = None


class Population(Lineage):
    """The newcomer that one thread anneals, and the best tours so far; times are fractions of the limit.

    chains: whether a chained search will take over.
    """

    def __init__(
        self,
        data: ProblemData,
        endurance: Endurance,
        parameters: SearchParameters,
        rng: Rng,
        start: Tours | None,
        family: Family | None = None,
    ) -> None:
        super().__init__(data, parameters, rng, Family() if family is None else family)
        self.endurance, self._steps = endurance, self.annealing
        self.grain = 0.0 if endurance.limited else grain_of(data.costs)
        schedule = parameters.schedule
        self._newcomer = Newcomer(start if start is not None else self.constructed(), schedule.founder, 1.0)
        self._schedule: Schedule | CappedSchedule = Schedule(schedule.founder, schedule.softness[0], schedule.final)
        self._fittest = duplicate(self._newcomer.tours)
        self.best = duplicate(self._newcomer.tours)
        self.improved = True
        self._long = parameters.handover.assembles(data.costs, data.size[0])
        self._soon, self.chains = self._long, False
        self._chained: ChainedSearch | EdgeAssembly | Growth | PartSearch | None = None

    def plan(self, step: float) -> None:
        """Say which part of the limit a step takes, and when chained search begins; the only founder is then short."""
        super().plan(step)
        how, family = self.parameters.handover, self.family
        self.chains = family.founder >= how.founder and how.chains(self.data.costs, self.data.size[0])
        alone = self.chains and family.founder > family.longest and how.suits_hot(self.data)
        self._soon = (self._long or alone) and how.fits(self.data, step, how.begin)
        if self._soon:
            self.end = self._begin + how.begin

    def run(self, now: float, window: Window, step: float) -> int:
        """Advance while the window lasts; return the steps taken, each so much of the limit."""
        done = 0
        while done == 0 or (done < window.steps and not window.over and not self._making):
            steps = min(window.level, window.steps - done)
            self.advance(now + done * step, steps)
            done += steps
        return done

    @property
    def _making(self) -> bool:
        """Whether the next advance takes far longer than its steps say, so that limits are to be looked at before."""
        return isinstance(self._chained, EdgeAssembly) and self._chained.making

    def advance(self, now: float, steps: int) -> None:
        """Anneal the newcomer by `steps` steps at the temperature that belongs to `now`, or kick so often."""
        if self._chained is not None:
            if self._chained.advance(self._done(now), steps) and self._chained.longest < self.incumbent:
                self.best, self.improved = self._chained.best(), True
            return
        tours, part = self._newcomer.tours, self._newcomer.subproblem
        data, best = (self.data, self.best) if part is None else (part.data, part.best)
        incumbent, fittest = self.incumbent, self._fittest
        temperature, objective = self._schedule.at(
            self._done(now), fittest, incumbent, self.parameters.schedule, self.grain
        )
        anneal(data, tours, best, fittest, self.rng, steps, temperature, objective, self.measure, self._steps)
        self.improved = self.improved or self.best.cost.max() < incumbent

    def grow_up(self) -> None:
        """End the stage: what the newcomer came to is then whole and its tours' orders are better."""
        if self._soon or self._chained is not None:
            return
        grown = self._grown()
        if self.parameters.population.kicks > 0:
            intensify(self.data.costs, grown, self.rng, self.parameters.population.kicks, self.parameters.local_search)
            self._remember(grown)
        self._newcomer, self._fittest = replace(self._newcomer, tours=grown, subproblem=None), grown

    def take_in(self) -> None:
        """Take the newcomer in that has grown up."""
        if self._soon or self._chained is not None:
            self.family.stages += 1
            return
        new = self._take_in(self._fittest)
        if self._newcomer.successes is not None:
            self._newcomer.successes.note(new, self._newcomer.recent)

    def begin(self, now: float, others: int = 0) -> None:
        """Begin the next stage; `others` are under way in other threads."""
        if self._chained is not None or self._hands_over(now):
            self._hand_over(now)
            return
        drawn = self._long_founder(now, others) or self._packed(others) or self._quenched(others)
        self._newcomer, self._schedule = drawn or self._parted(others) or self._drawn(others)
        self._steps = self.annealing._replace(strings=self._schedule.strings * self.annealing.strings)
        self._fittest = duplicate(self._newcomer.tours)
        self._begin, self.end = now, self._fitting(self._newcomer.length, now)

    def _long_founder(self, now: float, others: int) -> tuple[Newcomer, Schedule] | None:
        """Return a long founder and its schedule where the time has come for one, after the usual founders."""
        how, family = self.strategy.long, self.family
        if how is None or not how.suits(self.data) or self._founding(others):
            return None
        length = min(how.longest, how.depth * self.data.crowding * self._step_length)
        if now + length > 1.0 or family.in_long > how.share * family.threads * now:
            return None
        family.in_long += length
        softness = how.softness[below(self.rng, len(how.softness))]
        schedule = Schedule(how.first, softness, self.parameters.schedule.final)
        return Newcomer(self.constructed(), how.first, length), schedule

    @property
    def packing(self) -> Packing | None:
        """What the strategy does where many UAVs are packed, while there is reason and time to."""
        how = self.strategy.packing
        if how is None or how.depth * self.family.founder > how.longest:
            return None
        return how if how.leaves_little(self.incumbent, self.data) else None

    def _packed(self, others: int) -> tuple[Newcomer, Schedule | CappedSchedule] | None:
        """Return a newcomer that is trimmed or capped and its schedule, where the strategy has such (packing.py)."""
        how, before, family = self.packing, self._newcomer, self.family
        if how is None or self._founding(others):
            return None
        trimming = how.trimming
        if before.aside is not None and before.aside.sum() < trimming.most:
            over = float(before.tours.cost.max()) / self.incumbent - 1.0
            if self.parameters.population.same < over < trimming.near:
                return self.trimmed(duplicate(before.tours), before.aside.copy(), trimming)
        if uniform(self.rng) < trimming.share:
            tours = duplicate(self.best) if uniform(self.rng) < trimming.best else self._member()
            return self.trimmed(tours, np.zeros(self.data.size[1], np.bool_), trimming)
        if uniform(self.rng) < how.reheated:
            return self._reheated()
        if uniform(self.rng) < how.share_of_founders(family.packed.rate):
            length = how.depth * family.founder
            newcomer = replace(self._founder(), length=length, successes=family.packed, recent=how.recent)
            return newcomer, how.draw_schedule(from_scratch=True, rng=self.rng)
        if uniform(self.rng) < how.others:
            newcomer = self._renewed()
            from_scratch = newcomer.first >= self.parameters.schedule.founder
            return newcomer, how.draw_schedule(from_scratch=from_scratch, rng=self.rng)
        return None

    def trimmed(self, tours: Tours, aside: Bools, how: TrimmingParameters) -> tuple[Newcomer, Schedule]:
        """Return the tours beside the longest, which is trimmed and set aside with those that are, and a schedule."""
        trim(self.data.costs, self.data.near, tours, aside, (1.0 - how.shorter) * self.incumbent, how, self.rng)
        part = subproblem(self.data, tours, np.flatnonzero(~aside).astype(np.int32), self.parameters.neighbourhood)
        length = how.depth * self.data.crowding * self._step_length
        final = self.strategy.fine if uniform(self.rng) < self.strategy.fine_share else self.parameters.schedule.final
        schedule = Schedule(how.first, self.parameters.schedule.draw_softness(self.rng), final)
        return Newcomer(duplicate(part.tours), how.first, length, part, aside=aside), schedule

    def _quenched(self, others: int) -> tuple[Newcomer, Schedule] | None:
        """Return a newcomer that is quenched and its schedule, if that is drawn."""
        how, family, fine = self.strategy.quench, self.family, self.strategy.fine_first
        if how is None or self._founding(others) or family.founder > how.founder:
            return None
        if uniform(self.rng) >= how.share * min(1.0, self._staleness):
            return None
        schedule = Schedule(fine, self.parameters.schedule.draw_softness(self.rng), self.strategy.fine)
        return Newcomer(self.constructed(), fine, how.length * family.founder), schedule

    def _parted(self, others: int) -> tuple[Newcomer, Schedule] | None:
        """Return a newcomer with two tasks of its longest tour parted and its schedule, if that is drawn."""
        how, parameters = self.strategy.parting, self.parameters.schedule
        if how is None or self._founding(others):
            return None
        if uniform(self.rng) >= how.share * min(1.0, how.early + self._staleness):
            return None
        newcomer = self.parted(duplicate(self.best) if uniform(self.rng) < how.best else self._member(), how)
        if newcomer is None:
            return None
        return newcomer, self.strategy.draw_schedule(newcomer.first, self._staleness, parameters, self.rng)

    def parted(self, whole: Tours, how: PartingParameters) -> Newcomer | None:
        """Return `whole` with two tasks of its longest tour parted, None where that has not two."""
        part = part_two(self.data, whole, how, self.rng)
        if part is None:
            return None
        length = self.parameters.population.child * self.family.founder
        return Newcomer(duplicate(part.best), self.parameters.schedule.child, length, part)

    def _drawn(self, others: int) -> tuple[Newcomer, Schedule]:
        """Return the next newcomer and its schedule; `others` are under way in other threads."""
        staleness, founder = self._staleness, None
        if self.strategy.reheats(staleness, self.rng):
            newcomer, schedule = self._reheated()
        else:
            founder = self._founder() if self._founding(others) else None
            newcomer = founder or self._renewed()
            parameters = self.parameters.schedule
            schedule = self.strategy.draw_schedule(newcomer.first, staleness, parameters, self.rng)
        if founder is None and uniform(self.rng) < self.strategy.compact * min(1.0, staleness):
            schedule = replace(schedule, compact=True)
        return newcomer, schedule

    def _hands_over(self, now: float) -> bool:
        """Return whether it is time for an edge assembly or a chained search."""
        how = self.parameters.handover
        due = self.chains and now >= how.begins(self.incumbent, self.data)
        return self._soon or (due and how.fits(self.data, self._step_length, now))

    def _hand_over(self, now: float) -> None:
        """Begin edge assembly where few UAVs fly, else a chained search from the best, and parts and it in turn."""
        parameters, self._begin, self.end = self.parameters, now, 1.0
        how, chain, (n, m) = parameters.handover, parameters.chain, self.data.size
        if isinstance(self._chained, ChainedSearch):
            self.end = how.until(now, parts=True)
            self._chained = PartSearch(self, parameters.parts)
        elif self._long:
            self._chained = EdgeAssembly(self.data, chain, parameters.assembly, self.rng)
        elif self._chained is None and (self._soon or how.is_hot(self.incumbent, self.data)):
            chain = chain._replace(first=max(chain.first, how.heat * m * n**0.5), last=how.last)
            self._chained = ChainedSearch(self.data, self.best, chain, self.rng)
        elif self._chained is None and how.grows(self.incumbent, self.data):
            self.end = now + how.grown * (1.0 - now)
            self._chained = Growth(self.data, parameters.growth, self.annealing, parameters.neighbourhood, self.rng)
        else:
            tours = self._chained.grown() if isinstance(self._chained, Growth) else self.best
            # neighbours of a part take as long as candidate legs, at most
            if parameters.parts.suit(self.data) and how.fits(self.data, self._step_length, how.turns[-2]):
                self.end = how.until(now, parts=False)
            self._chained = ChainedSearch(self.data, tours, chain._replace(first=how.reheated), self.rng)

    def _grown(self) -> Tours:
        """Return the newcomer as its stage left it; a subproblem's tours are merged where they are fitter."""
        part = self._newcomer.subproblem
        if part is None:
            return self._fittest
        measure = self.measure
        for found in (part.best, self._fittest):
            if fitness(found.cost, measure) < fitness(part.tours.cost, measure):
                merge(self.data.costs, part.nodes, found, part.whole)
                self._remember(part.whole)
        return part.whole

    def _remember(self, tours: Tours) -> None:
        """Keep a copy of tours whose longest is shorter than that of the best."""
        if tours.cost.max() < self.incumbent:
            self.improved = True
            self.best = duplicate(tours)

    @property
    def priced(self) -> tuple[Tours, ...]:
        """The tours under way at the costs of the whole."""
        part = self._newcomer.subproblem
        return (self.best, part.whole) if part is not None else (self.best, self._newcomer.tours, self._fittest)

    def _founder(self) -> Newcomer:
        return Newcomer(self.constructed(), self.parameters.schedule.founder, self.family.founder)

    def _renewed(self) -> Newcomer:
        """Return a newcomer made from members."""
        parameters, schedule = self.parameters.population, self.parameters.schedule
        focused = self.strategy.focused and self.data.size[1] > 2
        if focused and uniform(self.rng) < parameters.decompositions:
            part, how = self.decomposed(), self.parameters.decomposition
            tours, length = duplicate(part.tours), self._step_length * max(how.least, how.depth * part.data.crowding)
            if uniform(self.rng) < how.perturbed:
                recreate = self.parameters.annealing.recreate
                perturb(part.data, tours, self.parameters.perturbation, recreate, self.rng)
                return Newcomer(tours, schedule.perturbed, parameters.child * length, part)
            return Newcomer(tours, schedule.founder, length, part)
        family = self.family
        if uniform(self.rng) < family.perturbed.share(family.children, parameters.perturbations):
            length = parameters.perturbed * family.founder
            return Newcomer(
                self.perturbed(), schedule.perturbed, length, successes=family.perturbed, recent=parameters.recent
            )
        length = parameters.child * family.founder
        return Newcomer(self.child(), schedule.child, length, successes=family.children, recent=parameters.recent)

    def _reheated(self) -> tuple[Newcomer, Schedule]:
        """Return a copy of the fitter of two random members and the schedule of a reheating."""
        reheating, measure = self.strategy.reheating, self.measure
        assert reheating is not None
        softness = self.parameters.schedule.draw_softness(self.rng)
        members = self.family.members
        a, b = members[below(self.rng, len(members))], members[below(self.rng, len(members))]
        fitter = a if fitness(a.cost, measure) <= fitness(b.cost, measure) else b
        newcomer = Newcomer(duplicate(fitter), reheating.first, reheating.steps * self._step_length)
        return newcomer, Schedule(reheating.first, softness, self.strategy.fine)

    def decomposed(self) -> Subproblem:
        """Return some tours of a random member, to be searched alone."""
        how, whole = self.parameters.decomposition, self._member()
        wanted = 2 + below(self.rng, min(how.most, self.data.size[1] - 1) - 1)
        uavs = around(self.data.near, whole, int(whole.cost.argmax()), wanted, how, self.rng)
        return subproblem(self.data, whole, uavs, self.parameters.neighbourhood)

    def of_part(self, part: Subproblem) -> Population:
        """Return a population of some tours, to which nothing is handed over."""
        parameters = replace(self.parameters, handover=replace(self.parameters.handover, uavs=0, founder=np.inf))
        return Population(part.data, self.endurance, parameters, self.rng, duplicate(part.tours))

    def perturbed(self) -> Tours:
        """Return a copy of a random member, one of its UAVs relocated."""
        tours = self._member()
        perturb(self.data, tours, self.parameters.perturbation, self.parameters.annealing.recreate, self.rng)
        return tours

    def child(self) -> Tours:
        """Return the child of two random members."""
        child, other = self._parents()
        crossover(self.data, child, other, self.strategy.regions, self.parameters.annealing.recreate, self.rng)
        return child

    def _member(self) -> Tours:
        """Return a copy of a random member."""
        return duplicate(self.family.members[below(self.rng, len(self.family.members))])

    def constructed(self) -> Tours:
        """Return tours from scratch."""
        tours = empty_tours(*self.data.size)
        construct(self.data, tours, self.parameters.annealing.recreate, self.rng)
        return tours
