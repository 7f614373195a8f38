"""Moves as concatenations of segments, priced in constant time (Kindervater & Savelsbergh 1997; Vidal et al. 2014).

With forward[i] the cost of flying from the depot to position i and backward[i] that of flying the same way back, any
segment of a tour has a known cost in both directions, so a reversal is priced in constant time under asymmetric costs.
Positions run from 0 (depot) over 1..L (tasks) to L+1 (the depot again).
Every `..._change`, `..._changes` or `..._costs` function prices one move; the function of the same name without it
makes the move.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, FleetCosts, leg, leg_into, uavs_differ
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours, join
from instances.arrays import Floats, Ints
from instances.kernels import njit, overload


class AlikeSegments(NamedTuple):
    """A tour from which the cost of any segment is known, where UAVs are alike.

    nodes (n+2,): the tour's nodes by position; forward, backward (n+2,): prefix sums [s];
    shape (2,): tour number k and its number of tasks L.
    """

    nodes: Nodes
    forward: Floats
    backward: Floats
    shape: Ints


class FleetSegments(NamedTuple):
    """The same where they differ, with the prefix sums over the tasks of another UAV, which may take segments."""

    nodes: Nodes
    forward: Floats
    backward: Floats
    shape: Ints
    others_forward: Floats
    others_backward: Floats


Segments = AlikeSegments | FleetSegments


def empty_segments(costs: Costs, n_tasks: int) -> Segments:
    """Return room for a tour of up to n_tasks tasks."""
    size = n_tasks + 2
    own = AlikeSegments(np.empty(size, np.int32), np.empty(size), np.empty(size), np.zeros(2, np.int64))
    return FleetSegments(*own, np.empty(size), np.empty(size)) if uavs_differ(costs) else own


def given_forward(segments: Segments) -> Floats:
    """Return the prefix sums of the UAV to which segments may be given."""
    return segments.others_forward if isinstance(segments, FleetSegments) else segments.forward


def given_backward(segments: Segments) -> Floats:
    """Return the prefix sums of the way back of the UAV to which segments may be given."""
    return segments.others_backward if isinstance(segments, FleetSegments) else segments.backward


@overload(empty_segments)
def _empty_segments(costs: Any, n_tasks: Any) -> Callable[..., Any]:
    def alike(costs, n_tasks):  # type: ignore[no-untyped-def]
        size = n_tasks + 2
        return AlikeSegments(np.empty(size, np.int32), np.empty(size), np.empty(size), np.zeros(2, np.int64))

    def fleet(costs, n_tasks):  # type: ignore[no-untyped-def]
        size, shape = n_tasks + 2, np.zeros(2, np.int64)
        nodes, forward, backward = np.empty(size, np.int32), np.empty(size), np.empty(size)
        return FleetSegments(nodes, forward, backward, shape, np.empty(size), np.empty(size))

    return fleet if costs.instance_class is FleetCosts else alike


@overload(given_forward)
def _given_forward(segments: Any) -> Callable[..., Any]:
    if segments.instance_class is FleetSegments:
        return lambda segments: segments.others_forward
    return lambda segments: segments.forward


@overload(given_backward)
def _given_backward(segments: Any) -> Callable[..., Any]:
    if segments.instance_class is FleetSegments:
        return lambda segments: segments.others_backward
    return lambda segments: segments.backward


@njit(cache=True, nogil=True)
def read_tour(costs: Costs, tours: Tours, k: int, h: int, segments: Segments, position: Ints) -> None:
    """Write tour k to `segments`, whose segments may be given to UAV h, and each of its tasks' place to `position`."""
    depot = tours.after.size - tours.cost.size + k
    u, i = depot, 0
    segments.nodes[0] = depot
    segments.forward[0] = 0.0
    segments.backward[0] = 0.0
    while True:
        w = tours.after[u]
        i += 1
        segments.nodes[i] = w
        segments.forward[i] = segments.forward[i - 1] + tours.arc[u]
        segments.backward[i] = segments.backward[i - 1] + tours.back[u]
        if w == depot:
            break
        position[w] = i
        u = w
    segments.shape[0] = k
    segments.shape[1] = i - 1
    if uavs_differ(costs) and h != k:
        _price_given(costs, segments, h)


