"""Costs in whole numbers for CP-SAT, so that bound and objective stay true for the float instance.

CP-SAT works on integers. With a scale s and C_int(k) = Σ ⌊s·c_ij⌋ over the arcs of tour k:

* ⌊s·c_ij⌋ ≤ s·c_ij, so C_int ≤ s·C for any routes, and **z_int / s is a lower bound** of the float problem
  whenever z_int is one of the integer problem. Rounding to nearest would not give that.
* a tour of UAV k has at most n + 1 arcs, each losing less than 1, so s·C − C_int < n + 1. Routes that are optimal
  for the integers are therefore within **(n + 1) / s** of the float optimum: the tolerance of OPTIMAL.

s is a power of two: s·c is then exact in floating point, and the floor is the floor of the true product. The sum of a
tour in floating point may be off by (n + 1) roundings, which bound and tolerance allow for.

s follows the incumbent U: s·U lies in [2^23, 2^24), so the tolerance is about (n + 1)·1e-7 of the cost whatever its
unit (1e-6 or 1e9). More digits cost time: CP-SAT often raises its bound in steps of the integers. An arc that costs
more than U is in no better solution; its cost is cut off just above ⌊s·U⌋, which keeps every number small. Costs are
never put on enforced rows over Booleans, whose coefficient sums past 2^31 made CP-SAT 9.15 certify a wrong optimum
(google/or-tools#5293).

Where UAVs differ each class has its costs; legs that a class cannot fly cost more than U and so are never flown.
Endurance is scaled the other way, ⌈s·L_k⌉ and a little: C_int ≤ s·C, so C_int(k) ≤ that cuts off no tour that UAV k
can fly. It does allow tours that are longer than L_k by less than the tolerance. Whoever uses the row must look at
the tours themselves, and cut off these one by one (`too_long`, ``model_solver.py``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from instances import Instance
from instances.arrays import Ints
from instances.routes import ENDURANCE_ROUNDING

UNIT_ROUNDOFF = 2.0**-53
BITS = 24
"""⌊s·U⌋ < 2^BITS."""


@dataclass(frozen=True, eq=False)
class ScaledCosts:
    """The costs of one instance as CP-SAT takes them.

    costs : ⌊s·c_ijk⌋ of each class of UAV, cut off at ``upper + 1``; int64, shape (G, n+m, n+m).
    classes : the class of each UAV, shape (m,).
    limits : the longest integer tour of each UAV, shape (m,): ``upper`` or what its endurance allows.
    exponent : s = 2^exponent.
    upper : ⌊s·U⌋ (and one more for the float sum): routes of cost ≤ U keep every integer tour ≤ upper.
    tolerance [s] : what OPTIMAL on the integers leaves open on the floats.
    rounding : relative error allowed for a tour summed in floating point.
    """

    costs: Ints
    classes: Ints
    limits: Ints
    exponent: int
    upper: int
    tolerance: float
    rounding: float

    def uav_cost(self, k: int) -> Ints:
        """Return the costs of UAV k (0..m−1), shape (n+m, n+m)."""
        return self.costs[self.classes[k]]

    def bound(self, z: float) -> float:
        """Return the lower bound [s] of the float instance that the integer lower bound `z` implies."""
        return max(0.0, math.ldexp(float(z), -self.exponent) * (1.0 - self.rounding))


def scale_costs(instance: Instance, incumbent: float) -> ScaledCosts:
    """Return the costs of `instance` scaled for routes of cost `incumbent` [s], > 0, or `worst_makespan`."""
    arcs = instance.n_tasks + 1
    exponent = min(BITS - math.frexp(incumbent)[1], 1000)
    upper = math.floor(math.ldexp(incumbent, exponent)) + 1
    cut = np.minimum(instance.class_costs, 2.0 * incumbent)  # keeps ldexp from overflowing
    costs = np.minimum(np.floor(np.ldexp(cut, exponent)), upper + 1).astype(np.int64)
    endurance = np.minimum(instance.limits * (1 + ENDURANCE_ROUNDING), 2.0 * incumbent)
    limits = np.ceil(np.ldexp(endurance, exponent)) + 1  # one more for the float sum
    rounding = (arcs + 1) * UNIT_ROUNDOFF
    tolerance = math.ldexp(float(arcs), -exponent) + 4 * rounding * incumbent
    return ScaledCosts(
        costs, instance.classes, np.minimum(limits, upper).astype(np.int64), exponent, upper, tolerance, rounding
    )
