"""Efforts: how hard to work at a node: quick and rough first, harder where that does not settle the matter.

Tasks remembered, cuts watched and bins multiply in the completion bounds, so what one takes more the others take less:
cuts are watched only where there are some, and beyond 100 tasks all are fewer.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from formulations.routing.columns.pricing import Effort


class Efforts(NamedTuple):
    """How hard to work: `pricing` in the order to try, quick ones first; `thorough` to fix and list."""

    pricing: tuple[Effort, ...]
    thorough: Effort


def efforts(n_tasks: int, bins: int) -> tuple[Efforts, Efforts]:
    """Return how hard to work at a node without cuts and at one with cuts; at most `bins` bins."""
    quick, middle, fine = (max(1, bins * tenths // 10) for tenths in (3, 5, 8))
    few, more = Effort(3, quick, 200), Effort(3, quick, 3000)
    if n_tasks <= 100:
        plain = Efforts((few, more, Effort(6, fine, 20_000), Effort(7, bins, 300_000)), Effort(7, bins, 0))
        watching = (replace(few, watch=3), replace(more, watch=4), Effort(4, middle, 30_000, 4))
        return plain, Efforts((*watching, Effort(5, middle, 300_000, 4)), Effort(5, fine, 0, 4))
    plain = Efforts((few, more, Effort(4, fine, 20_000), Effort(5, bins, 300_000)), Effort(5, fine, 0))
    watching = (replace(few, watch=1), replace(more, watch=2), Effort(3, middle, 30_000, 2))
    return plain, Efforts((*watching, Effort(4, middle, 300_000, 2)), Effort(4, middle, 0, 2))
