"""What the kernels of states read: legs both ways round, and the least of each, which tells most insertions off."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from instances import Instance
from instances.arrays import Floats, Ints

Singles = NDArray[np.float32]
"""Costs in single precision: twice as many fit into the cache. Routes are priced anew, in double, by the recorder."""


class StateCosts(NamedTuple):
    """Legs between states, nodes in their order, in units of the dearest leg that can be flown.

    legs (G, S, S) : from row to column. back (G, S, S) : the same from column to row.
    least (G, N, N) : of the legs between nodes. first (N + 1,) : the states of a node begin there.
    classes (m,) : class of each UAV. closed : whether a tour ends in the state of its depot that it began in.
    """

    legs: Singles
    back: Singles
    least: Floats
    first: Ints
    classes: Ints
    closed: bool


def state_costs(instance: Instance) -> StateCosts:
    """Return the costs of an instance with states; a leg that cannot be flown costs more than any tour."""
    travel = instance.travel
    assert travel is not None
    cost = travel.cost[:, 0]
    unit = float(cost[np.isfinite(cost)].max(initial=0.0)) or 1.0
    scaled = np.minimum(cost / unit, 2.0 * (instance.n_tasks + 1))
    first = np.searchsorted(travel.nodes, np.arange(instance.n_nodes + 1)).astype(np.int64)
    least = np.minimum.reduceat(np.minimum.reduceat(scaled, first[:-1], axis=1), first[:-1], axis=2)
    legs = scaled.astype(np.float32)
    back = np.ascontiguousarray(legs.transpose(0, 2, 1))
    return StateCosts(legs, back, least, first, np.array(travel.classes), travel.closed)
