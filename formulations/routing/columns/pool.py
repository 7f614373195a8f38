"""The pool: all tours that matter, listed; pricing is a scan, and reduced costs shorten the list."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.cuts import by_task
from formulations.routing.columns.labelling import has, path
from formulations.routing.columns.pricing import Column, Duals, Priced


@dataclass(frozen=True)
class Pool:
    """Tours: `uav` (p,), `visited` (p, words), `cost` (p,) [s], and the labels they end in.

    Orders are read from the labels, kept per UAV in `last` and `parent`, only where needed.
    """

    n_uavs: int
    uav: NDArray[np.int64]
    visited: NDArray[np.uint64]
    cost: NDArray[np.float64]
    label: NDArray[np.int64]
    last: list[NDArray[np.int16]]
    parent: list[NDArray[np.int32]]

    @property
    def size(self) -> int:
        """Number of tours."""
        return self.uav.size

    def column(self, p: int) -> Column:
        """Return tour p with its order."""
        k, label = int(self.uav[p]), int(self.label[p])
        return Column(k, path(self.last[k], self.parent[k], label), float(self.cost[p]))

    def only(self, keep: NDArray[np.bool_]) -> Pool:
        """Return the pool of the tours chosen."""
        return Pool(
            self.n_uavs, self.uav[keep], self.visited[keep], self.cost[keep], self.label[keep], self.last, self.parent
        )

    def holds(self, task: int) -> NDArray[np.bool_]:
        """Say which tours visit `task`."""
        return (self.visited[:, task >> 6] >> np.uint64(task & 63)) & np.uint64(1) != 0

    def without(self, task: int, uavs: list[int]) -> Pool:
        """Drop the tours in which one of `uavs` visits `task`."""
        return self.only(~(self.holds(task) & np.isin(self.uav, uavs)))

    def under(self, cap: float) -> Pool:
        """Keep the tours of cost ≤ `cap`."""
        return self.only(self.cost <= cap)

    def values(self, duals: Duals) -> NDArray[np.float64]:
        """Return all reduced costs [s]."""
        partners, rho = by_task(duals.cuts, duals.rho, duals.price.size)
        return _values(self.uav, self.visited, self.cost, duals.price, duals.sigma, partners, rho)

    def needed(self, duals: Duals, bound: float, least: NDArray[np.float64], cap: float) -> Pool:
        """Drop the tours that cannot be in routes below `cap`: L − r_k + r(p) exceeds it (L = `bound`)."""
        return self.only(self.values(duals) <= cap - bound + least[self.uav])


@numba.njit(cache=True)
def _values(uav, visited, cost, price, sigma, partners, rho):  # type: ignore[no-untyped-def]
    n = price.size
    value = np.empty(cost.size)
    for p in range(cost.size):
        words = visited[p]
        total = sigma[uav[p]] * cost[p]
        for i in range(n):
            if has(words, i):
                total -= price[i]
                for q in range(rho.shape[1]):
                    j, k = partners[i, q, 0], partners[i, q, 1]
                    # the first two members of a cut that a tour holds pay for it, once
                    if rho[i, q] > 0 and ((j < i and has(words, j)) != (k < i and has(words, k))):
                        total += rho[i, q]
        value[p] = total
    return value


class PoolPricer:
    """Prices by scanning a pool: the same questions as `Pricer`, always answered completely."""

    wanted = 150

    def __init__(self, pool: Pool) -> None:
        self.pool = pool
        self.n_uavs = pool.n_uavs
        self._of = [np.flatnonzero(pool.uav == k) for k in range(pool.n_uavs)]
        self._values: tuple[Duals | None, NDArray[np.float64]] = (None, np.zeros(0))

    def price(self, k: int, duals: Duals, threshold: float, want: int) -> Priced:
        """Return UAV k's best `want` columns of reduced cost below `threshold`, and the least of all."""
        if self._values[0] is not duals:
            self._values = (duals, self.pool.values(duals))
        values = self._values[1][self._of[k]]
        below = np.flatnonzero(values < threshold)
        best = below[np.argsort(values[below], kind="stable")[:want]]
        columns = [self.pool.column(int(self._of[k][p])) for p in best]
        return Priced(float(values.min(initial=np.inf)), columns, True)
