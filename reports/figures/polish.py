"""Path polish on the map: tours as they were planned and with their waypoints moved, side by side."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context

from instances.arrays import Floats
from instances.scenario import Scenario
from reports.figures.flight import colour_of, legend_of, stars
from reports.figures.style import COLOURS, INK, PAPER, RC, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes


@rc_context(RC)
def draw_polish(scenario: Scenario, tasks: Floats, given: pd.DataFrame, polished: pd.DataFrame) -> Drawn:
    """Return two maps, of waypoints before and after: columns uav, x, y [m], in `polished` also task, -1 for none."""
    figure = new_figure(7.2, 3.7)
    plots = figure.subplots(1, 2, sharey=True)
    now = polished.loc[polished["task"] >= 0, ["x", "y"]].to_numpy()
    shown = (("as planned", given, tasks), ("polished", polished, now))
    for axes, (title, paths, places) in zip(plots, shown, strict=True):
        map_axes(axes, scenario.free)
        for zone in scenario.no_fly:
            axes.plot(*(np.asarray(zone.exterior.coords)[:, :2].T / KM), color=INK, linewidth=0.8, zorder=2)
        for k, path in paths.groupby("uav"):
            axes.plot(path["x"] / KM, path["y"] / KM, color=colour_of(int(str(k))), linewidth=1.2, zorder=3)
            axes.scatter(path["x"] / KM, path["y"] / KM, s=4, color=colour_of(int(str(k))), zorder=3)
        axes.scatter(*(places.T / KM), s=14, color=COLOURS[0], edgecolors=PAPER, linewidths=0.5, zorder=5)
        stars(axes, scenario.depots, 60)
        axes.set_title(title)
    plots[1].set_ylabel("")
    legend_of(figure, [int(k) for k in sorted(given["uav"].unique())], tasks=True)
    caption = (
        "Paths over the waypoints, turns left out; legs are split at the small dots. Every waypoint between take-off "
        "and landing was moved, tasks (large dots) among them; the order of visits stayed."
    )
    return Drawn("polish", "Tours before and after path polish", caption, figure)
