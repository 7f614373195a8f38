"""Search of parts: the longest tour and some near it have a population of their own, one part after the other.

Where a far task decides or tours are short, a chained search leaves a few of many tours too long: those that go far,
of few tasks, while all others have time to spare. Kicks of the whole are seldom at these, and a way out takes several
of them at once, which a population of so few tours finds.
From solutions of 30 s, six parts of 1 s, by script, three seeds: u2152_20 0.20 % above the best known, from 0.32 %,
pr2392_20 0.24 %, from 0.55 %. Solved by themselves, parts of three, four and eight tours gained less than of six.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from formulations.routing.search.decomposition import Subproblem, around, merge, subproblem
from formulations.routing.search.problem_data import ProblemData
from formulations.routing.search.tours import Tours, duplicate

if TYPE_CHECKING:
    from formulations.routing.search.population import Population


class PartParameters(NamedTuple):
    """How many tours a part has, and how many parts a search has, one after the other.

    tasks: of a part at most, tours being of the mean length, else there are none: rl5915_20, 30 s, two seeds, loses
    0.5 % by parts of 1,780 tasks; pcb3038_20, of 911, gains 0.4 % (three seeds).
    """

    tours: int = 6
    parts: int = 2
    tasks: int = 1000

    def suit(self, data: ProblemData) -> bool:
        """Return whether tours are so short that a population of some of them comes to something."""
        n, m = data.size
        return n * min(self.tours, m) <= self.tasks * m


@dataclass
class _Part:
    """A part under way: which tours it is `of`, their population, and when it begins and ends, in 0..1 of all parts."""

    of: Subproblem
    population: Population
    begin: float
    end: float
    steps: int = 0
    planned: bool = False

    def advance(self, done: float, steps: int) -> None:
        """Anneal by `steps` steps at `done` of all parts."""
        population, now = self.population, (done - self.begin) / (self.end - self.begin)
        if not self.planned and self.steps >= population.parameters.budget.probed and now > 0.0:
            population.plan(now / self.steps)
            self.planned = True
        if now >= population.end:
            population.grow_up()
            population.take_in()
            population.begin(now)
        population.advance(now, steps)
        self.steps += steps


class PartSearch:
    """A search of parts under way, of the best tours of a population."""

    def __init__(self, whole: Population, parameters: PartParameters) -> None:
        self._whole, self._parameters = whole, parameters
        self._tours, self.longest = duplicate(whole.best), whole.incumbent
        self._part = self._next(0.0)

    def advance(self, done: float, steps: int) -> bool:
        """Anneal by `steps` steps at `done` in 0..1 of all parts; return whether the longest tour became shorter."""
        if self._part.end <= done < 1.0:
            self._part = self._next(done)
        population, before = self._part.population, self.longest
        self._part.advance(done, steps)
        if population.improved:
            population.improved = False
            merge(self._whole.data.costs, self._part.of.nodes, population.best, self._tours)
            self.longest = float(self._tours.cost.max())
        return self.longest < before

    def best(self) -> Tours:
        """Return the tours, whose longest only becomes shorter."""
        return duplicate(self._tours)

    def _next(self, done: float) -> _Part:
        """Return the part that begins now, of the best tours of all threads."""
        whole, how, draws = self._whole, self._parameters, self._whole.parameters.decomposition
        self._tours, self.longest = duplicate(whole.best), whole.incumbent
        wanted, first = min(how.tours, whole.data.size[1]), int(self._tours.cost.argmax())
        near = draws._replace(anywhere=0.0)  # with 0.3, as in decompositions: 0.26 and 0.54 %
        uavs = around(whole.data.near, self._tours, first, wanted, near, whole.rng)
        if uavs.size < wanted:  # a crowd far out may have no other near it
            uavs = around(whole.data.near, self._tours, first, wanted, draws, whole.rng)
        part = subproblem(whole.data, self._tours, uavs, whole.parameters.neighbourhood)
        left = 1.0 - done
        return _Part(part, whole.of_part(part), done, done + left / max(1, round(left * how.parts)))
