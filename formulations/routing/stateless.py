"""Instances without their states: each leg at the least of all states at its ends.

That is a relaxation, and what a plan that ignores the states is made of.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from instances import Instance, Travel


def stateless(instance: Instance) -> Instance:
    """Return `instance` with one state a node: what each class of UAV pays at least for a leg."""
    if instance.travel is None or "states" not in instance.axes:
        return instance
    first = np.searchsorted(instance.travel.nodes, np.arange(instance.n_nodes))
    cost = np.minimum.reduceat(np.minimum.reduceat(instance.travel.cost, first, axis=2), first, axis=3)
    cost[:, :, np.arange(instance.n_nodes), np.arange(instance.n_nodes)] = 0.0
    return replace(instance, travel=Travel(cost, instance.travel.classes, instance.travel.departures))
