"""Cuts: one annealed move on one or two tours that ruin and recreate cannot make, because it shifts long pieces.

2-opt (reversal) and Or-opt (segment) inside a tour; segment relocation, 2-opt* (tails) and its reversed form (heads)
between two tours, also from depot to depot. Each candidate makes a task adjacent to one of its near neighbours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.routing.search import strips
from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Aim, Stakes, energy_with, stakes_without
from formulations.routing.search.randomness import below, uniform
from formulations.routing.search.strips import Strip
from formulations.routing.search.tours import Tours
from instances.arrays import Ints

WIDTH = 8
"""Near tasks that a candidate may make adjacent."""
LONGEST = 30
"""Tasks of a moved segment, at most."""


class Bench(NamedTuple):
    """Room for the two tours at work and the position of every task on them."""

    a: Strip
    b: Strip
    position: Ints


@njit(cache=True, nogil=True)
def blank_bench(n_tasks: int) -> Bench:
    """Return room for tours of up to n_tasks tasks."""
    return Bench(strips.blank_strip(n_tasks), strips.blank_strip(n_tasks), np.zeros(n_tasks, np.int64))


@njit(cache=True, nogil=True)
def cut(
    costs: Costs,
    near: NDArray[np.int32],
    tours: Tours,
    bench: Bench,
    rng: NDArray[np.uint64],
    now: float,
    temperature: float,
    aim: Aim,
) -> float:
    """Try candidates on the tours of a random task and a near one until one is kept; return the energy then [s]."""
    n = near.shape[0]
    if near.shape[1] == 0:
        return now
    a, b, position = bench.a, bench.b, bench.position
    v = below(rng, n)
    k_a, k_b = tours.tour[v], tours.tour[near[v, below(rng, min(WIDTH, near.shape[1]))]]
    strips.lay_out(tours, k_a, a, position)
    if k_b != k_a:
        strips.lay_out(tours, k_b, b, position)
    stakes = stakes_without(tours, k_a, k_b, aim)
    n_a = a.shape[1]
    pool = n_a if k_a == k_b else n_a + b.shape[1]
    for _ in range(10 + pool // 4):
        i = 1 + below(rng, pool)
        v = a.nodes[i] if i <= n_a else b.nodes[i - n_a]
        x = near[v, below(rng, min(WIDTH, near.shape[1]))]
        k_v, k_x = tours.tour[v], tours.tour[x]
        if k_x != k_a and k_x != k_b:
            continue
        limit = now - temperature * math.log(1.0 - uniform(rng))
        from_v, from_x = a if k_v == k_a else b, a if k_x == k_a else b
        if k_v == k_x:
            other = tours.cost[k_a + k_b - k_v] if k_a != k_b else 0.0
            then = _inside(costs, tours, from_v, position[v], position[x], stakes, other, limit, rng)
        else:
            then = _between(costs, tours, from_v, position[v], from_x, position[x], stakes, limit, rng)
        if then < limit:
            return then
    return now


@njit(cache=True, nogil=True)
def _inside(
    costs: Costs,
    tours: Tours,
    a: Strip,
    i: int,
    j: int,
    stakes: Stakes,
    other: float,
    limit: float,
    rng: NDArray[np.uint64],
) -> float:
    """Try to make positions i and j of one tour adjacent; make the move and return its energy, or return inf."""
    k = a.shape[0]
    own = tours.cost[k]
    low, high = min(i, j), max(i, j)
    for left, right in ((low + 1, high), (low, high - 1)):
        if right > left:
            change = strips.reversal_change(costs, a, left, right)
            then = energy_with(stakes, own + change, other)
            if then < limit:
                strips.reversal(costs, tours, a, left, right)
                tours.cost[k] = own + change
                return then
    for turned in (False, True):
        first, last, q = _segment_at(a, i, j, turned, rng)
        if q < first - 1 or q > last:
            out, into = strips.segment_changes(costs, a, first, last, a, q, turned)
            then = energy_with(stakes, own + out + into, other)
            if then < limit:
                strips.segment(costs, tours, a, first, last, a, q, turned)
                tours.cost[k] = own + out + into
                return then
    return np.inf


@njit(cache=True, nogil=True)
def _segment_at(a: Strip, i: int, j: int, turned: bool, rng: NDArray[np.uint64]) -> tuple[int, int, int]:
    """Return (first, last, q): a random segment with position i at one end, to go beside position j.

    Straight: it starts at i and goes behind j, or ends at i and goes before j. Turned: the ends change places.
    """
    length = 1 + below(rng, LONGEST)
    behind = uniform(rng) < 0.5
    if behind != turned:
        return i, min(a.shape[1], i + length - 1), j if behind else j - 1
    return max(1, i - length + 1), i, j if behind else j - 1


@njit(cache=True, nogil=True)
def _between(
    costs: Costs,
    tours: Tours,
    a: Strip,
    i: int,
    b: Strip,
    j: int,
    stakes: Stakes,
    limit: float,
    rng: NDArray[np.uint64],
) -> float:
    """Try to make position i of one tour and j of another adjacent; make the move, return its energy, or inf."""
    k_a, k_b = a.shape[0], b.shape[0]
    for left, right in ((i, j), (i - 1, j + 1)):
        cost_a, cost_b = strips.tails_costs(costs, a, left, b, right)
        then = energy_with(stakes, cost_a, cost_b)
        if then < limit:
            strips.tails(costs, tours, a, left, b, right)
            tours.cost[k_a], tours.cost[k_b] = cost_a, cost_b
            return then
    for left, right in ((i, j), (i - 1, j - 1)):
        cost_a, cost_b = strips.heads_costs(costs, a, left, b, right)
        then = energy_with(stakes, cost_a, cost_b)
        if then < limit:
            strips.heads(costs, tours, a, left, b, right)
            tours.cost[k_a], tours.cost[k_b] = cost_a, cost_b
            return then
    for turned in (False, True):
        first, last, q = _segment_at(a, i, j, turned, rng)
        out, into = strips.segment_changes(costs, a, first, last, b, q, turned)
        then = energy_with(stakes, tours.cost[k_a] + out, tours.cost[k_b] + into)
        if then < limit:
            strips.segment(costs, tours, a, first, last, b, q, turned)
            tours.cost[k_a] += out
            tours.cost[k_b] += into
            return then
    return np.inf
