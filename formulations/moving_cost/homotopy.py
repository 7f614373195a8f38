"""Candidates of several homotopy classes: who passes which obstacle on which side.

With trees from every start and (on the reversed graph) into every target, the best path from i to j through a
node v costs d_i(v) + d_j'(v). Its class is told by the angle it sweeps around a point inside each obstacle:
between fixed ends two paths differ there by whole turns. For each pair and each class met through a set of via
nodes the best path is kept where it is not much longer than the best of all: a search on a coarse graph ranks
classes only roughly, and the polish decides.
"""

from __future__ import annotations

import math

import numpy as np

from instances.arrays import Floats, Ints
from instances.kernels import njit


@njit(cache=True)
def swept_angles(points: Floats, predecessor: Ints, distance: Floats, centres: Floats, sign: float) -> Floats:
    """Angle [rad] swept around each centre along the tree path to every node: (trees, N, centres).

    `sign` is 1 for trees out of a start, −1 for trees (found on the reversed graph) into a target.
    """
    trees, n = predecessor.shape
    out = np.zeros((trees, n, len(centres)))
    for i in range(trees):
        for v in np.argsort(distance[i]):
            u = predecessor[i, v]
            if u < 0:
                continue
            for o in range(len(centres)):
                ax, ay = points[u, 0] - centres[o, 0], points[u, 1] - centres[o, 1]
                bx, by = points[v, 0] - centres[o, 0], points[v, 1] - centres[o, 1]
                out[i, v, o] = out[i, u, o] + sign * math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    return out


@njit(cache=True)
def via_candidates(
    out_distance: Floats, in_distance: Floats, out_angle: Floats, in_angle: Floats, via: Ints, slack: float, most: int
) -> tuple[Ints, Ints, Ints]:
    """Return (from, to, via) of the best path of each class within (1 + slack) of the best, at most `most` a pair.

    The tree of terminal j into it is ``in_*[j]``; terminals are nodes 0 … n − 1.
    """
    n, classes = len(out_distance), out_angle.shape[2]
    capacity = n * n * most
    start, target, through = np.empty(capacity, np.int64), np.empty(capacity, np.int64), np.empty(capacity, np.int64)
    found = 0
    value, node = np.empty(most), np.empty(most, np.int64)
    for i in range(n):
        for j in range(n):
            if i == j or not np.isfinite(out_distance[i, j]):
                continue
            limit = out_distance[i, j] * (1 + slack)
            value[0], node[0] = out_distance[i, j], j
            count = 1
            for v in via:
                s = out_distance[i, v] + in_distance[j, v]
                if not s <= limit:
                    continue
                same = -1
                for k in range(count):
                    equal = True
                    for o in range(classes):
                        turn = (
                            out_angle[i, v, o] + in_angle[j, v, o] - out_angle[i, node[k], o] - in_angle[j, node[k], o]
                        )
                        equal = equal and abs(turn) < 3.0
                    if equal:
                        same = k
                if same >= 0:
                    if s < value[same]:
                        value[same], node[same] = s, v
                elif count < most:
                    value[count], node[count] = s, v
                    count += 1
                else:
                    k = 1 + int(np.argmax(value[1:])) if most > 1 else 0
                    if k > 0 and s < value[k]:
                        value[k], node[k] = s, v
            for k in range(count):
                start[found], target[found], through[found] = i, j, node[k]
                found += 1
    return start[:found], target[:found], through[:found]


@njit(cache=True)
def via_paths(
    out_predecessor: Ints, in_predecessor: Ints, start: Ints, target: Ints, through: Ints
) -> tuple[Ints, Ints]:
    """Return the node sequences start → via → target, held end to end, and their offsets."""
    offsets = np.zeros(len(start) + 1, dtype=np.int64)
    for fill in range(2):
        nodes = np.empty(offsets[-1] if fill else 0, dtype=np.int64)
        for k in range(len(start)):
            first, v = 0, through[k]
            while v != start[k]:
                v = out_predecessor[start[k], v]
                first += 1
            at = offsets[k] + first
            v = through[k]
            if fill:
                u = v
                for back in range(first + 1):
                    nodes[at - back] = u
                    u = out_predecessor[start[k], u]
            while v != target[k]:
                v = in_predecessor[target[k], v]
                at += 1
                if fill:
                    nodes[at] = v
            if not fill:
                offsets[k + 1] = offsets[k] + first + 1 + (at - offsets[k] - first)
    return nodes, offsets
