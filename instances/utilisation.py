"""How much of a fleet routes use: of its time, and of its batteries."""

from __future__ import annotations

import numpy as np

from instances.arrays import Floats
from instances.instance import Instance


def utilisation(costs: Floats) -> Floats:
    """Return C_k / C_max of each UAV for tours of C_k = `costs` [s], shape (m,); 0 for all where none flies."""
    longest = costs.max(initial=0.0)
    return costs / longest if longest > 0 else np.zeros(len(costs))


def endurance_margins(instance: Instance, flights: Floats) -> Floats:
    """Return what is left of each UAV's endurance L_k after `flights` [s], shapes (m,), a share: 1 where unlimited.

    A flight is C_k without the wait before take-off (`instances.take_offs`).
    """
    return 1.0 - flights / instance.limits
