"""Moving costs for the kernels, readable along rows in both directions.

A kernel that tries many places for one task v needs all c_vu and all c_uv: two rows that stay in the processor's cache,
where a column would not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from instances.arrays import Floats

Nodes = NDArray[np.int32]
"""Node numbers: tasks 0..n−1, then depots."""

_FEW = 8
"""Rows that show most asymmetric matrices to be so, before all are compared."""


class Costs(NamedTuple):
    """out[i, j] = into[j, i] = c_ij [s], both (n+m, n+m); one and the same array where costs are symmetric."""

    out: Floats
    into: Floats


def both_ways(cost: Floats) -> Costs:
    """Return Costs of the matrix `cost`; an asymmetric one is copied once, transposed."""
    few = cost[:_FEW]
    if np.array_equal(few, cost[:, :_FEW].T) and np.array_equal(cost, cost.T):
        return Costs(cost, cost)
    into = np.ascontiguousarray(cost.T)
    into.setflags(write=False)
    return Costs(cost, into)
