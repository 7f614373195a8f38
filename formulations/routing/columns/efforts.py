"""Efforts: how hard to work at a node: quick and rough first, harder where that does not settle the matter.

Tasks remembered, cuts watched and bins multiply in the completion bounds, so what one takes more the others take less:
cuts are watched only where there are some, and beyond 100 tasks all are fewer.
"""

from __future__ import annotations

from typing import NamedTuple

from formulations.routing.columns.pricing import Effort

_MANY = 100  # tasks


class Efforts(NamedTuple):
    """How hard to work: `pricing` in the order to try, quick ones first; `thorough` to fix and list."""

    pricing: tuple[Effort, ...]
    thorough: Effort


def without_cuts(n_tasks: int, most: int) -> Efforts:
    """Return how hard to work at a node without cuts, with at `most` so many bins."""
    quick, _, fine = _bins(most)
    near, thorough = (7, most) if n_tasks <= _MANY else (5, fine)
    return Efforts(
        (
            Effort(3, quick, 200),
            Effort(3, quick, 3000),
            Effort(near - 1, fine, 20_000),
            Effort(near, most, 300_000),
        ),
        Effort(near, thorough, 0),
    )


def with_cuts(n_tasks: int, most: int) -> Efforts:
    """Return how hard to work at a node with cuts, with at `most` so many bins."""
    quick, middle, fine = _bins(most)
    if n_tasks <= _MANY:
        pricing = (
            Effort(3, quick, 200, 3),
            Effort(3, quick, 3000, 4),
            Effort(4, middle, 30_000, 4),
            Effort(5, middle, 300_000, 4),
        )
        return Efforts(pricing, Effort(5, fine, 0, 4))
    pricing = (
        Effort(3, quick, 200, 1),
        Effort(3, quick, 3000, 2),
        Effort(3, middle, 30_000, 2),
        Effort(4, middle, 300_000, 2),
    )
    return Efforts(pricing, Effort(4, middle, 0, 2))


def _bins(most: int) -> tuple[int, int, int]:
    """Return few, some and many bins."""
    quick, middle, fine = (max(1, most * tenths // 10) for tenths in (3, 5, 8))
    return quick, middle, fine
