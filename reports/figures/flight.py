"""Tours on the map: reference paths and what was flown, over the wind; and other ways to fly side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
import shapely
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from instances.arrays import Floats
from instances.environment.region import Region
from instances.scenario import Scenario
from reports.figures.style import COLOURS, FAINT, INK, PAPER, RC, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes, wind_arrows

DEPOT = "#cc2936"
"""Colour of depots."""


@rc_context(RC)
def draw_flight(scenario: Scenario, tasks: Floats, reference: pd.DataFrame, flown: pd.DataFrame) -> Drawn:
    """Return the paper's figure: depots, tasks, reference paths and flown paths over the wind; and a piece enlarged.

    reference : columns uav, leg, x, y [m]; flown : uav, time, x, y.
    """
    figure = new_figure(9.6, 4.9)
    whole, detail = figure.subplots(1, 2, width_ratios=[1.35, 1.0])
    for axes in (whole, detail):
        map_axes(axes, scenario.free)
        for zone in scenario.no_fly:
            axes.plot(*(np.asarray(zone.exterior.coords)[:, :2].T / KM), color=INK, linewidth=0.8, zorder=2)
        for k, track in flown.groupby("uav"):
            path = reference[reference["uav"] == k]
            axes.plot(track["x"] / KM, track["y"] / KM, color=colour_of(int(str(k))), linewidth=1.6, zorder=3)
            axes.plot(path["x"] / KM, path["y"] / KM, color=INK, linewidth=0.7, zorder=4)
        axes.scatter(*(tasks.T / KM), s=14, color=COLOURS[0], edgecolors=PAPER, linewidths=0.5, zorder=5)
        stars(axes, scenario.depots)
    if scenario.wind is not None:
        wind_arrows(whole, scenario.wind, scenario.free, colour=f"{FAINT}99")
    legend_of(figure, [int(str(k)) for k in flown["uav"].unique()], reference=True, tasks=True)
    centre, half = _turn(reference, flown), 0.3
    detail.set_xlim(centre[0] - half, centre[0] + half)
    detail.set_ylim(centre[1] - half, centre[1] + half)
    detail.set_title("a turn, enlarged")
    detail.set_ylabel("")
    caption = (
        "Depots (stars), tasks (dots), the reference paths of the moving costs (thin, dark) and what is flown along "
        "them at the minimum turning radius (one colour a UAV), over the wind (arrows). Right: where the two differ "
        "most."
    )
    return Drawn("flight", "Reference paths and flown paths", caption, figure)


@rc_context(RC)
def draw_plans(region: Region, depots: Floats, tracks: pd.DataFrame, table: pd.DataFrame, unit: str) -> Drawn:
    """Return a map a way to fly. tracks : name, uav, x, y; table : name, length, rmse, verdict."""
    columns = min(4, len(table))
    rows = -(-len(table) // columns)
    figure = new_figure(7.2, 2.35 * rows + 0.2)
    plots = figure.subplots(rows, columns, sharey=True, sharex=True, squeeze=False)
    for axes in plots.ravel()[len(table) :]:
        axes.set_visible(False)
    for axes, (_, row) in zip(plots.ravel(), table.iterrows(), strict=False):
        map_axes(axes, region)
        mine = tracks[tracks["name"] == row["name"]]
        for k, track in mine.groupby("uav"):
            axes.plot(track["x"] / KM, track["y"] / KM, color=colour_of(int(str(k))), linewidth=1.1)
        stars(axes, depots, 40)
        refused = " (not flyable)" if row["verdict"] == "not flyable" else ""
        words = f"{row['name']}{refused}\n{row['length'] / KM:.0f} km, RMSE {row['rmse']:.2f} {unit}"
        axes.set_title(words, fontsize=8.5)
    for axes in plots[:, 1:].ravel():
        axes.set_ylabel("")
    legend_of(figure, [int(k) for k in sorted(tracks["uav"].unique())])
    caption = (
        "Every plan starts and ends at the same depots (stars). Lawnmower and random tours are at least as long as the "
        "mission's. Drawn are the tours of the first draw; lengths and RMSE are means over all."
    )
    return Drawn("plans", "The ways to fly that are compared", caption, figure)


def stars(axes: Axes, depots: Floats, size: float = 110) -> None:
    """Draw the depots, as stars."""
    x, y = depots.T / KM
    axes.scatter(x, y, s=size, marker="*", color=DEPOT, edgecolors=PAPER, linewidths=0.8, zorder=6)


def legend_of(figure: Figure, uavs: Sequence[int], *, reference: bool = False, tasks: bool = False) -> None:
    """Put a legend below `figure`: the colour of each UAV, the star of a depot and, where drawn, the other marks."""
    handles = [Line2D([], [], color=colour_of(k), linewidth=2.0, label=f"UAV {k}") for k in uavs]
    handles += [Line2D([], [], color=INK, linewidth=0.9, label="reference path")] if reference else []
    mark: dict[str, Any] = {"linestyle": "none", "markeredgecolor": PAPER, "markeredgewidth": 0.5}
    handles += [Line2D([], [], marker="o", color=COLOURS[0], markersize=5, label="task", **mark)] if tasks else []
    handles += [Line2D([], [], marker="*", color=DEPOT, markersize=10, label="depot", **mark)]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 7), handlelength=1.8)


def colour_of(uav: int) -> str:
    """Return the colour of a UAV."""
    return COLOURS[1:][uav % (len(COLOURS) - 1)]


def _turn(reference: pd.DataFrame, flown: pd.DataFrame) -> Floats:
    """Return the point [km] of the flown paths farthest from the reference paths' own points and lines."""
    best, where = -1.0, np.zeros(2)
    for k, track in flown.groupby("uav"):
        path = shapely.linestrings(reference.loc[reference["uav"] == k, ["x", "y"]].to_numpy())
        points = track[["x", "y"]].to_numpy()
        away = shapely.distance(shapely.points(points), path)
        if away.max() > best:
            best, where = float(away.max()), points[int(np.argmax(away))] / KM
    return where
