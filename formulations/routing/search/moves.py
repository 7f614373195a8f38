"""Moves: one annealed move on one or two tours that ruin and recreate cannot make, because it shifts long segments.

2-opt and Or-opt inside a tour; Or-opt, 2-opt* and its reversed form between two tours, also from depot to depot. Each
makes a task adjacent to one of its granular neighbourhood; concatenation.py prices and makes it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.routing.search import concatenation
from formulations.routing.search.concatenation import Segments
from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Objective, PartialEnergy, energy_with, energy_without
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.tours import Tours
from instances.arrays import Ints
from instances.kernels import njit


class MoveParameters(NamedTuple):
    """Which moves are tried.

    width: near tasks that a candidate may make adjacent; most legs of good tours lead to one of them.
    longest: tasks of a segment moved by Or-opt, at most; longer ones are what 2-opt* exchanges.
    temperature: as a share of that of the ruins: one step here tries hundreds of moves, not one.
    """

    width: int = 8
    longest: int = 30
    temperature: float = 0.1


class Workspace(NamedTuple):
    """The two tours that a move changes and the position of every task on them."""

    a: Segments
    b: Segments
    position: Ints


@njit(cache=True, nogil=True)
def empty_workspace(costs: Costs, n_tasks: int) -> Workspace:
    """Return room for tours of up to n_tasks tasks."""
    a, b = concatenation.empty_segments(costs, n_tasks), concatenation.empty_segments(costs, n_tasks)
    return Workspace(a, b, np.zeros(n_tasks, np.int64))


@njit(cache=True, nogil=True)
def move(
    costs: Costs,
    near: Nodes,
    tours: Tours,
    workspace: Workspace,
    rng: Rng,
    now: float,
    temperature: float,
    objective: Objective,
    parameters: MoveParameters,
) -> float:
    """Try moves on the tours of a random task and a near one until one is accepted; return the energy then [s].

    now [s]: the energy before; temperature [s]: of the ruins.
    """
    n = near.shape[0]
    if near.shape[1] == 0:
        return now
    a, b, position = workspace
    width = min(parameters.width, near.shape[1])
    v = below(rng, n)
    k_a, k_b = tours.tour[v], tours.tour[near[v, below(rng, width)]]
    concatenation.read_tour(costs, tours, k_a, k_b, a, position)
    if k_b != k_a:
        concatenation.read_tour(costs, tours, k_b, k_a, b, position)
    partial = energy_without(tours, k_a, k_b, objective)
    n_a = a.shape[1]
    pool = n_a if k_a == k_b else n_a + b.shape[1]
    for _ in range(10 + pool // 4):
        i = 1 + below(rng, pool)
        v = a.nodes[i] if i <= n_a else b.nodes[i - n_a]
        x = near[v, below(rng, width)]
        k_v, k_x = tours.tour[v], tours.tour[x]
        if k_x != k_a and k_x != k_b:
            continue
        limit = now - parameters.temperature * temperature * math.log(1.0 - uniform(rng))
        from_v, from_x = a if k_v == k_a else b, a if k_x == k_a else b
        if k_v == k_x:
            other = tours.cost[k_a + k_b - k_v] if k_a != k_b else 0.0
            then = _move_inside(
                costs, tours, from_v, position[v], position[x], partial, other, limit, rng, parameters.longest
            )
        else:
            then = _move_between(
                costs, tours, from_v, position[v], from_x, position[x], partial, limit, rng, parameters.longest
            )
        if then < limit:
            return then
    return now


@njit(cache=True, nogil=True)
def _move_inside(
    costs: Costs,
    tours: Tours,
    a: Segments,
    i: int,
    j: int,
    partial: PartialEnergy,
    other: float,
    limit: float,
    rng: Rng,
    longest: int,
) -> float:
    """Try to make positions i and j of one tour adjacent; make the move and return its energy, or return inf."""
    k = a.shape[0]
    own = tours.cost[k]
    low, high = min(i, j), max(i, j)
    for left, right in ((low + 1, high), (low, high - 1)):
        if right > left:
            change = concatenation.two_opt_change(costs, a, left, right)
            then = energy_with(partial, own + change, other)
            if then < limit:
                concatenation.two_opt(costs, tours, a, left, right)
                tours.cost[k] = own + change
                return then
    for turned in (False, True):
        first, last, q = _segment_at(a, i, j, turned, rng, longest)
        if q < first - 1 or q > last:
            out, into = concatenation.or_opt_changes(costs, a, first, last, a, q, turned)
            then = energy_with(partial, own + out + into, other)
            if then < limit:
                concatenation.or_opt(costs, tours, a, first, last, a, q, turned)
                tours.cost[k] = own + out + into
                return then
    return np.inf


@njit(cache=True, nogil=True)
def _segment_at(a: Segments, i: int, j: int, turned: bool, rng: Rng, longest: int) -> tuple[int, int, int]:
    """Return (first, last, q): a random segment with position i at one end, to go beside position j.

    Straight: it starts at i and goes behind j, or ends at i and goes before j. Turned: the ends change places.
    """
    length = 1 + below(rng, longest)
    behind = uniform(rng) < 0.5
    if behind != turned:
        return i, min(a.shape[1], i + length - 1), j if behind else j - 1
    return max(1, i - length + 1), i, j if behind else j - 1


@njit(cache=True, nogil=True)
def _move_between(
    costs: Costs,
    tours: Tours,
    a: Segments,
    i: int,
    b: Segments,
    j: int,
    partial: PartialEnergy,
    limit: float,
    rng: Rng,
    longest: int,
) -> float:
    """Try to make position i of one tour and j of another adjacent; make the move, return its energy, or inf."""
    k_a, k_b = a.shape[0], b.shape[0]
    for left, right in ((i, j), (i - 1, j + 1)):
        cost_a, cost_b = concatenation.two_opt_star_costs(costs, a, left, b, right)
        then = energy_with(partial, cost_a, cost_b)
        if then < limit:
            concatenation.two_opt_star(costs, tours, a, left, b, right)
            tours.cost[k_a], tours.cost[k_b] = cost_a, cost_b
            return then
    for left, right in ((i, j), (i - 1, j - 1)):
        cost_a, cost_b = concatenation.reversed_two_opt_star_costs(costs, a, left, b, right)
        then = energy_with(partial, cost_a, cost_b)
        if then < limit:
            concatenation.reversed_two_opt_star(costs, tours, a, left, b, right)
            tours.cost[k_a], tours.cost[k_b] = cost_a, cost_b
            return then
    for turned in (False, True):
        first, last, q = _segment_at(a, i, j, turned, rng, longest)
        out, into = concatenation.or_opt_changes(costs, a, first, last, b, q, turned)
        then = energy_with(partial, tours.cost[k_a] + out, tours.cost[k_b] + into)
        if then < limit:
            concatenation.or_opt(costs, tours, a, first, last, b, q, turned)
            tours.cost[k_a] += out
            tours.cost[k_b] += into
            return then
    return np.inf
