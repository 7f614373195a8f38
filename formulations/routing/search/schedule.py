"""Annealing schedule (Kirkpatrick, Gelatt, Vecchi 1983): temperature and objective; all change geometrically.

The norm is so soft that a tour counts as long which is within a few temperatures of the longest. How soft is drawn for
each annealing: a soft norm makes room in crowds of long tours, a sharp one finds optima in which most tours are long.
In the end what counts is the excess over a cap just below the longest tour of the incumbent, and the annealing goes on
to temperatures below the small shares of a tour by which good packings differ. A fine annealing has a cap nearer to
that tour and a colder end. Neither measure sees tours with time to spare; the more UAVs there are the less does the
mean, and such tours end up in any order though others need their time. A compact annealing sees them: in the end ε is a
share of the total. Temperatures are in mean legs, so that they suit instances of any size and unit. Where costs are
multiples of a grain that is no small part of a leg, whole numbers in most cases, the excess has plateaus: it is the
mean that tells their points apart and pulls, the more the coarser the grain, and the cap is the next longest tour that
can be had.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from formulations.routing.search.energy import TINY, Objective, excess, p_norm
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.tours import Tours

USUAL_TOURS = 5
"""Tours of the instances that the temperatures were tuned on, about."""
MANY_BELOW, MANY_LAST, MANY_SOFTNESS = 0.01, 0.0045, (3.0, 2.0)
"""`ScheduleParameters` of many tours: a colder end, of which the packing below the cap takes a share as before."""


def mean_leg(tours: Tours) -> float:
    """Return what a leg takes in the mean [s], never nothing, though an empty tour has a leg of 0."""
    return max(float(tours.cost.sum()) / tours.after.size, TINY)


@dataclass(frozen=True)
class FinalPhase:
    """How an annealing ends.

    below: the temperature in mean legs below which the excess over the cap counts; margin: the share of the incumbent's
    longest tour by which the cap lies below it; last: the last temperature, at most, as a share of the longest tour;
    strings: share of ruins by strings, in that of other annealings.
    """

    below: float
    margin: float
    last: float
    strings: float = 1.0


@dataclass(frozen=True)
class ScheduleParameters:
    """Temperatures in mean legs, and what else belongs to all schedules.

    founder: the first temperature of a solution from scratch: legs of the mean length are still accepted often.
    child, perturbed: lower ones, at which a child of crossover and a perturbed member keep most of their tours.
    last: the last temperature, at most; the final phase may go lower.
    mean_weight: share ε of the mean tour in the energy at the temperature of a founder, and in the end; of a compact
    annealing the latter is a share of the total.
    softness: p = max_k C_k / (softness · temperature), one of these drawn for each annealing.
    largest_p: a larger p tells lengths apart that differ by less than 0.2 %, which is left to the final phase.
    grain_weight, most_weight: ε is (grain_weight · grain in mean legs)² at least, but most_weight at most.
    quiet: last temperature, at least, in the energy of a grain of one tour's length in the mean.
    final: the usual final phase; without its cap, and those of fine annealings, mean gaps grow by at most 0.1 %.
    """

    founder: float = 0.7
    child: float = 0.15
    perturbed: float = 0.1
    last: float = 0.007
    mean_weight: tuple[float, float] = (0.5, 0.02)
    softness: tuple[float, float] = (8.0, 2.0)
    largest_p: int = 499
    grain_weight: float = 10.0
    most_weight: float = 5.0
    quiet: float = 0.2
    final: FinalPhase = FinalPhase(below=0.015, margin=1e-3, last=1e-4)

    def draw_softness(self, rng: Rng) -> float:
        """Return one of `softness`."""
        return self.softness[below(rng, len(self.softness))]

    def of_many(self, n_depots: int) -> ScheduleParameters:
        """Return those of one annealing of many tours, as there is without a matrix of costs.

        What a leg counts for in a norm of m tours falls as 1/m, so it begins hotter by as much. 20,000 tasks, 50 UAVs,
        8 CPU s: longest tour 2192 s as it is, 2157 s begun at 10 mean legs, 2147 s with all of this.
        """
        final = replace(self.final, below=MANY_BELOW)
        hotter = max(1.0, n_depots / USUAL_TOURS)
        return replace(self, founder=hotter * self.founder, last=MANY_LAST, softness=MANY_SOFTNESS, final=final)


@dataclass(frozen=True)
class Schedule:
    """How one annealing goes.

    first: temperature in mean legs; compact: whether tours below the longest get short too.
    """

    first: float
    softness: float
    final: FinalPhase
    compact: bool = False

    @property
    def strings(self) -> float:
        """Share of ruins by strings, in that of other annealings."""
        return self.final.strings

    def at(
        self, done: float, tours: Tours, incumbent: float, parameters: ScheduleParameters, grain: float = 0.0
    ) -> tuple[float, Objective]:
        """Return (temperature [s], objective) at `done` in 0..1 of an annealing; legs are those of `tours`.

        incumbent [s]: the longest of the best tours known; grain [s]: what all costs are whole multiples of, or 0.
        """
        leg = mean_leg(tours)
        legs = float(tours.cost.max()) / leg
        even, peaked = parameters.mean_weight
        if self.compact:
            peaked *= tours.cost.size
        coarseness = parameters.grain_weight * grain / leg
        least = min(parameters.most_weight, coarseness * coarseness)
        even, peaked = max(even, least), max(peaked, least)
        quiet = min(parameters.quiet * peaked * grain / (leg * tours.cost.size), 0.5 * self.first)
        last = max(min(parameters.last, self.final.last * legs), quiet, TINY)
        now = self.first * (last / self.first) ** done
        weight = peaked * (even / peaked) ** (math.log(now / last) / math.log(parameters.founder / last))
        if now < self.final.below:
            cap = min((1.0 - self.final.margin) * incumbent, incumbent - grain)
            return leg * now, Objective(excess(cap), weight)
        p = int(min(parameters.largest_p, max(2.0, legs / (self.softness * now))))
        return leg * now, Objective(p_norm(p), weight)
