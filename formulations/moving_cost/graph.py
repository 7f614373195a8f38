"""The graph that every search shares: nodes, directed edges, their reduced costs and whether they are free.

Edge information is the paper's bottleneck and is computed once for all starts. Cost and collision of an edge are
those of its pair of nodes: an energy's wind integral flips its sign with the direction, the collision does not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from formulations.moving_cost.field import SearchField
from formulations.moving_cost.free_space import FreeSpace, segments_free
from instances.arrays import Floats, Ints
from instances.environment.region import Region
from instances.errors import InputError
from instances.moving_cost import CostKind, CostMeasure, moving_cost

UNKNOWN, FREE, BLOCKED = 0, 1, 2


class Graph(NamedTuple):
    """A directed graph in compressed rows, for numba kernels: the edges out of node i are ``start[i]:start[i+1]``.

    points (N, 2) [m]. `neighbour` (M,) is the end node of each edge, `cost` (M,) [s] its time or reduced energy
    c_ij + (φ_j − φ_i)/v0² > 0, `back` (M,) [s] that of the same edge flown backwards, `pair` (M,) the number of its
    pair of nodes. `state` of each pair is UNKNOWN, FREE or BLOCKED, filled in by whoever looks first.
    """

    points: Floats
    start: Ints
    neighbour: Ints
    cost: Floats
    back: Floats
    pair: Ints
    state: NDArray[np.int8]

    def tails(self) -> Ints:
        """Return the node that each edge starts from, (M,)."""
        return np.repeat(np.arange(len(self.points)), np.diff(self.start))

    def free_matrix(self) -> csr_array:
        """Return the edges known to be free as a sparse matrix of reduced costs."""
        free = self.state[self.pair] == FREE
        rows = self.tails()[free]
        size = len(self.points)
        return csr_array((self.cost[free], (rows, self.neighbour[free])), shape=(size, size))


def build_graph(
    points: Floats, pairs: Ints, measure: CostMeasure, field: SearchField, space: FreeSpace | None
) -> Graph:
    """Return the graph over `points` with an edge each way for each of `pairs` (p, 2).

    With `space` every edge is tested for collision now and blocked ones are left out; without, states stay UNKNOWN.
    Raises InputError where an edge's cost is not positive (a wind as strong as the speed that is held constant).
    """
    if space is not None:
        pairs = pairs[segments_free(points[pairs[:, 0]], points[pairs[:, 1]], space)]
    forward, backward = pair_costs(points, pairs, measure, field)
    index = np.arange(2 * len(pairs), dtype=np.int64)
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    matrix = csr_array((index, (rows, columns)), shape=(len(points), len(points)))
    order = matrix.data
    return Graph(
        points,
        matrix.indptr.astype(np.int64),
        matrix.indices.astype(np.int64),
        np.concatenate([forward, backward])[order],
        np.concatenate([backward, forward])[order],
        order % max(1, len(pairs)),
        np.full(len(pairs), UNKNOWN if space is None else FREE, dtype=np.int8),
    )


def pair_costs(points: Floats, pairs: Ints, measure: CostMeasure, field: SearchField) -> tuple[Floats, Floats]:
    """Return the costs [s] of each pair, there and back: times, or reduced energies."""
    a, b = points[pairs[:, 0]], points[pairs[:, 1]]
    if measure.kind is CostKind.TIME:
        return measure.rough.segments(a, b), measure.rough.segments(b, a)
    wind, v0 = measure.wind, measure.speed
    tau = np.hypot(*(b - a).T) / v0
    phi = field.potential(points)
    push = wind.line_integral(a, b)
    # The gauge is exact whatever φ is; where the raw cost is safe and the reduced one is not, go without.
    for shift in (phi[pairs[:, 1]] - phi[pairs[:, 0]], 0.0):
        forward, backward = moving_cost(tau, push - shift, v0), moving_cost(tau, shift - push, v0)
        if len(pairs) == 0 or min(forward.min(), backward.min()) > 0:
            return forward, backward
    k = int(np.argmin(np.minimum(forward, backward) - tau))
    x, y = 0.5 * (a[k] + b[k])
    raise InputError(
        f"wind: near ({x:.0f}, {y:.0f}) m it blows at the ground speed of {v0:.3g} m/s or more: a leg's cost is "
        "not positive"
    )


def near_pairs(points: Floats, radius: float) -> Ints:
    """Return every pair i < j no farther apart than `radius` [m], shape (p, 2); coinciding points make no pair."""
    pairs = cKDTree(points).query_pairs(radius, output_type="ndarray").astype(np.int64)
    return pairs[(points[pairs[:, 0]] != points[pairs[:, 1]]).any(axis=1)]


def standard_radius(area: float, count: int) -> float:
    """Return the FMT* connection radius [m] for `count` random samples of an `area` [m²] in the plane.

    γ √(log N / N), γ = 2 √(1/2) √(area/π) (Janson et al. 2015, Theorem 4.1, d = 2, η → 0).
    """
    return 2 * math.sqrt(0.5 * area / math.pi * math.log(count) / count)


def hexagonal_lattice(region: Region, count: int) -> tuple[Floats, float]:
    """Return about `count` points of a hexagonal lattice in the region, (k, 2) [m], and its spacing [m]."""
    spacing = math.sqrt(2 * region.area / (math.sqrt(3) * count))
    x0, y0, x1, y1 = region.bounds
    rows = math.ceil((y1 - y0) / (spacing * math.sqrt(3) / 2)) + 1
    columns = math.ceil((x1 - x0) / spacing) + 2
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    grid = np.stack([x0 + (i - 0.5 * (j % 2) + 0.25) * spacing, y0 + (j + 0.25) * spacing * math.sqrt(3) / 2], axis=-1)
    p = grid.reshape(-1, 2)
    return p[region.contains(p)], spacing
