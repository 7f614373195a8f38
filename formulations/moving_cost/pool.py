"""Pool: candidate paths between terminals, held end to end, with the operations that `refined` is made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats, Ints
from instances.kernels import njit


@dataclass(frozen=True, eq=False)
class Pool:
    """Candidate k leads from terminal `start[k]` to `target[k]` along ``points[offsets[k]:offsets[k + 1]]`` [m].

    `corner` (P,) names the obstacle's corner in which a node lies, −1 for none.
    """

    start: Ints
    target: Ints
    points: Floats
    corner: Ints
    offsets: Ints

    def __len__(self) -> int:
        return len(self.start)

    def take(self, which: Ints) -> Pool:
        """Return the candidates `which`, in that order."""
        rows, offsets = _rows(self.offsets, which)
        return Pool(self.start[which], self.target[which], self.points[rows], self.corner[rows], offsets)

    def plus(self, other: Pool) -> Pool:
        """Return the candidates of both."""
        return Pool(
            np.concatenate([self.start, other.start]),
            np.concatenate([self.target, other.target]),
            np.concatenate([self.points, other.points]),
            np.concatenate([self.corner, other.corner]),
            np.concatenate([self.offsets, self.offsets[-1] + other.offsets[1:]]),
        )

    def reversed(self) -> Pool:
        """Return the same paths flown backwards, last candidate first."""
        offsets = self.offsets[-1] - self.offsets[::-1]
        # copies: the kernels would be compiled once more for views that run backwards
        return Pool(self.target[::-1], self.start[::-1], self.points[::-1].copy(), self.corner[::-1].copy(), offsets)

    def best(self, cost: Floats) -> Ints:
        """Return the cheapest candidate of each ordered pair, by (start, target)."""
        order = np.lexsort((cost, self.target, self.start))
        s, t = self.start[order], self.target[order]
        first = np.ones(len(order), dtype=bool)
        first[1:] = (s[1:] != s[:-1]) | (t[1:] != t[:-1])
        return order[first]

    def joined(self, first: Ints, second: Ints) -> Pool:
        """Return the paths along candidate `first[k]`, then `second[k]`, which starts where the first ends."""
        legs = np.column_stack([first, second]).ravel()
        rows, offsets = _rows(self.offsets, legs)
        keep = np.ones(len(rows), dtype=bool)
        keep[offsets[1:-1:2]] = False  # the common node, once
        count = np.diff(offsets)[::2] + np.diff(offsets)[1::2] - 1
        ends = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
        return Pool(self.start[first], self.target[second], self.points[rows[keep]], self.corner[rows[keep]], ends)


@njit(cache=True)
def _rows(offsets: Ints, which: Ints) -> tuple[Ints, Ints]:
    """Rows of the points of candidates `which`, and their new offsets."""
    out = np.zeros(len(which) + 1, dtype=np.int64)
    for k in range(len(which)):
        out[k + 1] = out[k] + offsets[which[k] + 1] - offsets[which[k]]
    rows = np.empty(out[-1], dtype=np.int64)
    for k in range(len(which)):
        for r in range(out[k + 1] - out[k]):
            rows[out[k] + r] = offsets[which[k]] + r
    return rows, out
