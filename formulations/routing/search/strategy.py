"""Strategy: what a population decides differently for several depots and for one site.

With several depots it is a matter of which UAV serves which crowd of tasks: individuals are compared by a norm, which
sees all crowds whose tours are too long, and crossing whole tours of many quick founders that differ finds it; where
few UAVs fly long tours long annealings find it more often. At one site it is a matter of packing, and tours can be
packed tightly: individuals are compared by what exceeds the incumbent's longest tour, in which many tours nearly as
long as that are no fault. The basins of good packings lie near each other: fine annealings begin low there, some tours
are searched alone, and where nothing new is found many annealings are reheatings of a good individual, or weigh the
total (schedule.py). And a task may have to go to a tour that passes none of its nearest tasks: recreations look at all
of the granular neighbourhood. Where many UAVs fly, packing.py says what is done besides.

Where tours from several depots are short, a ruin that moves as many tasks as a tour has lets crowds change hands at
once, and the mean tour says nothing: most UAVs have time to spare, and it keeps tasks from going to them by detours.
Members must then differ in more, as UAVs with time to spare fly in any order. And a UAV that is sent elsewhere takes
over all the rest of a tour, whether or not it can fly that at first, and the annealing that follows is cool.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from formulations.routing.search.energy import Measure, excess, p_norm
from formulations.routing.search.packing import Packing
from formulations.routing.search.parting import PartingParameters
from formulations.routing.search.problem_data import NeighbourhoodParameters, ProblemData
from formulations.routing.search.randomness import Rng, uniform
from formulations.routing.search.recreate import RecreateParameters
from formulations.routing.search.schedule import FinalPhase, Schedule, ScheduleParameters


@dataclass(frozen=True)
class Reheating:
    """A good individual annealed as it is, from a temperature so low that it keeps most of itself.

    On rat99_5, 10 s, 17 of 24 runs reached the best known longest tour, before reheating 5 of 24.

    share: of the annealings, at most; first: temperature in mean legs; steps: how long.
    """

    share: float = 0.4
    first: float = 0.01
    steps: int = 40_000


@dataclass(frozen=True)
class Quench:
    """A solution from scratch annealed coldly and briefly: it ends in the first trap it comes to.

    Where a detour of the other tours is what shortens the longest, annealings lead away from it, for they see the
    total: on ftv64_5 they end at 470, and 465, whose total is 3 % greater, is found as one begins. Until then 23 s pass
    in the mean, and 8 s with quenches (14 and 18 runs; 0.1 and 0.02 of a founder's length 13 and 8 s). Half of the
    stages, whatever is new: 3 s (12 runs), but nine others, 12 s, gain nothing by it (measured.md).

    share: of the stages where nothing was new for long; length: in a founder's; founder: share of the limit that one
    takes, at most, for there to be any: it takes many of them.
    """

    share: float = 0.3
    length: float = 0.05
    founder: float = 0.05


@dataclass(frozen=True)
class LongFounder:
    """A founder annealed long, from a high temperature and under a soft norm: where few UAVs fly long tours.

    Which tasks such tours share is settled while an annealing is hot, and crossing quick founders settles it no more.
    md22 (250 tasks, 3 UAVs), 30 s: 0.31 % from each of three seeds, without 0.66 and twice 0.78 %. With more UAVs
    they are no gain (measured.md).

    share: of the time; uavs: of the fleet at most; tasks: of a tour, in the mean at least; depth: steps are
    depth · n² / m; longest: length as a fraction of the limit at most; first: temperature in mean legs; softness: one
    of these is drawn: a soft norm is near the total, which long tours must first be short in.
    """

    share: float = 2 / 3
    uavs: int = 3
    tasks: int = 50
    depth: float = 48.0
    longest: float = 1 / 6
    first: float = 1.5
    softness: tuple[float, float] = (50.0, 8.0)

    def suits(self, data: ProblemData) -> bool:
        """Return whether few UAVs fly long tours."""
        n, m = data.size
        return m <= self.uavs and n >= self.tasks * m


@dataclass(frozen=True)
class ShortTours:
    """What is different where tours from several depots are short: `tests/benchmarks/search.py short` measures it.

    tasks: of a tour, in the mean at most.
    removals: tasks removed by one ruin, in those of the option, but no more than the granular neighbourhood has.
    apart: in place of the strategy's.
    mean: weight of the mean tour in energies, in that of the schedule's parameters.
    perturbed: first temperature of a perturbed member, in that of the schedule's parameters.
    bounded: whether relocations are (perturbation.py).
    """

    tasks: int = 12
    removals: float = 5 / 3
    apart: float = 0.25
    mean: float = 0.01
    perturbed: float = 0.4
    bounded: bool = False

    def suits(self, data: ProblemData) -> bool:
        """Return whether tours are short."""
        n, m = data.size
        return n <= self.tasks * m


@dataclass(frozen=True)
class Strategy:
    """What a population decides for several depots, or for one site.

    With several depots, 10 s, two seeds, mean gaps on md8, md16, md17, md25, md26, md28, md34: −0.19 %; with a size of
    8 −0.05 %, without members apart −0.11 %, with 0.3 of the stages searches of some tours 0.16 %; all with an
    `apart` of 0.1. md4, 30 s, the same eight seeds: 0.23 % with 0.1, 0.19 % with 0.15, 0.36 % with 0.2.

    measure: of fitness; an excess is over the longest tour of the incumbent.
    width: near tasks whose two sides an annealing's recreation looks at. At one site 20 instead of 12 brought rat99_5,
    10 s, from 26 of 48 to 141 of 144 runs that reach the best known value.
    depots: near depots whose tours' ends it looks at, and as many drawn: at one site all are equally near.
    patience: stages in a row without a new individual, for each founder, after which the population restarts.
    apart: share of the tasks that must have other neighbours for a newcomer not to be near a member.
    size: members at most.
    depth: of a founder's annealing, in that of the option.
    focused: whether later stages may search a few tours alone.
    long, short, packing, parting: where there are any.
    regions: share of the crossings of many tours that inherit a region (crossover.py).
    settling: as many after which annealings are fine as often as they may be.
    fine: the final phase of fine annealings; fine_share: their share, at most; fine_first: their first temperature in
    mean legs, at most.
    reheating, quench: where there is any.
    compact: share of annealings, of founders none, that are compact where nothing was new for long. At one site with
    0.5 att532.euc2d_10 ends, 30 s, at 0.38 % (four seeds), without at 0.9 %. From the beginning on they lead into traps
    where the total is small: pr439_10, 12 s: 0.16, 1.85, 1.39, 0.16 %, as it is 0.16, 0.16, 0.16, 0.50 %.
    """

    measure: Measure
    width: int
    depots: int
    patience: int
    apart: float
    size: int
    depth: float
    focused: bool
    long: LongFounder | None
    short: ShortTours | None
    regions: float
    settling: int
    fine: FinalPhase
    fine_share: float
    fine_first: float
    reheating: Reheating | None
    quench: Quench | None
    compact: float
    packing: Packing | None
    parting: PartingParameters | None

    def on(self, data: ProblemData) -> Strategy:
        """Return this one as an instance has it: with short tours, packing and parting, or without."""
        short = self.short if self.short is None or self.short.suits(data) else None
        packing = self.packing if self.packing is None or self.packing.suits(data) else None
        parting = self.parting if self.parting is None or self.parting.suits(data) else None
        return replace(self, short=short, packing=packing, parting=parting)

    def distinct(self) -> float:
        """Return the share of the tasks that must have other neighbours, with short tours or without."""
        return self.apart if self.short is None else self.short.apart

    def reheats(self, staleness: float, rng: Rng) -> bool:
        """Return whether a reheating is drawn, with probability staleness / 2 but reheating.share at most."""
        return self.reheating is not None and uniform(rng) < min(self.reheating.share, 0.5 * staleness)

    def draw_schedule(self, first: float, staleness: float, parameters: ScheduleParameters, rng: Rng) -> Schedule:
        """Return a schedule from `first` mean legs on, fine with probability `staleness` but fine_share at most."""
        softness = parameters.draw_softness(rng)
        if uniform(rng) >= min(self.fine_share, staleness):
            return Schedule(first, softness, parameters.final)
        return Schedule(min(first, self.fine_first), softness, self.fine)


SEVERAL_DEPOTS = Strategy(
    measure=p_norm(128),
    width=RecreateParameters().width,
    depots=RecreateParameters().depots,
    patience=3,
    apart=0.15,
    size=20,
    depth=0.25,
    focused=False,
    long=LongFounder(),
    short=ShortTours(),
    regions=0.5,
    settling=3,
    fine=FinalPhase(below=0.015, margin=2e-4, last=2e-5),
    fine_share=1.0,
    fine_first=float("inf"),
    reheating=None,
    quench=None,
    compact=0.0,
    packing=None,
    parting=PartingParameters(),
)
ONE_SITE = Strategy(
    measure=excess(0.0),
    width=NeighbourhoodParameters().tasks,
    depots=1,
    patience=9,
    apart=0.05,
    size=8,
    depth=1.0,
    focused=True,
    long=None,
    short=None,
    regions=0.0,
    settling=1,
    fine=FinalPhase(below=0.05, margin=3e-5, last=3e-5, strings=0.2),
    fine_share=0.67,
    fine_first=0.05,
    reheating=Reheating(),
    quench=Quench(),
    compact=0.5,
    packing=Packing(),
    parting=PartingParameters(),
)
