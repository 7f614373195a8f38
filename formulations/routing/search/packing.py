"""Packing: what a population does beside all else where many UAVs fly from one site, and the farthest task decides.

The way there and back is then most of what any of them may fly, and it is a matter of who takes which far tasks.

Capped annealings lower the total of tours none of which may exceed a cap, from the beginning on:

    E = w Σ_k C_k + Σ_k max(0, C_k − cap)

A norm or an excess alone does not see what tours below the longest waste; where tasks hardly fit into the tours, room
must be made in all of them at once. Penalising what exceeds a cap is how routing searches keep a limit on duration
(Vidal, Crainic, Gendreau, Prins, Computers & OR 40, 2013). The cap lies well below the longest tour of the incumbent,
so that the ways of packing which that tour belongs to, which are no way to better ones, cost something from the start.

Reheatings are drawn from the beginning on. Where no packing is found that is shorter all begins anew (eras.py).

Trimming (trimming.py) is for packings that a tour of few far tasks decides: that tour is set aside as it would have to
be, and the others are searched alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from formulations.routing.search.costs import farthest_trip
from formulations.routing.search.energy import Objective, excess
from formulations.routing.search.eras import EraParameters
from formulations.routing.search.problem_data import ProblemData
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.schedule import ScheduleParameters, mean_leg
from formulations.routing.search.tours import Tours
from formulations.routing.search.trimming import TrimmingParameters


@dataclass(frozen=True)
class CappedSchedule:
    """How one capped annealing goes; temperatures, as shares of `weight` mean legs, fall geometrically.

    margin: the share of the incumbent's longest tour by which the cap lies below it; strings: as in FinalPhase.
    """

    first: float
    last: float
    weight: float
    margin: float
    strings: float = 1.0

    def at(
        self, done: float, tours: Tours, incumbent: float, parameters: ScheduleParameters, grain: float = 0.0
    ) -> tuple[float, Objective]:
        """Return (temperature [s], objective) at `done` in 0..1; the arguments are those of `Schedule.at`."""
        temperature = self.weight * mean_leg(tours) * self.first * (self.last / self.first) ** done
        cap = min((1.0 - self.margin) * incumbent, incumbent - grain)
        return temperature, Objective(excess(cap), self.weight * tours.cost.size)


@dataclass(frozen=True)
class Packing:
    """Which stages are capped annealings, and how they go.

    att532.euc2d_10, pr439_10 and a280_10, 30 s, three seeds: `tests/benchmarks/search.py every` (measured.md).
    With 5 UAVs they are no gain: att532_5 and lin318_5, one run each, end 0.1 % longer.

    uavs: of the fleet, at least; room: the incumbent's longest tour, at most, in the longest trip to one task and back.
    Beyond, they are no gain either: 600 tasks in a square, 12 UAVs, 20 s, two seeds: 0.3 % longer.
    reheated: share of the stages after the founders, and beside trimmings, that are reheatings (strategy.py). On
    a280_10, when they were drawn as elsewhere, they brought a fifth of the last 0.4 % in a hundredth of the time.
    founders: share of the remaining ones that begin capped from scratch, where such are new every second time at least;
    where they are seldomer new it falls as much; recent: weight of the last one in the rate that says how often they
    are; seldom: added to that. On att532.euc2d_10 they are what all else comes of; on a280_10 none is new for long.
    depth: their length in that of a founder; longest: as a fraction of the limit, beyond which nothing of this is done.
    others: share of the remaining ones that are capped, of members and of parts of them.
    weights: w, one of which is drawn. A small one is blind to the total, of a large one few tours go far. One annealing
    of 5 n² / m steps on att532.euc2d_10, by script, median of 75 to 100: 0.8 % with 0.04, 2.0 % with 0.03, 2.9 % with
    0.01 and as other founders are 2.3 %; the least of them 0.1, 0.1, 0.5 and 1.5 %.
    first, later, last: temperatures from scratch, of what is a member's, and in the end; the total's, in mean legs.
    margin: of the cap, as a share of the incumbent's longest tour.
    trimming: of tours that decide; eras: when all begins anew.
    """

    uavs: int = 8
    room: float = 1.05
    reheated: float = 0.3
    founders: float = 0.3
    recent: float = 0.1
    seldom: float = 0.05
    depth: float = 4.0
    longest: float = 0.1
    others: float = 0.6
    weights: tuple[float, ...] = (0.02, 0.04)
    first: float = 1.0
    later: float = 0.3
    last: float = 0.1
    margin: float = 2e-3
    trimming: TrimmingParameters = field(default_factory=TrimmingParameters)
    eras: EraParameters = field(default_factory=EraParameters)

    def suits(self, data: ProblemData) -> bool:
        """Return whether many UAVs fly."""
        return data.size[1] >= self.uavs

    def leaves_little(self, longest: float, data: ProblemData) -> bool:
        """Return whether the farthest task leaves a tour little time for others; `longest` [s] is the incumbent's."""
        return longest <= self.room * farthest_trip(data.costs, data.size[0])

    def share_of_founders(self, rate: float) -> float:
        """Return the share of capped founders where `rate` says how often they are new, 0..1."""
        return self.founders * min(1.0, 2.0 * (rate + self.seldom))

    def draw_schedule(self, *, from_scratch: bool, rng: Rng) -> CappedSchedule:
        """Return a schedule with one of the weights."""
        weight = self.weights[below(rng, len(self.weights))]
        return CappedSchedule(self.first if from_scratch else self.later, self.last, weight, self.margin)
