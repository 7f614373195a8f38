r"""The bound of a case at any prices: what a proof over arcs rests on, whatever the linear programme's tolerances.

With c_ijk in units of a cost U, for σ_k ≥ 0 with Σσ ≤ 1, λ_k ≥ 0, any potentials w_k(i) (the depot's, w_k(k), too),
u_k ≤ 0, ρ_e ≥ 0 of the sets of arcs e a case needs, μ ≥ 0 of cuts (k, S, v), const6 in its depot-linked form, and ν ≥ 0
of cuts Σ_k Σ_ij a_ij θ_ijk ≥ b of all UAVs (`joint.py`),

    r_ijk = (σ_k + λ_k) c_ijk + w_k(i) − w_k(j) − Σ{μ : i ∉ S, j ∈ S} + Σ{μ : j = v} − Σ{ρ_e : ij ∈ e} − Σν a_ij

and r_kik − u_k where the arc leaves the depot. Every task is entered once, and every UAV flies home at most once, so

    C_max / U ≥ Σρ + Σν b + Σu − Σ_k λ_k L_k / U + Σ_j min_{i,k} r_ijk + Σ_k min(0, min_i r_ikk)

over the arcs that the case allows. Rounding: no r is a sum of more numbers than cuts, needs and 6, each at most `size`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.arcs.case import Case
from formulations.routing.arcs.joint import Joint
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


class Cuts(NamedTuple):
    """Cuts of const6: `uav` (c,), `tasks` S (c, n + 1), its last entry false, `visited` v (c,)."""

    uav: Ints
    tasks: Bools
    visited: Ints

    @classmethod
    def none(cls, n_tasks: int) -> Cuts:
        """Return no cuts."""
        return cls(np.zeros(0, np.int64), np.zeros((0, n_tasks + 1), np.bool_), np.zeros(0, np.int64))

    def of(self, at: Ints | Bools) -> Cuts:
        """Return some of them."""
        return Cuts(self.uav[at], self.tasks[at], self.visited[at])

    def and_also(self, other: Cuts) -> Cuts:
        """Return these and others."""
        return Cuts(*(np.concatenate(parts) for parts in zip(self, other, strict=True)))


class ArcPrices(NamedTuple):
    """σ (m,), λ (m,), w (m, n + 1), the depot last, u (m,), cuts with their μ (c,), ρ of what the case needs, and cuts
    of all UAVs with their ν.

    σ and λ are shares, the others in units of U.
    """

    sigma: Floats
    endurance: Floats
    potential: Floats
    use: Floats
    cuts: Cuts
    mu: Floats
    rho: Floats
    joint: tuple[Joint, ...]
    nu: Floats


def reduced_costs(prices: ArcPrices, cost: Floats, case: Case) -> Floats:
    """Return r (m, n + 1, n + 1) of all arcs of finite cost; infinite elsewhere. `cost` alike, in units of U."""
    w, n = prices.potential, cost.shape[1] - 1
    paid = prices.sigma + prices.endurance
    reduced = np.where(np.isfinite(cost), cost, 0.0) * paid[:, None, None] + w[:, :, None] - w[:, None, :]
    reduced[:, n] -= prices.use[:, None]
    _charge(reduced, *prices.cuts, prices.mu)
    for arcs, rho in zip(case.needed, prices.rho, strict=True):
        for i, j in arcs:
            reduced[:, i, j] -= rho
    for joint, nu in zip(prices.joint, prices.nu, strict=True):
        reduced -= nu * joint.entries
    return np.where(np.isfinite(cost), reduced, np.inf)


def bound_at(prices: ArcPrices, reduced: Floats, limits: Floats, lost: Bools) -> float:
    """Return the bound in units of U; `limits` L (m,) in the same, `lost` arcs (m, n + 1, n + 1)."""
    n = reduced.shape[1] - 1
    left = np.where(lost, np.inf, reduced)
    entered = left[:, :, :n].min(axis=(0, 1))
    if not np.isfinite(entered).all():
        return np.inf
    home = np.minimum(left[:, :, n].min(axis=1), 0.0)
    of_limits = float(prices.endurance[prices.endurance > 0] @ limits[prices.endurance > 0])
    of_joint = np.array([joint.least for joint in prices.joint]) * prices.nu
    value = float(prices.rho.sum() + of_joint.sum() + prices.use.sum() + entered.sum() + home.sum()) - of_limits
    size = 2.0 + 2 * np.abs(prices.potential).max() + prices.mu.sum() + prices.rho.sum() + np.abs(prices.use).max()
    size += prices.endurance.max() + of_limits + prices.nu.sum() + np.abs(of_joint).sum()
    terms = prices.mu.size + prices.rho.size + prices.nu.size + 6
    return value - 4 * (n + prices.use.size + 4) * terms * 2.0**-53 * float(size)


@njit(cache=True)
def _charge(reduced: Floats, uav: Ints, tasks: Bools, visited: Ints, mu: Floats) -> None:
    """Take off what cuts say of arcs, in place."""
    size = reduced.shape[1]
    for c in range(mu.size):
        k = uav[c]
        for i in range(size):
            if not tasks[c, i]:
                for j in range(size):
                    if tasks[c, j]:
                        reduced[k, i, j] -= mu[c]
            reduced[k, i, visited[c]] += mu[c]
