"""The check of cuts of all UAVs, whatever a certificate says of them: that they hold for all routes within the U_k.

* Blossom: closed tours cross a set of tasks an even number of times. Each tooth is an edge that crosses it and is flown
  once at most: between two tasks, either way, as each is entered once and on a tour from a depot; or the one arc from
  depots to a task or from it to depots. With t teeth, t odd, either something else crosses or at most t − 1 of them do:
  what else crosses, less the teeth flown, is at least 1 − t.
* Crowd: a tour that passes some tasks and a depot, whatever else it passes, is a 1-tree of these with two legs at every
  node, and whatever is taken off a node's legs is paid back twice. So the least 1-tree, at any potentials and with each
  leg as cheap as the cheapest UAV flies it, over other nodes and in either direction, costs no more than any UAV's tour
  that holds these tasks. Where that is above all U_k, they are entered twice or more.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree

from instances.arrays import Bools, Floats
from instances.certificate.file import Blossom, Crowd
from instances.certificate.tours import UavLegs
from instances.errors import InputError


def joint_row(cut: Blossom | Crowd, n: int) -> tuple[Floats, float]:
    """Return the coefficients of arcs (n + 1, n + 1), the depot last, and what they come to at least.

    InputError where teeth are no odd number of different edges that cross the handle, or tasks are not 0..n − 1.
    """
    tasks = cut.handle if isinstance(cut, Blossom) else cut.tasks
    if not tasks or not {*tasks} <= {*range(n)}:
        raise InputError(f"a cut of all UAVs must be of some of the tasks 0..{n - 1}")
    inside = np.zeros(n + 1, np.bool_)
    inside[list(tasks)] = True
    if isinstance(cut, Crowd):
        return (~inside[:, None] & inside[None]).astype(float), 2.0
    row = (inside[:, None] ^ inside[None]).astype(float)
    arcs = [{(i, j)} if n in (i, j) else {(i, j), (j, i)} for i, j in cut.teeth]
    known = {i for tooth in cut.teeth for i in tooth} <= {*range(n + 1)}
    if len(arcs) % 2 == 0 or not known or any(inside[i] == inside[j] for i, j in cut.teeth):
        raise InputError("a cut of parity must have an odd number of teeth, which cross its handle")
    if len(set[tuple[int, int]]().union(*arcs)) < sum(map(len, arcs)):
        raise InputError("the teeth of a cut of parity must be different edges")
    for i, j in set[tuple[int, int]]().union(*arcs):
        row[i, j] = -1.0
    return row, 1.0 - len(arcs)


def holds_no_tour(cut: Crowd, legs: Sequence[UavLegs], caps: Floats) -> bool:
    """Say whether every UAV's tour of the tasks is proved longer than the caps (m,) [s]; InputError for other sizes."""
    at, potential, longest = sorted({*cut.tasks}), np.array(cut.potential), float(caps.max())
    if potential.size != len(at) + 1 or len(at) != len(cut.tasks) or not np.isfinite(potential).all():
        raise InputError("a crowd must have a finite potential for the depot and for each of its tasks")
    leg = _shortest(legs, longest)
    reduced = leg[np.ix_(at, at)] - potential[1:, None] - potential[None, 1:]
    ends = leg[-1, at] - potential[0] - potential[1:]
    if len(at) < 2:
        return False
    lowest = float(reduced.min()) - 1.0  # of edges of 0 or less a sparse graph knows nothing
    tree = minimum_spanning_tree(np.where(_off_diagonal(len(at)), reduced - lowest, 0.0))
    length = float(tree.sum()) + (len(at) - 1) * lowest + float(np.sort(ends)[:2].sum()) + 2 * float(potential.sum())
    size = longest + 2 * float(np.abs(potential).max()) + 1.0
    return length - 16 * (len(at) + 4) ** 2 * 2.0**-53 * size > longest


def _shortest(legs: Sequence[UavLegs], most: float) -> Floats:
    """Return what the way between two nodes costs at least, (n + 1, n + 1), the depot last, none more than `most`."""
    n = len(legs[0].out)
    leg = np.full((n + 1, n + 1), most)
    for of in legs:
        leg[:n, :n] = np.minimum(leg[:n, :n], np.minimum(of.between, of.between.T))
        leg[n, :n] = np.minimum(leg[n, :n], np.minimum(of.out, of.home))
    leg[:n, n] = leg[n, :n]
    for over in range(n + 1):
        leg = np.minimum(leg, leg[:, over, None] + leg[None, over])
    return leg


def _off_diagonal(size: int) -> Bools:
    return ~np.eye(size, dtype=np.bool_)
