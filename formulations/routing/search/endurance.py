"""Endurance by scaled costs: a search for the shortest longest tour keeps C_k ≤ L_k without knowing of it.

With every UAV's costs multiplied by R / min(R, L_k) for a reference R [s],

    a tour takes at most R by scaled costs  ⇔  C_k ≤ min(R, L_k)

so routes of which no scaled tour exceeds R are no longer than R and within all endurances, and there are none where
the least longest scaled tour is above R. A search begins with an R beyond what any tour takes, where the longest share
C_k / L_k counts; whenever it has found routes that can be flown R falls to their C_max, and it goes on for better
ones. UAVs with L_k ≥ R are not scaled, so what is minimised becomes C_max itself.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.search.costs import Costs, FleetCosts, forbidden
from formulations.routing.search.energy import TINY
from instances import Instance
from instances.arrays import Floats
from instances.routes import ENDURANCE_ROUNDING

_LARGEST = 1e100
"""Largest scale: products of it and a cost stay finite."""
_ROUNDING = 1e-12
"""Share by which tours scaled and scaled back may differ."""


class Endurance:
    """The endurances of an instance's UAVs, and costs of it that follow a reference R.

    costs : those given, with a scale of their own, 1 until `refer` is called.
    limited : whether any UAV's endurance is; nothing is scaled else.
    most [s] : an R beyond what any tour takes.
    reference [s] : R.
    """

    def __init__(self, instance: Instance, costs: Costs) -> None:
        self.costs = costs._replace(scale=np.ones(instance.n_depots)) if isinstance(costs, FleetCosts) else costs
        self.limited = instance.endurance is not None
        self.most = forbidden(instance) if self.limited else np.inf
        self.reference = np.inf
        self._limits = instance.limits * (1 + ENDURANCE_ROUNDING)

    def refer(self, reference: float) -> None:
        """Scale costs by R = `reference` [s]; tours priced before are then to be priced anew (`reprice`)."""
        if self.limited and isinstance(self.costs, FleetCosts):
            self.reference = max(reference, TINY)
            self.costs.scale[:] = np.minimum(self.reference / np.minimum(self.reference, self._limits), _LARGEST)

    def follow(self, lengths: Floats) -> bool:
        """Let R fall to the C_max of tours of scaled costs `lengths` (m,) [s] where they are within all endurances.

        Return whether scales may have changed; tours priced before are then to be priced anew.
        """
        if not isinstance(self.costs, FleetCosts) or (self.costs.scale == 1.0).all():
            return False
        longest = float((lengths / self.costs.scale).max())
        if longest >= (1.0 - _ROUNDING) * self.reference or lengths.max() > self.reference:
            return False
        self.refer(longest)
        return True
