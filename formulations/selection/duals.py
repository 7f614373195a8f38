"""Columns, duals and the Lagrangian bound of team orienteering.

With y_i = 1 where task i is selected, λ_p = 1 where tour p is flown by a UAV of its group g, overestimates
(a_A, w_A) of the worth (`overestimates.py`) and subset-row cuts S (`routing/columns/cuts.py`):

    max θ      θ ≤ a_A + Σ_i w_Ai y_i                       every overestimate A      dual α_A ≥ 0
               θ ≤ Σ_p f(p) λ_p                             where f is subadditive    dual β ≥ 0, β + Σ α_A = 1
               Σ_p a_ip λ_p = y_i ∈ [lo_i, hi_i]            every task i              dual v_i, any sign
               Σ_{p∈g} λ_p ≤ m_g                            every group g             dual μ_g ≥ 0
               Σ_p ⌊|S∩p|/2⌋ λ_p ≤ 1                        every cut S               dual ρ_S ≥ 0

The second row knows that the tasks of one tour tell some things twice, which fractional y do not show; it needs the
tours listed, as f(p) is no sum over tasks. For any such α and β, any v and any ρ ≥ 0, every selection that the node
allows is worth at most

    U = Σ_A α_A a_A + Σ_i max_{y_i} (Σ_A α_A w_Ai − v_i) y_i + Σ_S ρ_S + Σ_g m_g max(0, −r_g),

r_g a lower bound on the reduced cost −β f(p) − Σ_{i∈p} v_i + Σ_S ρ_S ⌊|S∩p|/2⌋ of the tours of group g. So the duals
need not be optimal or exact; rounding enters only in these sums, and `Duals.bound` covers it. With tour p in it a
selection is worth at most U + min(0, r_g) − r(p): tours beyond are in no better selection.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from formulations.routing.columns.cuts import Cut, TaskCuts, by_task
from formulations.selection.overestimates import Overestimate
from instances.arrays import Floats


@dataclass(frozen=True)
class Column:
    """One tour of any UAV of a group: `tasks` in flying order."""

    group: int
    tasks: tuple[int, ...]


@dataclass(frozen=True)
class Duals:
    """`price` v (n,), `alpha` of the overestimates, `rent` μ of the groups, `rho` of the cuts, `beta` of the tour row.

    Overestimates and cuts are only ever appended.
    """

    price: Floats
    alpha: Floats
    rent: Floats
    rho: Floats
    overestimates: tuple[Overestimate, ...]
    cuts: tuple[Cut, ...]
    beta: float = 0.0

    @cached_property
    def by_task(self) -> TaskCuts:
        """The cuts of each task and their prices."""
        return by_task(self.cuts, self.rho, self.price.size)

    @cached_property
    def slope(self) -> Floats:
        """Σ α_A w_A, (n,)."""
        return np.asarray(sum(a * over.slope for a, over in zip(self.alpha, self.overestimates, strict=True)))

    @cached_property
    def constant(self) -> float:
        """Σ α_A a_A."""
        return float(sum(a * over.constant for a, over in zip(self.alpha, self.overestimates, strict=True)))

    def towards(self, other: Duals, step: float) -> Duals:
        """Return the point `step` of the way from these duals to `other` (a convex combination, so again duals)."""
        pairs = ((self.price, other.price), (self.alpha, other.alpha), (self.rent, other.rent), (self.rho, other.rho))
        price, alpha, rent, rho = ((1 - step) * _padded(a, b) + step * b for a, b in pairs)
        beta = (1 - step) * self.beta + step * other.beta
        return Duals(price, alpha, rent, rho, other.overestimates, other.cuts, beta)

    def bound(self, least: Floats, counts: Sequence[int], lo: Floats, hi: Floats) -> float:
        """Return U for lower bounds `least` (G,) on reduced costs, raised by more than all rounding."""
        margin = self.slope - self.price
        tasks = float(np.where(margin > 0, margin * hi, margin * lo).sum())
        tours = float(np.maximum(0.0, -least) @ np.array(counts))
        size = (
            sum(float(np.abs(part).sum()) for part in (self.slope, self.price, self.rho)) + abs(self.constant) + tours
        )
        constants = sum(abs(a * over.constant) for a, over in zip(self.alpha, self.overestimates, strict=True))
        rounding = 40 * (len(counts) + 1) * (self.price.size + 2) * 2.0**-53 * (size + constants)
        return self.constant + tasks + float(self.rho.sum()) + tours + rounding


@dataclass(frozen=True)
class DualBound:
    """A Lagrangian bound: `value` U, the `duals` it holds at, r_g in `least` (G,)."""

    value: float
    duals: Duals
    least: Floats

    def allowed(self, wanted: float) -> Floats:
        """Return the reduced costs, (G,), above which a tour is in no selection worth `wanted`."""
        return self.value - wanted + np.minimum(0.0, self.least)


def _padded(short: Floats, long: Floats) -> Floats:
    padded = np.zeros(long.size)
    padded[: short.size] = short
    return padded
