"""Steps: the empirical distribution of a sample as a step line, the shape of every profile here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from reports.figures.chart import Axis, Panel, Series
from reports.figures.style import Style

Lines = Mapping[Any, Any]
"""Method → its figures, infinite where it never got there."""
POINTS = 400
"""Steps drawn of one line; more cannot be told apart."""


def cumulative(values: ArrayLike) -> tuple[Floats, Floats]:
    """Return the finite `values` sorted and, beside each, the share of all values at or below it."""
    v = np.asarray(values, dtype=float)
    finite = np.sort(v[np.isfinite(v)])
    share = np.arange(1, finite.size + 1) / max(1, v.size)
    if finite.size > POINTS:
        kept = np.unique(np.linspace(0, finite.size - 1, POINTS).astype(int))
        return finite[kept], share[kept]
    return finite, share


def step_panel(values: Lines, look: dict[str, Style], x: Axis, of: str, title: str = "") -> Panel:
    """Return a panel with a line a method: the share of its `values` at or below x, from end to end of `x`.

    of : what the shares are of.
    """
    start, end = x.span
    assert start is not None
    assert end is not None
    series = [_line(str(method), mine, look[str(method)], start, end) for method, mine in values.items()]
    return Panel(x, Axis(f"share of {of}", "%", span=(-2.0, 102.0)), series, title)


def _line(name: str, values: ArrayLike, look: Style, start: float, end: float) -> Series:
    """Return the share of `values` at or below x [%], from `start` to `end`; infinite ones are never reached."""
    x, share = cumulative(values)
    x = np.concatenate([[start], np.maximum(x, start), [max(end, start)]])
    y = np.concatenate([[0.0], share, [share[-1] if share.size else 0.0]])
    return Series(name, x, 100 * y, look, "step")