@njit(cache=True, nogil=True)
def _price_given(costs: Costs, segments: Segments, h: int) -> None:
    """Write the prefix sums of UAV h over the tasks."""
    nodes, forward, backward = segments.nodes, given_forward(segments), given_backward(segments)
    forward[1] = backward[1] = 0.0
    for i in range(2, segments.shape[1] + 1):
        forward[i] = forward[i - 1] + leg(costs, h, nodes[i - 1], nodes[i])
        backward[i] = backward[i - 1] + leg_into(costs, h, nodes[i - 1], nodes[i])


@njit(cache=True, nogil=True)
def _flip(tours: Tours, segments: Segments, i: int, j: int) -> None:
    """Turn the links between positions i..j round; the links to either side are the caller's business."""
    nodes = segments.nodes
    for q in range(j - 1, i - 1, -1):
        u, w = nodes[q + 1], nodes[q]
        arc, back = tours.arc[w], tours.back[w]
        tours.after[u] = w
        tours.before[w] = u
        tours.arc[u] = back
        tours.back[u] = arc


@njit(cache=True, nogil=True)
def _give(costs: Costs, tours: Tours, segments: Segments, i: int, j: int, k: int) -> None:
    """Book the tasks at positions i..j on tour k; the links to either side are the caller's business."""
    for q in range(i, j + 1):
        tours.tour[segments.nodes[q]] = k
    if uavs_differ(costs):
        for q in range(i, j):
            u, w = segments.nodes[q], segments.nodes[q + 1]
            tours.arc[u] = leg(costs, k, u, w)
            tours.back[u] = leg_into(costs, k, u, w)


@njit(cache=True, nogil=True)
def two_opt_change(costs: Costs, a: Segments, i: int, j: int) -> float:
    """Return the change of the tour's cost [s] if its tasks at positions i..j were flown in reverse, 1 ≤ i ≤ j ≤ L."""
    u, first, last, w = a.nodes[i - 1], a.nodes[i], a.nodes[j], a.nodes[j + 1]
    before = a.forward[j + 1] - a.forward[i - 1]
    k = a.shape[0]
    return leg(costs, k, u, last) + a.backward[j] - a.backward[i] + leg_into(costs, k, w, first) - before


@njit(cache=True, nogil=True)
def two_opt(costs: Costs, tours: Tours, a: Segments, i: int, j: int) -> None:
    """Fly positions i..j in reverse."""
    u, first, last, w = a.nodes[i - 1], a.nodes[i], a.nodes[j], a.nodes[j + 1]
    _flip(tours, a, i, j)
    join(costs, tours, a.shape[0], u, last)
    join(costs, tours, a.shape[0], first, w)


@njit(cache=True, nogil=True)
def or_opt_changes(costs: Costs, a: Segments, i: int, j: int, b: Segments, q: int, turned: bool) -> tuple[float, float]:
    """Return the changes of tours a and b [s] if a's positions i..j moved behind b's position q, perhaps reversed.

    b may be a itself, then q is not in i−1..j and the change of the tour is the sum of both.
    """
    u, first, last, w = a.nodes[i - 1], a.nodes[i], a.nodes[j], a.nodes[j + 1]
    left = leg(costs, a.shape[0], u, w) - (a.forward[j + 1] - a.forward[i - 1])
    inner = a.forward[j] - a.forward[i]
    if turned:
        first, last = last, first
        inner = a.backward[j] - a.backward[i]
    if uavs_differ(costs) and a.shape[0] != b.shape[0]:
        sums = given_backward(a) if turned else given_forward(a)
        inner = sums[j] - sums[i]
    k, gap = b.shape[0], b.forward[q + 1] - b.forward[q]
    return left, leg_into(costs, k, first, b.nodes[q]) + inner + leg(costs, k, last, b.nodes[q + 1]) - gap


@njit(cache=True, nogil=True)
def or_opt(costs: Costs, tours: Tours, a: Segments, i: int, j: int, b: Segments, q: int, turned: bool) -> None:
    """Move a's positions i..j behind b's position q, perhaps reversed."""
    u, first, last, w = a.nodes[i - 1], a.nodes[i], a.nodes[j], a.nodes[j + 1]
    k_a, k_b = a.shape[0], b.shape[0]
    if k_a != k_b:
        _give(costs, tours, a, i, j, k_b)
        tours.size[k_a] -= j - i + 1
        tours.size[k_b] += j - i + 1
    if turned:
        _flip(tours, a, i, j)
        first, last = last, first
    join(costs, tours, k_a, u, w)
    join(costs, tours, k_b, b.nodes[q], first)
    join(costs, tours, k_b, last, b.nodes[q + 1])


