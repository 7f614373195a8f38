"""How much the wind matters for tours.

A potential wind w = ∇φ adds (φ_i − φ_j)/v0² to every leg, which cancels along a closed tour: it changes no tour and no
allocation. What matters is the vorticity, and what it leaves in the costs: the asymmetry that no node potentials
explain. That is so of energies; to flight times any wind matters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.moving_cost.field import search_field
from formulations.moving_cost.method import Query
from instances.arrays import Floats
from instances.moving_cost import CostKind


@dataclass(frozen=True)
class WindEffect:
    """How much the wind matters.

    max_ratio : max |w|/v0 in the region. rms_curl [1/s] : root mean square vorticity.
    asymmetry : mean |c_ij − c_ji| over mean (c_ij + c_ji).
    rotational_asymmetry : the same after the best potential part p_j − p_i is taken away; for energies 0 means that
        the wind changes no closed tour.
    """

    max_ratio: float
    rms_curl: float
    asymmetry: float
    rotational_asymmetry: float

    def summary(self, kind: CostKind = CostKind.ENERGY) -> str:
        """One line for people; kind : of the costs."""
        as_good = kind is CostKind.ENERGY and self.rotational_asymmetry <= 1e-4
        verdict = "; the wind is as good as a potential: it changes no tour" if as_good else ""
        return (
            f"wind: max |w|/v0 {self.max_ratio:.3f}, rms curl {self.rms_curl:.2e} 1/s, cost asymmetry "
            f"{self.asymmetry:.2%}, beyond the potential part {self.rotational_asymmetry:.3%}{verdict}"
        )


def wind_effect(query: Query, cost: Floats) -> WindEffect:
    """Return how much the wind of `query` matters for the costs [s] it led to, shape (N, N)."""
    field = search_field(query.measure, query.region)
    half = (cost - cost.T) / 2
    p = half.mean(axis=1)  # least squares fit of p_i − p_j
    mean = float(((cost + cost.T) / 2).mean())
    asymmetry, left = (
        float(np.abs(a).mean()) / mean if mean > 0 else 0.0 for a in (half, half - (p[:, None] - p[None]))
    )
    return WindEffect(field.max_speed / query.v0, field.rms_vorticity, asymmetry, left)
