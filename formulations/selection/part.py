"""Part of an instance: some of its tasks, all of its UAVs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from instances import Instance
from instances.travel import Travel


def only(instance: Instance, tasks: Sequence[int]) -> Instance:
    """Return the instance of `tasks` alone, numbered in this order; ValueError where costs know times or states."""
    nodes = np.array([*tasks, *instance.depots])
    travel = None
    if instance.travel is not None:
        travel = Travel(instance.class_costs[:, None][:, :, nodes][:, :, :, nodes], instance.classes)
    return Instance(
        instance.name,
        instance.cost[np.ix_(nodes, nodes)] if travel is None else travel.least(),
        len(tasks),
        instance.n_depots,
        None if instance.coordinates is None else instance.coordinates[nodes],
        {"part_of": instance.digest, "tasks": list(tasks)},
        travel,
        instance.endurance,
    )
