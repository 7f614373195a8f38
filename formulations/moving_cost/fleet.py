"""Fleets: moving costs of UAVs that differ, of tasks that take time, and of tours that end elsewhere.

One planning for each speed gives c_ijg, the cost of the cheapest path of a UAV of class g. Nothing else needs a noun of
its own: with n tasks, service s_i [s] at task i and 0 at depots, a leg costs

    c'_ijg = c_ijg + (s_i + s_j)/2          half on the way in, half on the way out: symmetric costs stay symmetric
    c'_ikg = min_d c_idg + s_i/2            home, where a tour may end at any depot d
    c'_ikg = s_i/2                          home, where it ends at its last task

A closed tour then costs flight and service together, and every solver that takes c takes c'. Node potentials, which
make costs positive in a tail wind stronger than the UAV, come after that, since they cancel on closed tours only; for
tours that end elsewhere there may be no such potential, so negative costs are refused there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from instances import Instance, Travel
from instances.arrays import Floats, Ints
from instances.fleet import Fleet, Return
from instances.scenario import Scenario


def classes_of(scenario: Scenario) -> tuple[list[float], Ints]:
    """Return the speeds of a scenario's UAVs [m/s], each once, in the order of the UAVs; and the class of each UAV."""
    if scenario.fleet.speeds is None:
        return [scenario.speed], np.zeros(scenario.n_depots, dtype=np.int64)
    each = scenario.fleet.speeds.tolist()
    speeds = list(dict.fromkeys(each))
    return speeds, np.array([speeds.index(speed) for speed in each])


def at_speed(scenario: Scenario, speed: float) -> Scenario:
    """Return the scenario with all UAVs alike, at this speed [m/s]."""
    return replace(scenario, speed=speed, fleet=Fleet())


def leg_costs(scenario: Scenario, cost: Floats) -> Floats:
    """Return c' [s] of the costs c of paths, (N, N), as at the top of this file."""
    n, fleet = scenario.n_tasks, scenario.fleet
    legs = cost.copy()
    if fleet.returns is Return.ANY:
        legs[:n, n:] = cost[:n, n:].min(axis=1, keepdims=True)
    elif fleet.returns is Return.NONE:
        legs[:n, n:] = 0.0
    if np.any(fleet.service):
        half = np.zeros(len(cost))
        half[:n] = np.asarray(fleet.service) / 2
        legs += half[:, None] + half[None, :]
        np.fill_diagonal(legs, 0.0)
    return legs


def fleet_instance(scenario: Scenario, costs: Sequence[Floats], provenance: Mapping[str, Any]) -> Instance:
    """Return the instance whose legs cost `costs` [s], (N, N) for each class of `classes_of`."""
    name, n, m, endurance = scenario.name, scenario.n_tasks, scenario.n_depots, scenario.fleet.endurance
    if len(costs) == 1:
        return Instance(name, costs[0], n, m, scenario.points, provenance, endurance=endurance)
    travel = Travel(np.stack(costs)[:, None], classes_of(scenario)[1])
    return Instance.of_travel(name, travel, n, coordinates=scenario.points, provenance=provenance, endurance=endurance)
