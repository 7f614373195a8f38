"""The pool: all tours that matter of some UAVs, listed; pricing is a scan, and reduced costs shorten the list.

Those that matter are the tours that routes better than the incumbent can still use. By the Lagrangian bound (see
`pricing`) routes that use tour p of UAV k cost at least L − r_k + r(p), so a tour with r(p) ≥ cap − L + r_k is in no
better routes. What is left is listed by the same label search without a beam; of the tours over one set of tasks only
the cheapest matters. The list of a UAV is given up, not cut, when it does not fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.cuts import TaskCuts, held
from formulations.routing.columns.label_search import Orders, path
from formulations.routing.columns.pricing import Column, DualBound, Duals, Priced, Pricer
from formulations.routing.columns.two_sided import Attempt
from formulations.routing.columns.word_sets import lowest
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit

_SHARES = (0.6, 0.45, 0.3, 0.15)  # of the gap, of which tours are kept in reserve: the first that fits
_RESERVE_LABELS, _RESERVE = 1_000_000, 300_000


@dataclass(frozen=True)
class Pool:
    """Tours of the UAVs `listed` (m,): `uav` (p,), `visited` (p, words), `cost` (p,) [s], the labels they end in.

    Their orders are kept per UAV and read only where needed.
    """

    listed: Bools
    uav: Ints
    visited: NDArray[np.uint64]
    cost: Floats
    label: Ints
    orders: dict[int, Orders]

    @classmethod
    def empty(cls, n_uavs: int, n_tasks: int) -> Pool:
        """Return a pool in which no UAV is listed yet."""
        none, words = np.zeros(0, np.int64), np.zeros((0, (n_tasks + 63) // 64), np.uint64)
        return cls(np.zeros(n_uavs, np.bool_), none, words, np.zeros(0), none, {})

    def listing(self, k: int, visited: NDArray[np.uint64], cost: Floats, label: Ints, orders: Orders) -> Pool:
        """Return the pool with all tours that matter of UAV k as well."""
        return Pool(
            self.listed | (np.arange(self.listed.size) == k),
            np.concatenate([self.uav, np.full(cost.size, k)]),
            np.concatenate([self.visited, visited]),
            np.concatenate([self.cost, cost]),
            np.concatenate([self.label, label]),
            {**self.orders, k: orders},
        )

    def copying(self, source: int, k: int, others: Pool) -> Pool:
        """Return the pool with the tours that UAV `source` has in `others` as those of UAV k."""
        block = others.block(source)
        return self.listing(k, others.visited[block], others.cost[block], others.label[block], others.orders[source])

    @property
    def size(self) -> int:
        """Number of tours."""
        return self.uav.size

    @property
    def complete(self) -> bool:
        """Whether every UAV is listed."""
        return bool(self.listed.all())

    def column(self, p: int) -> Column:
        """Return tour p with its order."""
        k, label = int(self.uav[p]), int(self.label[p])
        return Column(k, path(self.orders[k], label), float(self.cost[p]))

    def only(self, keep: Bools) -> Pool:
        """Return the pool of the tours chosen."""
        if keep.all():
            return self
        kept = self.uav[keep], self.visited[keep], self.cost[keep], self.label[keep]
        return replace(self, uav=kept[0], visited=kept[1], cost=kept[2], label=kept[3])

    def holds(self, task: int) -> Bools:
        """Say which tours visit `task`."""
        return (self.visited[:, task >> 6] >> np.uint64(task & 63)) & np.uint64(1) != 0

    def may_visit(self, n_tasks: int) -> Bools:
        """Say which UAV has a tour with which task, shape (m, n)."""
        tasks = np.arange(n_tasks)
        blocks = [self.block(k) for k in range(self.listed.size)]
        of_any = np.array([np.bitwise_or.reduce(self.visited[block], axis=0) for block in blocks])
        return (of_any[:, tasks >> 6] >> (tasks & 63).astype(np.uint64)) & np.uint64(1) != 0

    def without(self, task: int, uavs: list[int]) -> Pool:
        """Drop the tours in which one of `uavs` visits `task`."""
        return self.only(~(self.holds(task) & np.isin(self.uav, uavs)))

    def under(self, cap: float) -> Pool:
        """Keep the tours of cost ≤ `cap`."""
        return self.only(self.cost <= cap)

    def needed(self, at: DualBound, cap: float) -> Pool:
        """Drop the tours that cannot be in routes of cost ≤ `cap`."""
        keep = np.ones(self.size, np.bool_)
        duals, allowed = at.duals, np.nextafter(at.allowed(cap), np.inf)
        for k in np.flatnonzero(self.listed):
            block, sigma = self.block(int(k)), float(duals.sigma[k])
            tours = self.visited[block], self.cost[block]
            value, _ = _values(*tours, duals.price, sigma, duals.by_task, float(allowed[k]), False)
            keep[block] = np.isfinite(value)
        return self.only(keep)

    def nearest(self, at: DualBound, most: int) -> Pool:
        """Return the `most` tours that raise the bound least, all of UAVs that are listed."""
        if self.size <= most:
            return self
        rise = np.empty(self.size)
        for k in np.flatnonzero(self.listed):
            block, sigma = self.block(int(k)), float(at.duals.sigma[k])
            tours = self.visited[block], self.cost[block]
            rise[block] = _values(*tours, at.duals.price, sigma, at.duals.by_task, np.inf, False)[0] - at.least[k]
        return self.only(rise <= np.partition(rise, most)[most])

    def block(self, k: int) -> slice:
        """Return where the tours of UAV k are: next to each other, as they were listed."""
        at = np.flatnonzero(self.uav == k)
        return slice(int(at[0]), int(at[-1]) + 1) if at.size else slice(0, 0)


class Lists(NamedTuple):
    """The tours listed, some of the UAVs that are not, and the number of labels and pairs of them made in vain."""

    pool: Pool
    reserve: Pool
    in_vain: int


@njit(cache=True, nogil=True)
def _values(
    visited: NDArray[np.uint64], cost: Floats, price: Floats, sigma: float, cuts: TaskCuts, limit: float, to_least: bool
) -> tuple[Floats, float]:
    """Return the reduced costs of one UAV's tours, infinite where not below the limit, and the least.

    Cuts, which never lower it, are looked at only where that matters; for the least of all, if asked `to_least`, also
    above the limit.
    """
    value, least, of_bytes = np.empty(cost.size), np.inf, _sums_of_bytes(price, 64 * visited.shape[1])
    for p in range(cost.size):
        total = sigma * cost[p] - _earned(visited[p], of_bytes)
        if total < limit or (to_least and total < least):
            total += _paid(visited[p], cuts, (max(limit, least) if to_least else limit) - total)
            least = min(least, total)
        value[p] = total if total < limit else np.inf
    return value, least


@njit(cache=True, nogil=True)
def _sums_of_bytes(price: Floats, bits: int) -> Floats:
    """Return the sum of prices [s] for every byte of a set and each of its values, (bits / 8, 256)."""
    sums = np.zeros((bits // 8, 256))
    for i in range(price.size):
        low = 1 << (i & 7)
        for value in range(low):
            sums[i >> 3, low + value] = sums[i >> 3, value] + price[i]
    return sums


@njit(cache=True, nogil=True, inline="always")
def _earned(words: NDArray[np.uint64], of_bytes: Floats) -> float:
    total = 0.0
    for w in range(words.size):
        for b in range(8):
            total += of_bytes[8 * w + b, (words[w] >> np.uint64(8 * b)) & np.uint64(255)]
    return total


@njit(cache=True, nogil=True)
def _paid(words: NDArray[np.uint64], cuts: TaskCuts, enough: float) -> float:
    """Return what a tour pays for cuts of which it holds two tasks or more [s], or part of it that is `enough`."""
    total = 0.0
    for c in range(cuts.bits.shape[1]):
        _, twice = held(words, cuts.bits, c)
        while twice != np.uint64(0):
            total += cuts.prices[64 * c + lowest(twice)]
            twice &= twice - np.uint64(1)
        if total >= enough:
            return total
    return total


class PoolPricer:
    """Prices the UAVs that are listed by scanning the pool, always completely, the `others` by label search."""

    wanted = 150
    """Columns of a UAV worth adding at once."""

    def __init__(self, pool: Pool, others: Pricer | None = None) -> None:
        self.pool, self.others = pool, others
        self.n_uavs = pool.listed.size
        self._blocks = [pool.block(k) for k in range(self.n_uavs)]

    def price(self, k: int, duals: Duals, threshold: float) -> Priced:
        """Return UAV k's best columns of reduced cost below `threshold` ≤ 0, and the least of all or a bound on it."""
        if self.others is not None and not self.pool.listed[k]:
            return self.others.price(k, duals, threshold)
        block, tours = self._blocks[k], self.pool
        sigma = float(duals.sigma[k])
        values, least = _values(
            tours.visited[block], tours.cost[block], duals.price, sigma, duals.by_task, threshold, True
        )
        below = np.flatnonzero(np.isfinite(values))
        best = below[np.argsort(values[below], kind="stable")[: self.wanted]]
        return Priced(least, [tours.column(block.start + int(p)) for p in best], True)

    def price_all(self, uavs: Sequence[int], duals: Duals, thresholds: Floats) -> dict[int, Priced]:
        """Return what `price` would of each of some UAVs, at their thresholds (m,)."""
        if self.others is None:
            return {k: self.price(k, duals, float(thresholds[k])) for k in uavs}
        searched = self.others.price_all([k for k in uavs if not self.pool.listed[k]], duals, thresholds)
        return {k: searched[k] if k in searched else self.price(k, duals, float(thresholds[k])) for k in uavs}


