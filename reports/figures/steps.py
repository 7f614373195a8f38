"""Steps: the empirical distribution of a sample as a step line, the shape of every profile here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from instances.arrays import Floats
from reports.figures.style import MARKERS, RC, Style, legend_below, new_figure, plain

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


@rc_context(RC)
def step_figure(
    values: Lines, look: dict[str, Style], span: tuple[float, float], x: str, of: str, **scale: Any
) -> Figure:
    """Draw `step_axes` as a figure of its own with its legend. of : what the shares are of."""
    figure = new_figure()
    axes = figure.add_subplot()
    step_axes(axes, values, look, span, x, **scale)
    axes.set_ylabel(f"share of {of} [%]")
    legend_below(figure, axes)
    return figure


def step_axes(
    axes: Axes, values: Lines, look: dict[str, Style], span: tuple[float, float], x: str, **scale: Any
) -> None:
    """Draw a line a method: the share of its `values` at or below x, labelled `x`, from end to end of `span`.

    scale : of x, as `set_xscale` takes it.
    """
    for method, mine in values.items():
        step_line(axes, mine, look[str(method)], str(method), *span)
    axes.set_xscale(**scale)
    plain(axes.xaxis)
    axes.set(xlabel=x, xlim=span, ylim=(-2, 102))


def step_line(axes: Axes, values: ArrayLike, look: Style, label: str, start: float, end: float) -> None:
    """Draw the share of `values` at or below x [%], from `start` to `end`; infinite ones are never reached."""
    x, share = cumulative(values)
    x = np.concatenate([[start], np.maximum(x, start), [max(end, start)]])
    y = np.concatenate([[0.0], share, [share[-1] if share.size else 0.0]])
    axes.plot(x, 100 * y, color=look.colour, linestyle=look.dash, drawstyle="steps-post")
    axes.plot([], [], color=look.colour, linestyle=look.dash, marker=look.marker, markersize=4, label=label)
    shift = 0.8 * MARKERS.index(look.marker) / len(MARKERS)  # so that marks of lines that coincide stand side by side
    low, high = max(start, end / 1e3), max(end, start)
    marks = low * (high / low) ** ((np.arange(4) + 0.15 + shift) / 4)
    height = y[np.searchsorted(x, marks, side="right") - 1]
    axes.plot(marks, 100 * height, look.marker, color=look.colour, markersize=4, linestyle="none")
