"""Chart: what a figure shows, panel by panel, whoever draws it: `static` on paper, `interactive` in a page.

A chart holds true values with their units. How a scale turns them into places is its renderer's business.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from instances.arrays import Floats
from reports.figures.style import FAINT, INK, Style

Scale = Literal["linear", "log", "gap"]
"""gap: logarithmic, linear below 0.1."""
Kind = Literal["line", "step", "points"]
"""step: a value holds from its x to the next."""
Spread = Literal["band", "bars", "across"]
"""What `low` and `high` are drawn as: a band about a line, bars along y, or bars along x."""

REFERENCE = Style(INK, (0, (3, 2)), "o")
"""How something is drawn that the methods are measured by."""
QUIET = Style(FAINT, "-", "o")
"""How something is drawn that stands behind."""


@dataclass(frozen=True)
class Axis:
    """One side of a panel: what is along it, in which unit, on which scale.

    span : its ends, None where the data say. ticks : where they are not the scale's own. names : of 0, 1, 2, … where it
    counts things rather than measures.
    """

    label: str
    unit: str = ""
    scale: Scale = "linear"
    span: tuple[float | None, float | None] = (None, None)
    ticks: Sequence[float] = ()
    names: Sequence[str] = ()

    @property
    def words(self) -> str:
        """Label and unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


@dataclass(frozen=True, eq=False)
class Series:
    """Values y at x, drawn in one look.

    name : the method, or what else the legend says; without one it is scenery: in no legend and no table. low, high :
    ends of a spread. more : further columns, by heading. size : of marks [pt]; lines have a few marks to be told apart
    by, none where it is 0. hollow : marks are outlines. aside : factor on x where it is drawn, so that what is at the
    same x is told apart. marked : where a line has its marks. labels : the further column that is written beside points
    on paper; a page tells it under the pointer.
    """

    name: str
    x: ArrayLike
    y: ArrayLike
    look: Style = QUIET
    kind: Kind = "line"
    low: ArrayLike | None = None
    high: ArrayLike | None = None
    spread: Spread = "band"
    more: Mapping[str, ArrayLike] = field(default_factory=dict)
    width: float = 1.6
    size: float = 4.0
    hollow: bool = False
    opacity: float = 1.0
    aside: float = 1.0
    marked: Literal["along", "end"] = "along"
    labels: str = ""

    @property
    def values(self) -> dict[str, Any]:
        """x, y, low and high as far as there are, and the further columns."""
        ends = {} if self.low is None else {"low": self.low, "high": self.high}
        numbers = {key: np.asarray(of, dtype=float) for key, of in {"x": self.x, "y": self.y, **ends}.items()}
        return {**numbers, **{key: np.asarray(of) for key, of in self.more.items()}}


@dataclass(frozen=True)
class Rule:
    """A straight line across a panel at `at` of its x or y axis; `look` says how."""

    axis: Literal["x", "y"]
    at: float
    look: Style = QUIET


@dataclass(frozen=True)
class Panel:
    """Series over a pair of axes."""

    x: Axis
    y: Axis
    series: Sequence[Series]
    title: str = ""
    rules: Sequence[Rule] = ()

    def span(self, side: Literal["x", "y"]) -> tuple[float, float]:
        """Return the ends of an axis: those stated, else of all its finite values with a margin."""
        axis: Axis = getattr(self, side)
        low, high = self._reach(side, axis)
        if axis.names:
            low, high = -0.6, len(axis.names) - 0.4
        elif axis.scale == "log":
            low, high = (low, high) if high > low else (low / 2, high * 2)
            margin = (high / low) ** 0.04
            low, high = low / margin, high * margin
        elif axis.scale == "gap":
            low, high = (1.3 * low if low < 0 else -0.012), 1.2 * max(high, 0.1)
        else:
            margin = 0.05 * ((high - low) or abs(high) or 1.0)
            low, high = low - margin, high + margin
        return (low if axis.span[0] is None else axis.span[0]), (high if axis.span[1] is None else axis.span[1])

    def _reach(self, side: str, axis: Axis) -> tuple[float, float]:
        """Return the least and greatest value along an axis; 0.5 and 2 where there is none."""
        given = [rule.at for rule in self.rules if rule.axis == side]
        parts = [np.array(given), *(part for one in self.series for part in _along(one, side))]
        values = np.concatenate(parts)
        values = values[np.isfinite(values) & ((values > 0) if axis.scale == "log" else True)]
        return (float(values.min()), float(values.max())) if values.size else (0.5, 2.0)


