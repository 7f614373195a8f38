"""refined: shortest paths on a lattice, then the local optimum of every promising homotopy class.

1. A hexagonal lattice with the corners of obstacles and the terminals; edges to all nodes within 3.2 spacings, and
   the visibility graph of corners and terminals. All edges once, gauge-fixed (field.py).
2. Dijkstra from every terminal on the graph and on its reverse.
3. For every ordered pair the best path of each homotopy class within a slack of the best (homotopy.py); beside them
   its rivals, which pass the core of a vortex on another side (cores.py): there is nothing to fly around, but the wind
   itself may part paths into several locally best ones.
4. Newton polish of each (polish.py), coarse. The best by exact cost stays; what was found for j → i is tried
   backwards for i → j, and where two legs through a third terminal are cheaper (triangle inequality), these.
5. Fine polish, until the polyline's own excess over a smooth path is negligible.

What this claims: no small sideways shift makes a path cheaper, and none of the others that were met is. It does not
claim that no cheaper path exists: on a lattice a class may be overlooked, and a wind may part paths where no core is.
Over random fields of vortices alone 4 of 3600 pairs were beaten by 0.1 to 0.5 % before there were rivals, since then
none (``tests/benchmarks/vortex_sides.py``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shapely.geometry import Polygon

from formulations.moving_cost.arrivals import earliest_paths
from formulations.moving_cost.cores import vortex_cores
from formulations.moving_cost.corridor import quicker
from formulations.moving_cost.field import SearchField, search_field
from formulations.moving_cost.free_space import FreeSpace, free_space
from formulations.moving_cost.graph import Graph, build_graph, hexagonal_lattice, near_pairs
from formulations.moving_cost.homotopy import swept_angles, via_candidates, via_paths
from formulations.moving_cost.method import MovingCostMethod, MovingCosts, Progress, Query, silent
from formulations.moving_cost.polish import polish_all
from formulations.moving_cost.pool import Pool
from formulations.moving_cost.tree import require_reached, shortest_path_trees
from formulations.moving_cost.wind_frames import WindFrames
from instances.arrays import Floats, Ints
from instances.errors import InputError
from instances.paths import Paths

REACH = 3.2
"""Connection radius of the lattice in spacings: 36 neighbours."""
VISIBLE = 400
"""With more corners and terminals than this, only near ones see each other."""
RIVALS = 2
"""Paths a pair that pass vortex cores on other sides than the best does, at most."""
AROUND = 6.0
"""Nodes so many spacings from a core at most are where its rivals lead through."""
JUDGED = 3e-4
"""Precision at which a rival is compared: the final one takes most of the polish's time."""
CLEARLY = 1e-4
"""Share of the cost by which a rival must be cheaper: the same path comes out of the polish a little different."""
ROUNDS = 3
"""Rounds of the triangle inequality at most."""


