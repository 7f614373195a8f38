"""Budget: how far a search is on its way to its limit, and how many steps to take before looking at the clock again."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import NamedTuple

from formulations.routing.recorder import Recorder
from formulations.routing.search.numbering import Numbering
from formulations.routing.search.tours import Tours, to_routes

_LOOKS = 4
"""Times that each of several threads looks at the clock before they meet, at least."""


@dataclass(frozen=True)
class BudgetParameters:
    """How often a search looks at its limits.

    seconds: between two looks at the clock: a tenth of what a limit may be overrun by (0.2 s, tests/benchmarks).
    steps: between two looks where the iteration limit sets the schedule.
    level: steps at one temperature, at most: the shortest annealing of a population, of 10 000, has forty levels.
    levels: after which threads meet, at the latest, and limits and the best tours are looked at.
    telling: share of the time that telling of better routes may take before the end where there is no matrix of costs:
    of 20,000 tasks each takes 8 ms.
    probe, probed: share of the limit, and where the clock sets it steps, after which the speed is known well enough to
    plan a population: the first steps wait for threads to start.
    """

    seconds: float = 0.02
    steps: int = 1000
    level: int = 250
    levels: int = 16
    telling: float = 0.02
    probe: float = 0.01
    probed: int = 4000


class Window(NamedTuple):
    """What a thread may do before threads meet: `steps`, a `level` at a time, none after `until` [s] on the clock."""

    steps: int
    level: int
    until: float

    @property
    def over(self) -> bool:
        """Whether it is time to meet."""
        return time.perf_counter() >= self.until


class Budget:
    """What one search may use under a recorder's limits.

    Where an iteration limit is given it counts iterations only, so that a run is repeatable; the time limit then merely
    stops it. Otherwise it follows the clock.
    """

    def __init__(self, recorder: Recorder, parameters: BudgetParameters) -> None:
        self._recorder, self._parameters = recorder, parameters
        self._rate = 1000.0
        self._began = time.perf_counter()
        self.iterations = 0

    @property
    def fraction(self) -> float:
        """How much of the limit is used, from 0 to 1."""
        limits = self._recorder.limits
        if limits.iterations is None:
            return min(1.0, self._recorder.elapsed / limits.time)
        return min(1.0, self.iterations / limits.iterations) if limits.iterations else 1.0

    @property
    def has_probed(self) -> bool:
        """Whether the speed is known well enough to plan."""
        exact = self._recorder.limits.iterations is not None
        return self.fraction >= self._parameters.probe and (exact or self.iterations >= self._parameters.probed)

    @property
    def stopped_by(self) -> str:
        """Which limit is reached: "time", "iterations" or ""."""
        if self._recorder.remaining <= 0.0:
            return "time"
        limit = self._recorder.limits.iterations
        return "iterations" if limit is not None and self.iterations >= limit else ""

    @property
    def total_steps(self) -> float:
        """How many steps the limit allows, as far as known by now."""
        limits = self._recorder.limits
        return float(limits.iterations) if limits.iterations is not None else self._rate * limits.time

    def next_steps(self, most: int = 10**9) -> int:
        """Return how many steps to take now, from 1 to `most`."""
        self._began = time.perf_counter()
        limit = self._recorder.limits.iterations
        if limit is not None:
            return max(1, min(self._parameters.steps, most, limit - self.iterations))
        return max(1, min(most, int(self._rate * min(self._parameters.seconds, self._recorder.remaining))))

    def next_window(self, most: int, level: int) -> Window:
        """Return what each thread may do now, about `most` steps, `level` of them at one temperature.

        By the clock it is over when so many steps would take that long: some take a hundred times as long as others,
        and threads are unequally fast. They meet in time, each after as many steps as it could take.
        """
        steps, limits = self.next_steps(most), self._recorder.limits
        if limits.iterations is not None:
            return Window(steps, level, math.inf)
        until = self._began + steps / self._rate
        if limits.threads == 1:
            return Window(steps, level, until)
        return Window(2 * steps, min(level, max(1, steps // _LOOKS)), until)

    def took(self, steps: float) -> None:
        """Say that `steps` steps were taken since `next_steps`, on average over threads."""
        self.iterations += round(steps)
        spent = max(1e-6, time.perf_counter() - self._began)
        self._rate = 0.5 * self._rate + 0.5 * steps / spent


class Teller:
    """Gives better tours to a recorder, by the numbers of its instance, for no more than `share` of the time so far."""

    def __init__(self, recorder: Recorder, share: float, numbers: Numbering) -> None:
        self._recorder, self._share, self._numbers, self._spent = recorder, share, numbers, 0.0

    @property
    def has_time(self) -> bool:
        """Whether better tours may be told now; where not, they wait."""
        return self._spent <= self._share * self._recorder.elapsed

    def tell(self, tours: Tours) -> None:
        """Give tours to the recorder."""
        began = self._recorder.elapsed
        self._recorder.incumbent(self._numbers.of_instance(to_routes(tours)))
        self._spent += self._recorder.elapsed - began