def _along(series: Series, side: str) -> list[Floats]:
    """Return the values of `series` along an axis, ends of spreads with them."""
    values, ends = series.values, "x" if series.spread == "across" else "y"
    return [
        values[side] * (series.aside if side == "x" else 1),
        *([values["low"], values["high"]] if side == ends and "low" in values else []),
    ]


@dataclass(frozen=True)
class Chart:
    """Panels in rows of `columns`, each `height` [inch] high; `shared`: all have the same axes."""

    panels: Sequence[Panel]
    columns: int = 1
    height: float = 2.9
    shared: bool = False

    @property
    def looks(self) -> dict[str, Series]:
        """Name → the first series of that name: what a legend shows."""
        found: dict[str, Series] = {}
        for panel in self.panels:
            for series in panel.series:
                if series.name:
                    found.setdefault(series.name, series)
        return found

    @property
    def titled(self) -> bool:
        """Whether titles of panels or names along an axis say all that a legend would."""
        titles = [panel.title for panel in self.panels]
        return titles == list(self.looks) or all(panel.x.names or panel.y.names for panel in self.panels)

    @property
    def headings(self) -> dict[str, str]:
        """x and y → their headings in a table: label and unit where all panels have the same."""
        words = {side: {getattr(panel, side).words for panel in self.panels} for side in ("x", "y")}
        return {side: min(found) if len(found) == 1 else side for side, found in words.items()}

    def frame(self) -> pd.DataFrame:
        """Return what is shown as a table: panel, series, x and y (by heading), low, high and further columns.

        Where panels differ in what is along an axis, a column of each row says it.
        """
        heads = self.headings
        parts = []
        for panel in self.panels:
            differing = {f"{side} is": getattr(panel, side).words for side in heads if heads[side] == side}
            for series in panel.series:
                if series.name:
                    values = {heads.get(key, key): of for key, of in named(panel, series.values).items()}
                    given = {"panel": panel.title, "series": series.name, **differing}
                    parts.append(pd.DataFrame({**given, **values}, index=range(len(values[heads["x"]]))))
        table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame({"panel": [], "series": []})
        return table if any(panel.title for panel in self.panels) else table.drop(columns="panel")


def named(panel: Panel, values: dict[str, Any]) -> dict[str, Any]:
    """Return `values` of a series with names in place of numbers along axes that count things."""
    found = dict(values)
    for side in ("x", "y"):
        names = getattr(panel, side).names
        if names:
            found[side] = [names[round(place)] for place in values[side]]
    return found


def marks(panel: Panel, series: Series, rank: int, count: int = 4) -> tuple[Floats, Floats]:
    """Return where a line has its marks: at its points if they are few, else at `count` places of the axis.

    `rank` shifts these, so that marks of lines that coincide stand side by side.
    """
    x, y = series.values["x"], series.values["y"]
    if series.size == 0 or not len(x):
        return np.empty(0), np.empty(0)
    if series.marked == "end":
        return x[-1:] * series.aside, y[-1:]
    if series.kind == "line" and len(x) <= 24:
        return x * series.aside, y
    low, high = panel.span("x")
    shares = (np.arange(count) + 0.15 + 0.8 * (rank % 9) / 9) / count
    places = low * (high / low) ** shares if panel.x.scale == "log" else low + (high - low) * shares
    before = np.searchsorted(x, places, side="right") - 1
    held = (before >= 0) & (places <= x[-1])
    heights = y[before[held]] if series.kind == "step" else np.interp(places[held], x, y)
    return places[held], heights