def list_tours(
    pool: Pool,
    pricer: Pricer,
    at: DualBound,
    labels: int,
    room: int,
    known: Pool,
    *,
    at_once: int = 1,
    known_are_of_here: bool = False,
) -> Lists:
    """Return `pool` with the tours of more UAVs, those with few legs first, and some tours of the others in reserve.

    The first that does not fit into `labels` labels is passed over, and the others after it get no more labels than a
    reserve (pairs of labels count as `two_sided.py` says); there are never more than `room` tours in all. Of a UAV with
    too many tours even for the reserve those `known` are kept. known_are_of_here : those are the reserve that was made
    at the same prices, with fewer labels, and are not looked for again. at_once : UAVs looked at side by side; where
    one of them leaves the next less room than that had, the next is looked at again, so that the same comes out for any
    number.
    """
    allowed, in_vain, reserve = at.allowed(pricer.cap), 0, Pool.empty(pricer.n_uavs, pricer.legs.n_tasks)
    n_legs = np.isfinite(pricer.legs.between).sum(axis=(1, 2))
    few_legs_first = sorted(np.flatnonzero(~pool.listed).tolist(), key=lambda k: int(n_legs[k]))
    first_of = pricer.firsts(few_legs_first, at.duals, allowed)
    firsts = [k for k, first in first_of.items() if k == first]

    def with_what_is_left() -> _Look:
        most = labels if in_vain == 0 else min(labels, _RESERVE_LABELS)
        return _Look(pricer, at, most, room - pool.size, not known_are_of_here)

    for begin in range(0, len(firsts), at_once):
        look, uavs = with_what_is_left(), firsts[begin : begin + at_once]
        for k, looked in zip(uavs, pricer.each(look, uavs), strict=True):
            now = with_what_is_left()
            if now.labels < look.labels or looked.labels > now.room < look.room:
                [looked] = pricer.each(now, [k])  # as if it had been looked at after those before it
            if looked.whole and looked.tours is not None:
                pool = pool.listing(k, *looked.tours)
                continue
            in_vain += looked.labels
            if looked.tours is not None:
                reserve = reserve.listing(k, *looked.tours)
            elif known.listed[k]:
                reserve = reserve.copying(k, k, known)
    for k, first in first_of.items():
        if k != first and reserve.listed[first]:
            reserve = reserve.copying(first, k, reserve)
        elif k != first and pool.listed[first] and pool.size + (pool.uav == first).sum() <= room:
            pool = pool.copying(first, k, pool)
    return Lists(pool, reserve, in_vain)


