"""A clock stopped: the instance whose costs are those of one departure, and what a plan for it is worth by the clock.

A plan made for the wind of take-off flies the same tours; by the clock they take something else than it promised. Each
tour can be flown either way round, which costs nothing to try and, where costs change, is worth trying even if the plan
was made for costs that do not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from instances.arrays import Floats
from instances.instance import Instance
from instances.routes import Routes, makespan, past_endurance, take_offs, tour_costs
from instances.travel import Travel


def costs_at(travel: Travel, time: float) -> Floats:
    """Return the costs (G, S, S) [s] of legs that begin at `time` [s]."""
    knots, cost = travel.departures, travel.cost
    after = int(np.searchsorted(knots, time, side="right"))
    if after == len(knots):
        return cost[:, -1]
    share = (time - knots[after - 1]) / (knots[after] - knots[after - 1])
    with np.errstate(invalid="ignore"):
        between = cost[:, after - 1] + share * (cost[:, after] - cost[:, after - 1])
    return np.where(np.isnan(between), cost[:, after - 1], between) if share > 0 else cost[:, after - 1]


def frozen(instance: Instance, time: float = 0.0) -> Instance:
    """Return the instance whose costs are at all times those of legs that begin at `time` [s]."""
    travel = instance.travel
    if travel is None or "time" not in travel.axes:
        return instance
    still = Travel(costs_at(travel, time)[:, None], travel.classes, nodes=travel.nodes)
    more = {"coordinates": instance.coordinates, "provenance": instance.provenance, "endurance": instance.endurance}
    return Instance.of_travel(instance.name, still, instance.n_tasks, **more)


def guiding(instance: Instance, time: float = 0.0) -> Instance:
    """Return `frozen` for searches to go by: without endurance where UAVs may wait, which it then depends on."""
    still = frozen(instance, time)
    return replace(still, endurance=None) if "window" in instance.axes else still


def in_better_directions(instance: Instance, routes: Routes) -> Routes:
    """Return `routes`, each tour flown the way round that is home first, within endurance if one way is."""
    back = tuple(route[::-1] for route in routes)
    ways = zip(routes, back, _worth(instance, routes), _worth(instance, back), strict=True)
    return tuple(b if there > other else a for a, b, there, other in ways)


def _worth(instance: Instance, routes: Routes) -> list[tuple[bool, float]]:
    """Return of each tour whether it is past endurance, and C_k [s]: the less, the better."""
    costs = tour_costs(instance, routes)
    past = past_endurance(instance, costs - take_offs(instance, routes))
    return list(zip(past.tolist(), costs.tolist(), strict=True))


@dataclass(frozen=True)
class StaticPlan:
    """What a plan for the costs of take-off is worth.

    routes : in the better directions; promised [s] : their longest tour as planned; taken [s] : by the clock, flown as
    planned; directed [s] : by the clock, each tour in the better direction.
    """

    routes: Routes
    promised: float
    taken: float
    directed: float


def judged(instance: Instance, routes: Routes) -> StaticPlan:
    """Return what `routes`, planned for the costs of take-off, are worth by the clock."""
    better = in_better_directions(instance, routes)
    promised = makespan(frozen(instance), routes)
    return StaticPlan(better, promised, makespan(instance, routes), makespan(instance, better))
