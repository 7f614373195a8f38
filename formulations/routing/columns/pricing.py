"""Pricing: for given duals, the best tours of each UAV and a lower bound on what any tour of it can do.

The Lagrangian bound. Let σ ≥ 0 with Σ_k σ_k ≤ 1 and any π. Routes of makespan z ≥ 0 that use tour p_k for UAV k (or
none) visit every task once, so

    z ≥ Σ_k σ_k c_{p_k} = Σ_i π_i + Σ_k (σ_k c_{p_k} − Σ_{i∈p_k} π_i) ≥ Σ_i π_i + Σ_k min(0, r_k) = L(σ, π),

where r_k is any lower bound on the reduced cost of the tours of UAV k with cost ≤ cap. The duals need not be optimal
or exact: the floats at hand *are* σ and π. Rounding enters only in the sums. A tour has at most n + 1 legs and prices;
each partial sum is at most U + Σ|π| in size, so a computed reduced cost is off by at most
γ = 4(n + 2)·2⁻⁵³·(U + Σ|π| + Σρ), and L by at most (m + 1)·γ more; `margin` is that, tenfold, and is subtracted.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from formulations.routing.columns.completion import Bins, Memory
from formulations.routing.columns.cuts import Cut, TaskCuts, Watch, by_task, pays
from formulations.routing.columns.label_search import Clock, Room, Subproblem, no_limit, path
from formulations.routing.columns.labelling import least_of_all
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.recall import Recall, Walk, best_walks
from formulations.routing.columns.team import Each, one_by_one
from formulations.routing.columns.two_sided import Sides
from instances.arrays import Floats, Ints

_MOST_ENDS = 50_000
SHY = 1 - 1e-14
"""Keeps Σσ ≤ 1 in exact arithmetic."""
_BOTTLENECK = 0.9
"""Price σ_k above which UAV k is said to set the relaxation alone."""


@dataclass(frozen=True)
class Column:
    """One tour of one UAV: `tasks` in flying order, `cost` [s]."""

    uav: int
    tasks: tuple[int, ...]
    cost: float


@dataclass(frozen=True)
class Duals:
    """`price` π_i [s] of the tasks, shape (n,); `sigma` σ_k of the UAVs, shape (m,), σ ≥ 0, Σσ ≤ 1; `rent` μ_k [s];
    `rho` ρ_S ≥ 0 of the `cuts`. Cuts are only ever appended.

    μ_k is what UAV k's best known tour earns at these prices; only tours that earn more are worth adding.
    """

    price: Floats
    sigma: Floats
    rent: Floats
    rho: Floats
    cuts: tuple[Cut, ...] = ()

    @property
    def offset(self) -> float:
        """The part of the Lagrangian bound that no tour changes: Σπ − Σρ [s]."""
        return float(self.price.sum() - self.rho.sum())

    @cached_property
    def by_task(self) -> TaskCuts:
        """The cuts of each task and their prices."""
        return by_task(self.cuts, self.rho, self.price.size)

    @property
    def bottleneck(self) -> int | None:
        """The UAV that sets the relaxation nearly alone; None where several do."""
        return self.ahead(_BOTTLENECK)

    def ahead(self, share: float) -> int | None:
        """Return the UAV that sets the relaxation most, where its price is more than `share`; else None."""
        k = int(np.argmax(self.sigma))
        return k if self.sigma[k] > share else None

    def towards(self, other: Duals, step: float) -> Duals:
        """Return the point `step` of the way from these duals to `other` (a convex combination, so again duals)."""
        mine = np.zeros(len(other.cuts))
        mine[: self.rho.size] = self.rho
        pairs = ((self.price, other.price), (self.sigma, other.sigma), (self.rent, other.rent), (mine, other.rho))
        price, sigma, rent, rho = ((1 - step) * a + step * b for a, b in pairs)
        return Duals(price, sigma, rent, rho, other.cuts)

    def paid(self) -> Duals:
        """Return the same duals without the cuts of price zero."""
        paid = np.flatnonzero(self.rho > 0)
        return Duals(self.price, self.sigma, self.rent, self.rho[paid], tuple(self.cuts[s] for s in paid))

    def values(self, columns: Sequence[Column]) -> Floats:
        """Return the reduced costs of columns [s]; what returns to a task earns its price again."""
        n = self.price.size
        visits = np.array([np.bincount(column.tasks, minlength=n) for column in columns], np.int64).reshape(-1, n)
        cost = np.array([self.sigma[c.uav] * c.cost for c in columns])
        return np.asarray(cost - visits @ self.price + pays(visits > 0, self.cuts) @ self.rho)

    def margin(self, cap: float, m: int) -> float:
        """Return more than all rounding errors in a Lagrangian bound at these duals can add up to [s]."""
        n = self.price.size
        return 40 * (m + 1) * (n + 2) * 2.0**-53 * (cap + float(np.abs(self.price).sum() + self.rho.sum()))


@dataclass(frozen=True)
class DualBound:
    """A Lagrangian bound: `value` L [s] less the margin, the `duals` it holds at, terms r_k ≤ 0 [s] in `least` (m,)."""

    value: float
    duals: Duals
    least: Floats

    @classmethod
    def of_lost_task(cls, task: int, m: int, n: int, cap: float) -> DualBound:
        """Return a bound above `cap` [s] where no tour of cost ≤ `cap` has the task: a price nobody can earn."""
        price = np.where(np.arange(n) == task, 2 * cap, 0.0)
        duals = Duals(price, np.full(m, SHY / m), np.zeros(m), np.zeros(0))
        return cls(2 * cap - duals.margin(cap, m), duals, np.zeros(m))

    def allowed(self, cap: float) -> Floats:
        """Return the reduced costs [s], (m,), above which a tour is in no routes of cost ≤ `cap`: cap − L + r_k."""
        return cap - self.value + self.least


@dataclass(frozen=True)
class Effort:
    """How hard to price: `near` tasks and `watch` cuts remembered at a task, `bins` of time, `beam` labels a layer.

    both : search from both sides, where costs do not change with time and nodes have one state.
    """

    near: int
    bins: int
    beam: int
    watch: int = 0
    both: bool = False


@dataclass(frozen=True)
class Priced:
    """What pricing found for one UAV: a lower bound on its reduced costs, its best columns, whether these are all.

    lost : where they are not, the best walks: what to remember; in_vain : how many labels were made then.
    """

    least: float
    columns: list[Column]
    complete: bool
    lost: tuple[Walk, ...] = ()
    in_vain: int = 0

    @classmethod
    def unknown(cls) -> Priced:
        """Return what is known of a UAV that was not priced: nothing."""
        return cls(-np.inf, [], False)

    def of_uav(self, k: int) -> Priced:
        """Return the same for UAV k, which is like the one that was priced."""
        return replace(self, columns=[replace(column, uav=k) for column in self.columns])


class Prices(Protocol):
    """Anything that can price: the label search over legs, or a scan of a pool."""

    n_uavs: int

    def price_all(self, uavs: Sequence[int], duals: Duals, thresholds: Floats) -> dict[int, Priced]:
        """Return the best columns of each of some UAVs of reduced cost below `thresholds` (m,) ≤ 0, and bounds."""
        ...


class Pricer:
    """Prices tours of cost ≤ `cap`, and no longer than their UAV flies, over the legs left: one effort, label search.

    cap [s] : of the routes, as in `DualBound.allowed`; caps (m,) [s] : of the tours of each UAV.
    store : room for labels; each : how to do the same for several UAVs: both those of a team, where there is one.
    recall : what has been learnt to remember, and is where labels are lost.
    """

    wanted = 40
    """Columns of a UAV worth adding at once."""

    def __init__(
        self,
        legs: Legs,
        cap: float,
        effort: Effort,
        store: Room,
        time_left: Clock = no_limit,
        recall: Recall | None = None,
        each: Each = one_by_one,
    ) -> None:
        self.legs, self.cap, self.effort, self.store, self.time_left = legs, cap, effort, store, time_left
        self.recall = recall or Recall(legs.n_tasks)
        self.n_uavs, self.caps, self.each = legs.n_uavs, legs.caps(cap), each
        self._bins: dict[tuple[int, bool], Bins] = {}
        self._memory: tuple[int, Memory] | None = None
        self._watch: tuple[Memory, Duals, Watch] | None = None

    def at(self, effort: Effort, legs: Legs) -> Pricer:
        """Return the same pricer of another effort, over other legs."""
        return Pricer(legs, self.cap, effort, self.store, self.time_left, self.recall, self.each)

    @property
    def memory(self) -> Memory:
        """The ng-neighbourhoods by what has been learnt so far, the same for every UAV."""
        if self._memory is None or self._memory[0] != self.recall.lessons:
            between = np.minimum.reduce(self.legs.between)
            self._memory = self.recall.lessons, self.recall.memory(between, self.effort.near)
        return self._memory[1]

    def bins(self, k: int, *, backwards: bool = False) -> Bins:
        """Return the time of UAV k's legs in bins (made when first asked for: some never are)."""
        if (k, backwards) not in self._bins:
            courses = self.legs.courses[k] if self.legs.courses else None
            given = self.legs.of_uav(k), float(self.caps[k]), self.effort.bins, courses
            self._bins[k, backwards] = Bins.of(*given, backwards=backwards)
        return self._bins[k, backwards]

    @cached_property
    def kinds(self) -> Ints:
        """For every UAV the first with the same legs and the same labels."""
        # asked in a thread that works: another would make room that nothing uses
        [rooms] = self.each(lambda _: [self.store.of_uav(k) for k in range(self.n_uavs)], [0])
        shared = all(room is rooms[0] for room in rooms)
        return self.legs.kinds() if shared else np.arange(self.n_uavs)

    def firsts(self, uavs: Iterable[int], duals: Duals, thresholds: Floats) -> dict[int, int]:
        """Return, of each of some UAVs, the first of them with the same tours below its threshold (m,).

        What all of them share is made by the way: threads that work on several then only read it.
        """
        self.watch(duals)
        first: dict[tuple[int, float, float], int] = {}
        return {k: first.setdefault((int(self.kinds[k]), float(duals.sigma[k]), float(thresholds[k])), k) for k in uavs}

    def watch(self, duals: Duals) -> Watch:
        """Return the cuts watched at these duals."""
        memory = self.memory
        if self._watch is None or self._watch[0] is not memory or self._watch[1] is not duals:
            self._watch = memory, duals, Watch.of(memory.near, duals.cuts, duals.rho, self.effort.watch)
        return self._watch[2]

    def subproblem(self, k: int, duals: Duals) -> Subproblem:
        """Return the pricing problem of UAV k, completion bounds included."""
        legs, bins, watch, sigma = self.legs.of_uav(k), self.bins(k), self.watch(duals), float(duals.sigma[k])
        cap = float(self.caps[k])
        return Subproblem.bounded(legs, cap, bins, self.memory, watch, duals.price, sigma, duals.by_task)

    def sides(self, k: int, duals: Duals) -> Sides:
        """Return the pricing problem of UAV k as it is to be searched."""
        both = self.effort.both and not self.legs.courses
        return Sides(self.subproblem(k, duals), self.bins(k, backwards=True) if both else None)

    def price_all(self, uavs: Sequence[int], duals: Duals, thresholds: Floats) -> dict[int, Priced]:
        """Return what `price` would of each of some UAVs, at their thresholds (m,); of twins once. Learn from it."""
        first_of = self.firsts(uavs, duals, thresholds)
        firsts = list(dict.fromkeys(first_of.values()))
        priced = self.each(lambda k: self.price(k, duals, float(thresholds[k])), firsts)
        walks = [walk for one in priced for walk in one.lost]
        self.recall.learn(walks, np.ones(len(walks)))
        found = dict(zip(firsts, priced, strict=True))
        return {k: found[first].of_uav(k) for k, first in first_of.items()}

    def price(self, k: int, duals: Duals, threshold: float) -> Priced:
        """Return UAV k's best columns of reduced cost below `threshold` ≤ 0, and a bound on all of them."""
        if self.time_left() <= 0:  # completion bounds alone take up to half a second
            return Priced.unknown()
        sides = self.sides(k, duals)
        least = least_of_all(sides.problem)
        if least >= threshold:
            return Priced(least, [], True)
        labels = self.store.of_uav(k)
        found = sides.search(labels, threshold, self.time_left, beam=self.effort.beam, tours=_MOST_ENDS)
        least = max(least, float(found.values.min(initial=min(threshold, found.floor))))
        best = found.best(self.wanted)
        orders, ends = labels.orders(best)
        columns = [Column(k, path(orders, int(e)), float(c)) for e, c in zip(ends, best.costs, strict=True)]
        if found.complete:
            return Priced(least, columns, True)
        return Priced(least, columns, False, tuple(best_walks(sides.problem, threshold)), found.labels)