@dataclass(frozen=True)
class Refined(MovingCostMethod):
    """Lattice search and Newton polish.

    samples : lattice points (at least 1).
    slack : how much longer than the best, as a share of the lattice's reduced cost, a path of another class may be
        (at least 0).
    candidates : homotopy classes polished per pair at most (at least 1).
    precision : relative excess of the final polyline over the smooth path at which refining stops (above 0).
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
        lattice = _Lattice.over(query, field, space, self.samples)
        found, rivals = lattice.candidates(self.slack, self.candidates), lattice.rivals(self.slack)
        progress(0.3, f"{len(found) + len(rivals)} candidates found")
        polish = _Polish(query, field, space, lattice.spacing)
        pool = polish.best(polish.polished(found))
        pool = polish.better(pool, rivals)
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
        return MovingCosts(cost, paths, {"edges": lattice.edges, "candidates": len(found), "rivals": len(rivals)})

    def by_clock(self, query: Query, wind: WindFrames, moments: Floats, progress: Progress = silent) -> list[Paths]:
        """Return the paths of earliest arrival on the lattice for departures at `moments`, made quicker nearby."""
        field, space = search_field(query.measure, query.region), free_space(query.region)
        graph, spacing = _lattice_graph(query, field, space, self.samples)
        return quicker(earliest_paths(query, graph, wind, moments, progress), moments, spacing, wind, space)


def _lattice_graph(query: Query, field: SearchField, space: FreeSpace, samples: int) -> tuple[Graph, float]:
    """Return the graph of free edges over terminals, corners and about `samples` lattice points; their spacing [m]."""
    seen = len(query.terminals) + len(space.corners)
    lattice, spacing = hexagonal_lattice(query.region, samples)
    points = np.concatenate([query.terminals, space.corners, lattice])
    near = near_pairs(points, REACH * spacing)
    if seen <= VISIBLE:
        near = near[near[:, 1] >= seen]
        near = np.concatenate([near, np.column_stack(np.triu_indices(seen, 1))])
        near = near[(points[near[:, 0]] != points[near[:, 1]]).any(axis=1)]
    return build_graph(points, near, query.measure, field, space), spacing


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

    def better(self, pool: Pool, rivals: Pool) -> Pool:
        """Return `pool`, one candidate a pair, with those of `rivals` that prove cheaper in their place."""
        rivals = self.best(self.polished(rivals))
        n = len(self.query.terminals)
        number = np.empty((n, n), dtype=np.int64)
        number[pool.start, pool.target] = np.arange(len(pool))
        own = pool.take(number[rivals.start, rivals.target])
        near = np.flatnonzero(self.costs(rivals) < self.costs(own))
        if len(near) == 0:
            return pool
        cost, fine = (self.costs(self.polished(each.take(near), JUDGED)) for each in (own, rivals))
        return self.best(pool.plus(rivals.take(near[fine < cost - CLEARLY * np.abs(cost)])))

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


@dataclass(frozen=True, eq=False)
class _Lattice:
    """Shortest paths on the lattice: trees out of and into every terminal, by node; terminals first, then corners."""

    query: Query
    space: FreeSpace
    cores: Floats
    points: Floats
    spacing: float
    edges: int
    away: Floats
    parent: Ints
    into: Floats
    child: Ints

    @classmethod
    def over(cls, query: Query, field: SearchField, space: FreeSpace, samples: int) -> _Lattice:
        """Search the lattice of about `samples` points."""
        n = len(query.terminals)
        graph, spacing = _lattice_graph(query, field, space, samples)
        legs = graph.free_matrix()
        away, parent = shortest_path_trees(legs, np.arange(n))
        into, child = shortest_path_trees(legs.T.tocsr(), np.arange(n))
        require_reached(query, np.isfinite(away[:, :n]))
        cores = vortex_cores(field.bending, query.region)
        return cls(query, space, cores, graph.points, spacing, len(graph.cost), away, parent, into, child)

    def candidates(self, slack: float, most: int) -> Pool:
        """Return the best path of each class of sides on which obstacles are passed, at most `most` a pair."""
        n, seen = len(self.query.terminals), len(self.query.terminals) + len(self.space.corners)
        inside = [Polygon(hole).representative_point() for hole in self.query.region.polygon.interiors]
        centres = np.array([[p.x, p.y] for p in inside]).reshape(-1, 2)
        # Every corner, and a sparse half of a percent of the lattice for detours that no obstacle explains.
        via = np.concatenate([np.arange(n, seen), np.arange(seen, len(self.points), 40)])
        return self._pool(*self._via(centres, via, slack, most))

    def rivals(self, slack: float) -> Pool:
        """Return what passes vortex cores on other sides than the best path, at most RIVALS paths a pair."""
        if len(self.cores) == 0:
            return self._pool(*np.empty((3, 0), dtype=np.int64))
        distance = np.hypot(*(self.points[:, None] - self.cores[None]).transpose(2, 0, 1)).min(axis=1)
        start, target, through = self._via(
            self.cores, np.flatnonzero(distance < AROUND * self.spacing), slack, 1 + RIVALS
        )
        other = np.append(False, (start[1:] == start[:-1]) & (target[1:] == target[:-1]))  # but for a pair's best
        return self._pool(start[other], target[other], through[other])

    def _via(self, centres: Floats, via: Ints, slack: float, most: int) -> tuple[Ints, Ints, Ints]:
        """Return (from, to, via) of the best path of each class around `centres`."""
        angles = (
            swept_angles(self.points, self.parent, self.away, centres, 1.0),
            swept_angles(self.points, self.child, self.into, centres, -1.0),
        )
        return via_candidates(self.away, self.into, *angles, via, slack, most)

    def _pool(self, start: Ints, target: Ints, through: Ints) -> Pool:
        n, seen = len(self.query.terminals), len(self.query.terminals) + len(self.space.corners)
        nodes, offsets = via_paths(self.parent, self.child, start, target, through)
        corner = np.where((nodes >= n) & (nodes < seen), nodes - n, -1)
        return Pool(start, target, self.points[nodes], corner, offsets)