@njit(cache=True, nogil=True)
def two_opt_star_costs(costs: Costs, a: Segments, i: int, b: Segments, j: int) -> tuple[float, float]:
    """Return the costs [s] of tours a[..i] b[j..] and b[..j−1] a[i+1..], 0 ≤ i ≤ L_a, 1 ≤ j ≤ L_b + 1."""
    return _head_and_tail(costs, a, i, b, j), _head_and_tail(costs, b, j - 1, a, i + 1)


@njit(cache=True, nogil=True)
def _head_and_tail(costs: Costs, a: Segments, i: int, b: Segments, j: int) -> float:
    k, depot, last = a.shape[0], a.nodes[0], b.shape[1]
    if j > last:
        return a.forward[i] + leg(costs, k, a.nodes[i], depot)
    tail = given_forward(b)[last] - given_forward(b)[j]
    return a.forward[i] + leg(costs, k, a.nodes[i], b.nodes[j]) + tail + leg(costs, k, b.nodes[last], depot)


@njit(cache=True, nogil=True)
def two_opt_star(costs: Costs, tours: Tours, a: Segments, i: int, b: Segments, j: int) -> None:
    """Exchange the tails behind a's position i and from b's position j on."""
    k_a, n_a, k_b, n_b = a.shape[0], a.shape[1], b.shape[0], b.shape[1]
    depot_a, depot_b = a.nodes[0], b.nodes[0]
    _give(costs, tours, a, i + 1, n_a, k_b)
    _give(costs, tours, b, j, n_b, k_a)
    join(costs, tours, k_a, a.nodes[i], b.nodes[j] if j <= n_b else depot_a)
    join(costs, tours, k_b, b.nodes[j - 1], a.nodes[i + 1] if i < n_a else depot_b)
    if j <= n_b:
        join(costs, tours, k_a, b.nodes[n_b], depot_a)
    if i < n_a:
        join(costs, tours, k_b, a.nodes[n_a], depot_b)
    tours.size[k_a] = i + n_b - j + 1
    tours.size[k_b] = j - 1 + n_a - i


@njit(cache=True, nogil=True)
def reversed_two_opt_star_costs(costs: Costs, a: Segments, i: int, b: Segments, j: int) -> tuple[float, float]:
    """Return the costs [s] of tours a[..i] b[j..1] and a[L..i+1] b[j+1..], 0 ≤ i ≤ L_a, 0 ≤ j ≤ L_b."""
    n_a, n_b, depot_a, depot_b = a.shape[1], b.shape[1], a.nodes[0], b.nodes[0]
    k_a, k_b = a.shape[0], b.shape[0]
    cost_a = a.forward[i]
    if j > 0:
        turned = given_backward(b)[j] - given_backward(b)[1]
        cost_a += leg(costs, k_a, a.nodes[i], b.nodes[j]) + turned + leg(costs, k_a, b.nodes[1], depot_a)
    else:
        cost_a += leg(costs, k_a, a.nodes[i], depot_a)
    cost_b = b.forward[n_b + 1] - b.forward[j + 1]
    if i < n_a:
        turned = given_backward(a)[n_a] - given_backward(a)[i + 1]
        cost_b += leg(costs, k_b, depot_b, a.nodes[n_a]) + turned + leg(costs, k_b, a.nodes[i + 1], b.nodes[j + 1])
    else:
        cost_b += leg(costs, k_b, depot_b, b.nodes[j + 1])
    return cost_a, cost_b


@njit(cache=True, nogil=True)
def reversed_two_opt_star(costs: Costs, tours: Tours, a: Segments, i: int, b: Segments, j: int) -> None:
    """Exchange a's tail behind position i and b's head up to position j, both reversed."""
    k_a, n_a, k_b, n_b = a.shape[0], a.shape[1], b.shape[0], b.shape[1]
    depot_a, depot_b = a.nodes[0], b.nodes[0]
    _give(costs, tours, a, i + 1, n_a, k_b)
    _give(costs, tours, b, 1, j, k_a)
    _flip(tours, a, i + 1, n_a)
    _flip(tours, b, 1, j)
    join(costs, tours, k_a, a.nodes[i], b.nodes[j] if j > 0 else depot_a)
    if j > 0:
        join(costs, tours, k_a, b.nodes[1], depot_a)
    join(costs, tours, k_b, depot_b, a.nodes[n_a] if i < n_a else b.nodes[j + 1])
    if i < n_a:
        join(costs, tours, k_b, a.nodes[i + 1], b.nodes[j + 1])
    tours.size[k_a] = i + j
    tours.size[k_b] = n_a - i + n_b - j
