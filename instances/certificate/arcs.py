"""The check of a case closed at prices of arcs: the least that routes of it could cost there, computed anew.

For any σ ≥ 0, potentials w, u ≤ 0, μ ≥ 0 and ρ ≥ 0, let

    r_k(i, j) = σ_k c_k(i, j) + w_k(i) − w_k(j) − Σ{μ : the arc enters the tasks of a cut of UAV k}
                + Σ{μ : j is what such a cut says is visited} − Σ{ρ : the arc is one of those needed} − Σν a(i, j),

less u_k where it leaves the depot, for cuts Σa ≥ b of what all UAVs fly together (`joint`). Along the tours of any
routes of the case the potentials cancel, a cut takes off no less than it adds, what is needed is flown at least once,
and a UAV leaves its depot at most once. Every task is entered once, and every UAV comes home at most once. So, over the
arcs that the case allows,

    Σ_k σ_k C_k ≥ Σρ + Σν b + Σu + Σ_j min_{k, i} r_k(i, j) + Σ_k min(0, min_i r_k(i, depot)),

and where that is above Σ_k σ_k U_k, some C_k is above U_k: no routes of the case keep all tours within the U_k.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from instances.arrays import Bools, Floats
from instances.certificate.file import ArcPrices, Cut
from instances.certificate.tours import UavLegs
from instances.errors import InputError


def sound_arcs(at: str, prices: ArcPrices, n: int, m: int, n_cuts: int, n_joint: int) -> None:
    """Refuse prices of other sizes or signs than they must have; `at` says where they are."""
    paid = [*prices.mu, *prices.rho, *prices.nu]
    numbers = [*prices.uav, *prices.use, *paid, *(w for row in prices.potential for w in row)]
    sizes = {len(row) for row in prices.potential}, len(prices.potential), len(prices.uav), len(prices.use)
    sizes_of_cuts = len(prices.mu) == len(prices.cuts) and len(prices.nu) == len(prices.joint)
    if sizes != ({n + 1}, m, m, m) or not sizes_of_cuts or not np.isfinite(numbers).all():
        raise InputError(f"{at}: prices of {m} UAVs, {n + 1} nodes each and each cut must be finite numbers")
    if min(prices.uav) < 0 or max(prices.use) > 0 or min(paid, default=0.0) < 0:
        raise InputError(f"{at}: prices of UAVs, cuts and needs must not be negative, those of use not positive")
    if not all(0 <= cut < n_cuts for cut in prices.cuts):
        raise InputError(f"{at}: cuts are 0..{n_cuts - 1}")
    if not all(0 <= cut < n_joint for cut in prices.joint):
        raise InputError(f"{at}: cuts of all UAVs are 0..{n_joint - 1}")


def least_of_arcs(
    legs: Sequence[UavLegs],
    caps: Floats,
    prices: ArcPrices,
    cuts: Sequence[Cut],
    joint: Sequence[tuple[Floats, float]],
    forbidden: Bools,
    banned: Sequence[tuple[int, int]],
    needed: Sequence[Sequence[tuple[int, int]]],
) -> float:
    """Return what is proved of Σ_k σ_k (C_k − U_k) [s] in a case, less rounding: above 0 the case is closed.

    caps (m,) : U_k [s]; joint : a (n + 1, n + 1) and b of cuts of all UAVs; forbidden (m, n) : what UAVs may not visit;
    banned : arcs that nobody flies; needed : arcs of which one is flown.
    """
    (m, n), w = forbidden.shape, np.array(prices.potential)
    cost = np.full((m, n + 1, n + 1), np.inf)
    for k, of_uav in enumerate(legs):
        allowed = of_uav.without(forbidden[k])
        cost[k, :n, :n], cost[k, n, :n], cost[k, :n, n] = allowed.between, allowed.out, allowed.home
    for i, j in banned:
        cost[:, i, j] = np.inf
    cost[cost > caps[:, None, None]] = np.inf
    flown = np.isfinite(cost)
    reduced = np.array(prices.uav)[:, None, None] * np.where(flown, cost, 0.0) + w[:, :, None] - w[:, None, :]
    reduced[:, n] -= np.array(prices.use)[:, None]
    for number, mu in zip(prices.cuts, prices.mu, strict=True):
        cut = cuts[number]
        inside = np.zeros(n + 1, np.bool_)
        inside[list(cut.tasks)] = True
        reduced[cut.uav][np.ix_(~inside, inside)] -= mu
        reduced[cut.uav, :, cut.visited] += mu
    for arcs, rho in zip(needed, prices.rho, strict=True):
        for i, j in arcs:
            reduced[:, i, j] -= rho
    of_joint = 0.0, 0.0
    for number, nu in zip(prices.joint, prices.nu, strict=True):
        row, least = joint[number]
        reduced -= nu * row
        of_joint = of_joint[0] + nu * least, of_joint[1] + nu * (1.0 + abs(least))
    reduced = np.where(flown, reduced, np.inf)
    entered, home = reduced[:, :, :n].min(axis=(0, 1)), np.minimum(reduced[:, :, n].min(axis=1), 0.0)
    if np.isinf(entered).any():  # a task that nobody may visit
        return np.inf
    most = float(np.array(prices.uav) @ caps)
    value = float(np.sum(prices.rho) + of_joint[0] + np.sum(prices.use) + entered.sum() + home.sum()) - most
    terms = len(prices.mu) + len(prices.rho) + len(prices.nu) + 8
    size = (
        most
        + of_joint[1]
        + 2 * float(np.abs(w).max())
        + float(np.sum(prices.mu) + np.sum(prices.rho) - np.sum(prices.use))
    )
    return value - 8 * (n + m + 2) * terms * 2.0**-53 * size