class _Tours(NamedTuple):
    """What `Pool.listing` takes of one UAV."""

    visited: NDArray[np.uint64]
    cost: Floats
    label: Ints
    orders: Orders


class _Looked(NamedTuple):
    """The tours of one UAV, the `whole` of them or a reserve, None where not even that fits; labels it took to tell."""

    tours: _Tours | None
    whole: bool
    labels: int


@dataclass(frozen=True)
class _Look:
    """Looks for all tours of a UAV that matter, at most `room`, with so many `labels`.

    reserves : whether it looks for a reserve where these are too many.
    """

    pricer: Pricer
    at: DualBound
    labels: int
    room: int
    reserves: bool

    def __call__(self, k: int) -> _Looked:
        """Return all tours of UAV k, else its reserve: those nearest to routes of the relaxation, as many as fit.

        They are columns that pricing need not search for; that there are no others is left to the label search.
        """
        pricer, at = self.pricer, self.at
        if pricer.time_left() <= 0:
            return _Looked(None, False, 0)
        sides, store = pricer.sides(k, at.duals), pricer.store.of_uav(k)
        least, gap = float(at.least[k]), pricer.cap - at.value
        shares = _SHARES if self.reserves else ()
        attempts = [Attempt(float(at.allowed(pricer.cap)[k]), self.labels, self.room)]
        attempts += [Attempt(least + share * gap, _RESERVE_LABELS, _RESERVE) for share in shares]
        tried = sides.all_tours(store, attempts, pricer.time_left)
        used, found = tried[0].labels + tried[0].pairs, tried[-1]
        if not found.complete:
            return _Looked(None, False, used)
        orders, ends = store.orders(found)
        copied = Orders(orders.last.copy(), orders.parent.copy())
        return _Looked(_Tours(found.visited, found.costs, ends, copied), len(tried) == 1, used)
