"""refined: shortest paths on a lattice, then the true local optimum of every promising homotopy class.

1. A hexagonal lattice with the corners of obstacles and the terminals; edges to all nodes within 3.2 spacings, and
   the visibility graph of corners and terminals. All edges once, gauge-fixed (field.py).
2. Dijkstra from every terminal on the graph and on its reverse.
3. For every ordered pair the best path of each homotopy class within a slack of the best (homotopy.py).
4. Newton polish of each (polish.py), coarse. The best by exact cost stays; what was found for j → i is tried
   backwards for i → j, and where two legs through a third terminal are cheaper (triangle inequality), these.
5. Fine polish, until the polyline's own excess over a smooth path is negligible.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shapely.geometry import Polygon

from formulations.moving_cost.field import SearchField, search_field
from formulations.moving_cost.free_space import FreeSpace, free_space
from formulations.moving_cost.graph import build_graph, hexagonal_lattice, near_pairs
from formulations.moving_cost.homotopy import swept_angles, via_candidates, via_paths
from formulations.moving_cost.method import MovingCostMethod, MovingCosts, Progress, Query, silent
from formulations.moving_cost.polish import polish_all
from formulations.moving_cost.pool import Pool
from formulations.moving_cost.tree import require_reached, shortest_path_trees
from instances.arrays import Floats
from instances.errors import InputError
from instances.paths import Paths

REACH = 3.2
"""Connection radius of the lattice in spacings: 36 neighbours."""
VISIBLE = 400
"""With more corners and terminals than this, only near ones see each other."""
ROUNDS = 3
"""Rounds of the triangle inequality at most."""


@dataclass(frozen=True)
class Refined(MovingCostMethod):
    """Lattice search and Newton polish.

    samples : lattice points.
    slack : how much longer than the best, in the lattice's reduced cost, a path of another class may be.
    candidates : homotopy classes polished per pair at most.
    precision : relative excess of the final polyline over the smooth path at which refining stops.
    """

    samples: int = 2500
    slack: float = 0.03
    candidates: int = 4
    precision: float = 2e-6

    def __post_init__(self) -> None:
        if self.samples < 1 or self.slack < 0 or self.candidates < 1 or not self.precision > 0:
            raise InputError("refined: samples and candidates must be at least 1, slack ≥ 0 and precision > 0")

    def solve(self, query: Query, progress: Progress = silent) -> MovingCosts:
        """Return costs and paths between all terminals."""
        field, space = search_field(query.measure, query.region), free_space(query.region)
        found, spacing, edges = _lattice_candidates(query, field, space, self)
        progress(0.3, f"{len(found)} candidates found")
        polish = _Polish(query, field, space, spacing)
        pool = polish.best(polish.polished(found))
        pool = polish.best(pool.plus(polish.polished(pool.reversed())))
        for _ in range(ROUNDS):
            shorter = polish.shortcuts(pool)
            if len(shorter) == 0:
                break
            pool = polish.best(pool.plus(shorter).plus(polish.polished(shorter)))
        progress(0.6, "coarse polish done")
        pool = polish.best(pool.plus(polish.polished(pool, self.precision)))
        progress(1.0, "fine polish done")
        n = len(query.terminals)
        full = np.zeros(n * n, dtype=np.int64)
        full[pool.start * n + pool.target] = np.diff(pool.offsets)
        paths = Paths(n, pool.points, np.concatenate([[0], np.cumsum(full)]))
        cost = query.measure.polylines(paths.points, paths.offsets).reshape(n, n)
        return MovingCosts(cost, paths, {"edges": edges, "candidates": len(found)})


@dataclass(frozen=True, eq=False)
class _Polish:
    """The polish with everything it needs to know."""

    query: Query
    field: SearchField
    space: FreeSpace
    spacing: float

    def costs(self, pool: Pool) -> Floats:
        """Return the cost [s] of each candidate."""
        return self.query.measure.rough.polylines(pool.points, pool.offsets)

    def best(self, pool: Pool) -> Pool:
        """Return the cheapest candidate of each pair."""
        return pool.take(pool.best(self.costs(pool)))

    def polished(self, pool: Pool, precision: float = 0.0) -> Pool:
        """Return the candidates relaxed with pieces of the lattice's spacing, then refined to `precision` if not 0."""
        given = (pool.points, pool.corner, pool.offsets)
        return Pool(
            pool.start, pool.target, *polish_all(*given, self.spacing, precision, self.space, self.field.bending)
        )

    def shortcuts(self, pool: Pool) -> Pool:
        """Return paths through a third terminal where these are cheaper than the candidate of their pair."""
        n = len(self.query.terminals)
        cost = np.zeros((n, n))
        number = np.full((n, n), -1, dtype=np.int64)
        cost[pool.start, pool.target] = self.costs(pool)
        number[pool.start, pool.target] = np.arange(len(pool))
        best, via = cost.copy(), np.full((n, n), -1, dtype=np.int64)
        for k in range(n):
            sums = cost[:, k, None] + cost[None, k, :]
            better = sums < best * (1 - 1e-9)
            better[k, :] = better[:, k] = False
            best[better], via[better] = sums[better], k
        i, j = np.nonzero((via >= 0) & ~np.eye(n, dtype=bool))
        return pool.joined(number[i, via[i, j]], number[via[i, j], j])


def _lattice_candidates(
    query: Query, field: SearchField, space: FreeSpace, options: Refined
) -> tuple[Pool, float, int]:
    """Return the candidates of the lattice search, the lattice's spacing [m] and its number of edges."""
    n, seen = len(query.terminals), len(query.terminals) + len(space.corners)
    lattice, spacing = hexagonal_lattice(query.region, options.samples)
    points = np.concatenate([query.terminals, space.corners, lattice])
    near = near_pairs(points, REACH * spacing)
    if seen <= VISIBLE:
        near = near[near[:, 1] >= seen]
        near = np.concatenate([near, np.column_stack(np.triu_indices(seen, 1))])
        near = near[(points[near[:, 0]] != points[near[:, 1]]).any(axis=1)]
    graph = build_graph(points, near, query.measure, field, space)
    terminals = np.arange(n)
    legs = graph.free_matrix()
    away, parent = shortest_path_trees(legs, terminals)
    into, child = shortest_path_trees(legs.T.tocsr(), terminals)
    inside = [Polygon(hole).representative_point() for hole in query.region.polygon.interiors]
    centres = np.array([[p.x, p.y] for p in inside]).reshape(-1, 2)
    # Every corner, and a sparse half of a percent of the lattice for detours that no obstacle explains.
    via = np.concatenate([np.arange(n, seen), np.arange(seen, len(points), 40)])
    start, target, through = via_candidates(
        away,
        into,
        swept_angles(points, parent, away, centres, 1.0),
        swept_angles(points, child, into, centres, -1.0),
        via,
        options.slack,
        options.candidates,
    )
    require_reached(query, np.isfinite(away[:, :n]))
    nodes, offsets = via_paths(parent, child, start, target, through)
    corner = np.where((nodes >= n) & (nodes < seen), nodes - n, -1)
    return Pool(start, target, points[nodes], corner, offsets), spacing, len(graph.cost)
