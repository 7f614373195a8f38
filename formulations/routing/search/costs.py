"""Moving costs as the kernels read them: one matrix where the UAVs are alike, one for each class where they differ.

Costs are readable along rows in both directions: a kernel that tries many places for one task v needs all c_vu and all
c_uv, two rows that stay in the processor's cache, where a column would not.

Kernels ask for `leg` and `leg_into` of a UAV and are compiled for each kind of costs that is used: for UAVs that are
alike the number of the UAV is never looked at, and without a matrix legs are computed (place_costs.py).

A fleet's costs are finite: a leg that a class cannot fly takes longer than any tour without such a leg (`forbidden`),
so that differences of sums stay numbers; whether routes can be flown, `instances.objective` says.

Each UAV's costs are multiplied by a scale of its own, which is how endurance is kept (endurance.py); else it is 1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search.place_costs import PlaceCosts, place_costs, place_leg, read_only
from instances import Instance, Travel
from instances.arrays import Floats, Ints
from instances.kernels import njit, overload

_TILE = 256
"""Rows and columns that the processor's cache holds both of, compared at once."""


class AlikeCosts(NamedTuple):
    """out[i, j] = into[j, i] = c_ij [s], both (n+m, n+m); one and the same array where costs are symmetric."""

    out: Floats
    into: Floats


class FleetCosts(NamedTuple):
    """out[g, i, j] = into[g, j, i] = c_ij [s] of class g, both (G, n+m, n+m), finite; one array where symmetric.

    classes (m,): the class of each UAV; scale (m,): what its costs are multiplied by, which may change.
    """

    out: Floats
    into: Floats
    classes: Ints
    scale: Floats


Costs = AlikeCosts | FleetCosts | PlaceCosts


def leg(costs: Costs, k: int, u: int, w: int) -> float:
    """Return what UAV k takes from node u to node w [s], read along the row of u."""
    if isinstance(costs, FleetCosts):
        return float(costs.out[costs.classes[k], u, w] * costs.scale[k])
    if isinstance(costs, PlaceCosts):
        return float(place_leg(costs, u, w))
    return float(costs.out[u, w])


def leg_into(costs: Costs, k: int, w: int, u: int) -> float:
    """Return what UAV k takes to node w from node u [s], read along the row of w."""
    if isinstance(costs, FleetCosts):
        return float(costs.into[costs.classes[k], w, u] * costs.scale[k])
    if isinstance(costs, PlaceCosts):
        return float(place_leg(costs, u, w))
    return float(costs.into[w, u])


def uavs_differ(costs: Costs) -> bool:
    """Return whether the costs are a fleet's; a constant to the compiler."""
    return isinstance(costs, FleetCosts)


def n_nodes(costs: Costs) -> int:
    """Return the number of nodes n + m."""
    return costs.x.size if isinstance(costs, PlaceCosts) else costs.out.shape[-1]


def _of_fleet(costs: Any) -> bool:
    """Return whether `costs` is numba's type of a fleet's costs."""
    return getattr(costs, "instance_class", None) is FleetCosts


def _of_places(costs: Any) -> bool:
    """Return whether `costs` is numba's type of costs without a matrix."""
    return getattr(costs, "instance_class", None) is PlaceCosts


@overload(leg)
def _leg(costs: Any, k: Any, u: Any, w: Any) -> Callable[..., Any]:
    if _of_fleet(costs):
        return lambda costs, k, u, w: costs.out[costs.classes[k], u, w] * costs.scale[k]
    if _of_places(costs):
        return lambda costs, k, u, w: place_leg(costs, u, w)
    return lambda costs, k, u, w: costs.out[u, w]


@overload(leg_into)
def _leg_into(costs: Any, k: Any, w: Any, u: Any) -> Callable[..., Any]:
    if _of_fleet(costs):
        return lambda costs, k, w, u: costs.into[costs.classes[k], w, u] * costs.scale[k]
    if _of_places(costs):
        return lambda costs, k, w, u: place_leg(costs, u, w)
    return lambda costs, k, w, u: costs.into[w, u]


@overload(uavs_differ)
def _uavs_differ(costs: Any) -> Callable[..., Any]:
    differ = _of_fleet(costs)
    return lambda costs: differ


@overload(n_nodes)
def _n_nodes(costs: Any) -> Callable[..., Any]:
    if _of_places(costs):
        return lambda costs: costs.x.size
    return lambda costs: costs.out.shape[-1]


@njit(cache=True, nogil=True)
def farthest_trip(costs: Costs, n_tasks: int) -> float:
    """Return what the first UAV takes to the farthest task and back [s]; at one site all take as long.

    The bound `farthest` of simple_bounds.py is of an instance, this of costs as the search scales them for endurance.
    """
    most = 0.0
    for v in range(n_tasks):
        most = max(most, leg(costs, 0, n_tasks, v) + leg(costs, 0, v, n_tasks))
    return most


def both_ways(cost: Floats) -> AlikeCosts:
    """Return the costs of UAVs that are alike, of the matrix `cost`; an asymmetric one is copied once, transposed."""
    return AlikeCosts(cost, cost if _is_symmetric(cost) else read_only(cost.T))


def _is_symmetric(cost: Floats) -> bool:
    """Return whether a matrix is its own transpose."""
    tiles = range(0, len(cost), _TILE)
    return all(
        np.array_equal(cost[a : a + _TILE, b : b + _TILE], cost[b : b + _TILE, a : a + _TILE].T)
        for a in tiles
        for b in tiles
        if a <= b
    )


