"""Surveys: where each plan flies over a field, and the error of its map against endurance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib import rc_context

from instances.arrays import Floats
from instances.environment.radio import RadioMap
from instances.environment.region import Region
from reports.figures.chart import Axis, Chart, Panel, Series
from reports.figures.field import extent_of, show
from reports.figures.static import drawn
from reports.figures.style import INK, PAPER, RC, Style, new_figure, styles
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes
from reports.statistics.paired import Paired, paired

COLUMNS = 3
"""Maps beside one another."""


@dataclass(frozen=True, eq=False)
class FlownPlan:
    """One plan over one field: its name, RMSE, and for each UAV tour and samples (k, 2) [m]."""

    method: str
    rmse: float
    tours: Sequence[Floats]
    samples: Sequence[Floats]


def draw_tours(name: str, field: RadioMap, region: Region, depots: Floats, plans: Sequence[FlownPlan]) -> Drawn:
    """Return a map a plan: `field` with its tours and samples. name : of the survey."""
    rows = -(-len(plans) // COLUMNS)
    inside = region.contains(np.stack(np.meshgrid(field.x, field.y), axis=-1).reshape(-1, 2))
    values = np.where(inside.reshape(field.values.shape), field.values, np.nan)
    with rc_context(RC):
        figure = new_figure(height=0.5 + 2.35 * rows)
        grid = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False)
        for axes, plan in zip(grid.flat, plans, strict=False):
            image = show(axes, values, extent_of(field.x, field.y))
            map_axes(axes, region)
            for tour, samples in zip(plan.tours, plan.samples, strict=True):
                axes.plot(*(tour.T / KM), color=PAPER, linewidth=2.0, zorder=3)
                axes.plot(*(tour.T / KM), color=INK, linewidth=0.8, zorder=4)
                axes.scatter(*(samples.T / KM), s=3, color=INK, zorder=5, linewidths=0)
            axes.scatter(*(depots.T / KM), s=26, marker="s", color=INK, edgecolors=PAPER, linewidths=0.9, zorder=6)
            axes.set_title(f"{plan.method}: {plan.rmse:.3g}", loc="left")
            axes.label_outer()
        for axes in list(grid.flat)[len(plans) :]:
            axes.set_visible(False)
        figure.colorbar(image, ax=grid, label=f"field [{field.unit}]" if field.unit else "field", shrink=0.8 / rows)
    caption = (
        f"{name}: the field, and over it every plan's tours from the depots (squares) and back with the places of its "
        "readings (dots); beside its name the RMSE of the map."
    )
    return Drawn("tours", "Where they fly", caption, figure)


def draw_endurance(frame: pd.DataFrame) -> Drawn:
    """Return mean RMSE against endurance, a panel a name of fields and a line a plan.

    frame : a row a run: family, endurance [s], method, digest, rmse; NaN where it failed.
    """
    solved, look = frame.dropna(subset=["rmse"]), styles(frame["method"])
    panels = []
    for family, rows in solved.groupby("family", sort=False):
        units = rows["unit"].unique()
        x = Axis("endurance", "s", ticks=sorted(rows["endurance"].unique()))
        y = Axis("RMSE of the map", str(units[0]), span=(0.0, None))
        panels.append(Panel(x, y, _lines(rows, look), str(family)))
    caption = (
        "Root mean square error of the map against the longest flight allowed: means over fields and noise; bars are "
        "95 % intervals of these means (Student's t), which say how fields differ. Plans share their fields, so that "
        "two plans are told apart by the paired differences of the table, not by whether their bars overlap."
    )
    return drawn("endurance", "Error against endurance", caption, Chart(panels, min(2, max(1, len(panels))), 3.0))


def _lines(rows: pd.DataFrame, look: Mapping[str, Style]) -> list[Series]:
    lines = []
    for method, mine in rows.groupby("method", sort=True):
        each = mine.groupby(["endurance", "digest"])["rmse"].median().groupby("endurance")
        found = {float(str(endurance)): paired(values.to_numpy()) for endurance, values in each}
        x, mean = list(found), [one.mean for one in found.values()]
        low, high = ([_end(one, end) for one in found.values()] for end in ("low", "high"))
        lines.append(Series(str(method), x, mean, look[str(method)], low=low, high=high, spread="bars"))
    return lines


def _end(found: Paired, end: str) -> float:
    """Return an end of the interval, the mean where a single field has none."""
    value = float(getattr(found, end))
    return value if np.isfinite(value) else found.mean