class Efforts(NamedTuple):
    """How hard to work: `pricing` in the order to try, quick ones first; `thorough` to fix and list."""

    pricing: tuple[Effort, ...]
    thorough: Effort


def efforts(n_tasks: int, bins: int, *, both: bool = False) -> tuple[Efforts, Efforts]:
    """Return how hard to work at a node without cuts and at one with cuts; at most `bins` bins.

    both : the strongest search from both sides, which is worth it where most labels are beyond half-way.
    """
    quick, middle, fine = (max(1, bins * tenths // 10) for tenths in (3, 5, 8))
    few, more = Effort(3, quick, 200), Effort(3, quick, 3000)
    if n_tasks <= 100:
        plain = (few, more, Effort(6, fine, 20_000), Effort(7, bins, 300_000, both=both))
        watching = (replace(few, watch=3), replace(more, watch=4), Effort(4, middle, 30_000, 4, both=both))
        widest, alone, listing = Effort(5, middle, 300_000, 4, both=both), Effort(6, fine, 0), Effort(4, middle, 0, 4)
    else:
        plain = (few, more, Effort(4, fine, 20_000), Effort(5, bins, 300_000, both=both))
        watching = (replace(few, watch=1), replace(more, watch=2), Effort(3, middle, 30_000, 2, both=both))
        widest, alone, listing = Effort(4, middle, 300_000, 2, both=both), Effort(5, fine, 0), Effort(4, middle, 0, 2)
    return Efforts(plain, replace(alone, both=both)), Efforts((*watching, widest), replace(listing, both=both))


def walking(n_tasks: int, bins: int) -> Effort:
    """Return how hard to price walks: few tasks remembered, as which these are is learnt."""
    return Effort(6 if n_tasks <= 100 else 4, max(1, bins * 6 // 10), 1)
