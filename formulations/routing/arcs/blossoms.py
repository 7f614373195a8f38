"""Separation of blossoms: sets of tasks that what is flown together crosses an odd number of times, nearly.

For handle H the best teeth are the edges e of δ(H) with x_e > ½, and where these are even in number one more or less,
that of x_e nearest ½; the cut is violated where Σ{min(x_e, 1 − x_e) : e ∈ δ(H)}, with that exchange, is below 1. Some
most violated cut is among the fundamental cuts of a cut tree for capacities min(x_e, 1 − x_e) (Letchford, Reinelt &
Theis, "Odd minimum cut sets and b-matchings revisited", SIAM J. Discrete Math. 22, 2008); components of the edges
neither flown nor left out are looked at besides, as flows leave ties open.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse.csgraph import connected_components

from formulations.routing.arcs.joint import Blossom
from formulations.routing.separation import cut_tree
from instances.arrays import Bools, Floats

_MOST = 30
"""Cuts of one call, the most violated ones."""
_FLOWN = 1e-9
"""Less is not flown."""
_DECIDED = (1e-6, 0.1, 0.2, 0.3)
"""How near 0 or 1 an edge is that does not join a component."""


def blossoms(x: Floats, least: float) -> list[Blossom]:
    """Return cuts violated by more than `least`; x (n + 1, n + 1): arcs flown by all UAVs together, depots last."""
    n = len(x) - 1
    edge = x[:n, :n] + x[:n, :n].T
    seen, found = set[bytes](), list[tuple[float, Blossom]]()
    for handle in _handles(x, edge):
        if handle.tobytes() in seen or handle.sum() < 3:
            continue
        seen.add(handle.tobytes())
        edges = _crossing(x, edge, handle)
        flown = np.array([value for _, value in edges])
        together = np.minimum(flown, 1.0 - flown).sum()
        if together >= 1.0 - least:
            continue
        teeth = flown > 0.5
        if teeth.sum() % 2 == 0 and teeth.size:
            nearest = int(np.argmin(np.abs(flown - 0.5)))
            teeth[nearest] = ~teeth[nearest]
            together += abs(1.0 - 2.0 * flown[nearest])
        if together < 1.0 - least and teeth.sum() >= 3:
            chosen = tuple(ends for (ends, _), tooth in zip(edges, teeth, strict=True) if tooth)
            found.append((together, Blossom(n, tuple(np.flatnonzero(handle).tolist()), chosen)))
    found.sort(key=lambda item: item[0])
    return [cut for _, cut in found[:_MOST]]


def _handles(x: Floats, edge: Floats) -> Iterator[Bools]:
    """Yield sets of tasks (n,)."""
    n, weight = len(edge), np.zeros_like(x)
    weight[:n, :n] = np.minimum(edge, 1.0 - edge)
    weight[n, :n] = weight[:n, n] = np.minimum(x[n, :n], 1.0 - x[n, :n]) + np.minimum(x[:n, n], 1.0 - x[:n, n])
    for side in cut_tree(np.where(weight > _FLOWN, weight, 0.0)):
        yield (~side if side[n] else side)[:n]
    for near in _DECIDED:
        count, of = connected_components(np.where((edge > near) & (edge < 1.0 - near), 1, 0), directed=False)
        yield from (of == number for number in range(count))


def _crossing(x: Floats, edge: Floats, handle: Bools) -> list[tuple[tuple[int, int], float]]:
    """Return the edges flown that cross a handle: between tasks, and from depots and to depots."""
    n, inside, outside = len(handle), np.flatnonzero(handle), np.flatnonzero(~handle)
    crossing = edge[np.ix_(inside, outside)]
    edges = [((int(inside[a]), int(outside[b])), float(crossing[a, b])) for a, b in np.argwhere(crossing > _FLOWN)]
    edges += [((n, int(i)), float(x[n, i])) for i in inside if x[n, i] > _FLOWN]
    return edges + [((int(i), n), float(x[i, n])) for i in inside if x[i, n] > _FLOWN]
