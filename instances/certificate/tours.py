"""All tours of one UAV that cost at most a cap and whose reduced cost is at most a threshold: listed by layers.

A path is known by the set of its tasks and the last of them; of all orders only the cheapest matters. Paths of ℓ + 1
tasks are made of those of ℓ, where the least that is left (`completion`) does not take them past the threshold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from instances.arrays import Bools, Floats, Ints
from instances.certificate.completion import WaysHome, ways_home
from instances.certificate.file import Prices
from instances.errors import InputError

_CHUNK = 2_000_000
"""Pairs of a path and a task that are looked at together."""
_BINS, _NEAR, _NEAR_OF_MANY = 400, 7, 5
"""Bins of time; tasks remembered at a task, and the same beyond 60 tasks."""


class TooManyError(InputError):
    """There are more paths than there is room for: the certificate is neither confirmed nor refuted."""


@dataclass(frozen=True)
class UavLegs:
    """Costs [s] of one UAV, infinite where it may not fly: `out` (n,), `between` (n, n), `home` (n,)."""

    out: Floats
    between: Floats
    home: Floats

    def without(self, tasks: Bools) -> UavLegs:
        """Forbid some of the tasks, (n,)."""
        between = np.where(tasks[:, None] | tasks, np.inf, self.between)
        return UavLegs(np.where(tasks, np.inf, self.out), between, np.where(tasks, np.inf, self.home))


@dataclass(frozen=True)
class Tours:
    """Tours of one UAV: `holds` (p, n), which tasks they visit, and `cost` (p,) [s], the least over all orders."""

    holds: Bools
    cost: Floats

    def only(self, keep: Bools) -> Tours:
        """Return some of the tours."""
        return self if keep.all() else Tours(self.holds[keep], self.cost[keep])

    def reduced(self, prices: Prices, k: int) -> Floats:
        """Return the reduced costs σ_k c − Σπ + Σ{ρ_S : two of S visited}, (p,) [s]."""
        value = prices.uav[k] * self.cost - self.holds @ np.array(prices.task)
        for (a, b, c), rho in zip(prices.sets, prices.rho, strict=True):
            if rho > 0:
                one, two, three = self.holds[:, a], self.holds[:, b], self.holds[:, c]
                value += rho * ((one & two) | (one & three) | (two & three))
        return np.asarray(value)


@dataclass(frozen=True)
class _Paths:
    """Paths of one layer: sets (p, words), last tasks, costs [s] and values, reduced costs so far [s]."""

    words: NDArray[np.uint64]
    last: Ints
    cost: Floats
    value: Floats

    def of(self, at: Ints | slice) -> _Paths:
        return _Paths(self.words[at], self.last[at], self.cost[at], self.value[at])

    def cheapest(self, per: NDArray[np.int64]) -> _Paths:
        """Return the cheapest path of each set and each value of `per`."""
        order = np.lexsort((self.cost, per, *self.words.T))
        words, key = self.words[order], per[order]
        new = np.ones(order.size, np.bool_)
        new[1:] = (words[1:] != words[:-1]).any(axis=1) | (key[1:] != key[:-1])
        return self.of(order[new])


def list_tours(legs: UavLegs, cap: float, prices: Prices, k: int, threshold: float, room: int) -> Tours:
    """Return all tours of UAV k of cost ≤ `cap` and reduced cost ≤ `threshold` [s].

    Raises TooManyError beyond `room` paths.
    """
    n, price, sigma = legs.out.size, np.array(prices.task), prices.uav[k]
    near = _NEAR if n <= 60 else _NEAR_OF_MANY
    bounds = ways_home(legs.between, legs.home, price, sigma, cap, _BINS, near)
    search = _Search(legs, cap * (1 + 1e-12), prices, sigma, threshold, bounds)
    layer, found, paths = search.departures(), list[_Paths](), 0
    while layer.last.size:
        paths += layer.last.size
        if paths > room:
            raise TooManyError(f"UAV {k} has more than {room} paths")
        found.append(search.landings(layer))
        layer = search.extensions(layer)
    whole = _joined(found, n).cheapest(np.zeros(sum(part.last.size for part in found), np.int64))
    at = np.arange(n)
    holds = (whole.words[:, at >> 6] >> (at & 63).astype(np.uint64)) & np.uint64(1) != 0
    return Tours(holds, whole.cost)


@dataclass(frozen=True)
class _Search:
    legs: UavLegs
    cap: float
    prices: Prices
    sigma: float
    threshold: float
    bounds: WaysHome

    def departures(self) -> _Paths:
        """Return the paths of one task."""
        n = self.legs.out.size
        task = np.flatnonzero(self.legs.out <= self.cap)
        words = np.zeros((task.size, (n + 63) // 64), np.uint64)
        cost = self.legs.out[task]
        paths = _Paths(_with(words, task), task, cost, self.sigma * cost - np.array(self.prices.task)[task])
        return paths.of(self._hopeful(paths))

    def landings(self, paths: _Paths) -> _Paths:
        """Return the tours, with the way home, of paths whose tours are within cap and threshold."""
        home = self.legs.home[paths.last]
        fits = np.flatnonzero(paths.cost + home <= self.cap)
        part, home = paths.of(fits), home[fits]
        tours = _Paths(part.words, part.last, part.cost + home, part.value + self.sigma * home)
        return tours.of(np.flatnonzero(tours.value <= self.threshold))

    def extensions(self, paths: _Paths) -> _Paths:
        """Return the paths of one task more, of each set and last task the cheapest."""
        n = self.legs.out.size
        size = max(1, _CHUNK // n)
        parts = (paths.of(slice(begin, begin + size)) for begin in range(0, paths.last.size, size))
        joined = _joined([self._extended(part) for part in parts], n)
        return joined.cheapest(joined.last)

    def _extended(self, paths: _Paths) -> _Paths:
        n = self.legs.out.size
        at = np.arange(n)
        visited = (paths.words[:, at >> 6] >> (at & 63).astype(np.uint64)) & np.uint64(1) != 0
        leg = self.legs.between[paths.last]
        tail, task = np.nonzero(~visited & (paths.cost[:, None] + leg <= self.cap))
        leg = leg[tail, task]
        value = paths.value[tail] + self.sigma * leg - np.array(self.prices.task)[task]
        value += self._charges(visited)[tail, task] if self.prices.sets else 0.0
        longer = _Paths(_with(paths.words[tail], task), task, paths.cost[tail] + leg, value)
        return longer.of(self._hopeful(longer))

    def _charges(self, visited: Bools) -> Floats:
        """Return what the sets charge where a task is visited next, (p, n) [s]."""
        sets = np.array(self.prices.sets)
        member = np.zeros((len(sets), visited.shape[1]))
        np.put_along_axis(member, sets, np.array(self.prices.rho)[:, None], axis=1)
        one = visited[:, sets].sum(axis=2) == 1
        return np.asarray(one @ member)

    def _hopeful(self, paths: _Paths) -> Ints:
        """Return the paths that may still become tours within cap and threshold."""
        near = self.bounds.near[paths.last]
        rows = np.arange(paths.last.size)[:, None]
        seen = (paths.words[rows, near >> 6] >> (near & 63).astype(np.uint64)) & np.uint64(1)
        memory = (seen.astype(np.int64) << np.arange(near.shape[1])).sum(axis=1)
        left = self.bounds.least[paths.last, self.bounds.bins_left(self.cap - paths.cost), memory]
        return np.flatnonzero(paths.value + left <= self.threshold)


def _with(words: NDArray[np.uint64], task: Ints) -> NDArray[np.uint64]:
    """Return the sets with a task more."""
    words[np.arange(task.size), task >> 6] |= np.uint64(1) << (task & 63).astype(np.uint64)
    return words


def _joined(parts: list[_Paths], n: int) -> _Paths:
    none = _Paths(np.zeros((0, (n + 63) // 64), np.uint64), np.zeros(0, np.int64), np.zeros(0), np.zeros(0))
    parts = [none, *parts]
    words, last = np.concatenate([p.words for p in parts]), np.concatenate([p.last for p in parts])
    return _Paths(words, last, np.concatenate([p.cost for p in parts]), np.concatenate([p.value for p in parts]))