def fleet_costs(cost: Floats, classes: Ints, scale: Floats) -> FleetCosts:
    """Return the costs of UAVs that differ, of matrices `cost` (G, n+m, n+m) [s], finite."""
    symmetric = np.array_equal(cost, cost.transpose(0, 2, 1))
    out = read_only(cost)
    return FleetCosts(out, out if symmetric else read_only(cost.transpose(0, 2, 1)), read_only(classes), scale)


def search_costs(instance: Instance) -> Costs:
    """Return the costs of an instance's UAVs; the scale of a fleet is 1."""
    if instance.by_metric is not None:
        return place_costs(instance.by_metric)
    if not instance.axes:
        return both_ways(instance.cost)
    cost = instance.class_costs
    if not np.isfinite(cost).all():
        cost = np.where(np.isfinite(cost), cost, forbidden(instance))
    return fleet_costs(cost, instance.classes, np.ones(instance.n_depots))


def forbidden(instance: Instance) -> float:
    """Return a time [s] twice as long as any tour of legs that can be flown."""
    cost = instance.class_costs
    return 2.0 * (instance.n_tasks + 1) * float(cost[np.isfinite(cost)].max()) or 1.0


def warm_up(like: Instance, n_tasks: int, n_depots: int) -> Instance:
    """Return a small instance for which the same kernels are compiled as for `like`; its UAVs can fly all.

    Its costs are symmetric where those of `like` are: others have potentials (leg_potentials.py).
    """
    if like.by_metric is not None:
        some = [
            *(v % like.n_tasks for v in range(n_tasks)),
            *(like.n_tasks + k % like.n_depots for k in range(n_depots)),
        ]
        points = like.by_metric.coordinates[some]
        return Instance.of_metric("warm-up", like.by_metric.metric, points, n_tasks, n_depots)
    cost = 1.0 - np.eye(n_tasks + n_depots)
    if not all(map(_is_symmetric, like.class_costs)):
        cost[0, 1] = 1.5
    limits = np.full(n_depots, 1.5 * (n_tasks + 1)) if like.axes else None
    return Instance("warm-up", cost, n_tasks, n_depots, endurance=limits)


def warm_up_by_clock(like: Instance, n_tasks: int, n_depots: int) -> Instance:
    """Return such an instance where costs change with time."""
    cost = np.repeat((1.0 - np.eye(n_tasks + n_depots))[None, None], 2, axis=1)
    travel = Travel(cost, np.zeros(n_depots, dtype=np.int64), np.array([0.0, 1.0]))
    beyond = {"time", "window", "endurance"} if "window" in like.axes else {"time"}  # as `frozen.guiding` leaves them
    limits = np.full(n_depots, 1.5 * (n_tasks + 1)) if like.axes - beyond else None
    return Instance.of_travel("warm-up", travel, n_tasks, endurance=limits)


def part_of(costs: Costs, nodes: NDArray[np.integer], uavs: NDArray[np.integer]) -> Costs:
    """Return the costs between some nodes, the tasks first, then the depots of `uavs`; a fleet's scale is copied."""
    if isinstance(costs, PlaceCosts):
        return costs._replace(x=read_only(costs.x[nodes]), y=read_only(costs.y[nodes]))
    if isinstance(costs, FleetCosts):
        used, classes = np.unique(costs.classes[uavs], return_inverse=True)
        return fleet_costs(costs.out[np.ix_(used, nodes, nodes)], classes, costs.scale[uavs])
    cost = between(costs.out, nodes)
    return AlikeCosts(cost, cost) if costs.out is costs.into else both_ways(cost)


def between(cost: Floats, nodes: NDArray[np.integer]) -> Floats:
    """Return cost[nodes][:, nodes] [s], read only like an instance's own: the kernels are compiled for that type."""
    out = np.empty((nodes.size, nodes.size))  # not in the kernel: numpy asks for large pages of memory
    _copy_between(cost, nodes, out)
    out.setflags(write=False)
    return out


@njit(cache=True, nogil=True)
def _copy_between(cost: Floats, nodes: NDArray[np.integer], out: Floats) -> None:
    """Write cost[nodes][:, nodes] to `out`."""
    for i in range(nodes.size):
        row = cost[nodes[i]]
        for j in range(nodes.size):
            out[i, j] = row[nodes[j]]


def least(costs: AlikeCosts | FleetCosts) -> AlikeCosts:
    """Return what legs take [s] whoever flies them: to and from a depot its own UAV, between tasks the fastest."""
    if isinstance(costs, AlikeCosts):
        return costs
    cost, m = costs.out.min(axis=0), len(costs.classes)
    for k, g in enumerate(costs.classes, len(cost) - m):
        cost[k], cost[:, k] = costs.out[g, k], costs.out[g, :, k]
    cost.setflags(write=False)
    return both_ways(cost)


def kinds(costs: AlikeCosts | FleetCosts, n_depots: int) -> Ints:
    """Return numbers (m,), equal for UAVs of the same class and scale."""
    if isinstance(costs, AlikeCosts):
        return np.zeros(n_depots, dtype=np.int64)
    return np.unique(np.column_stack([costs.classes, costs.scale]), axis=0, return_inverse=True)[1].ravel()
