"""Heights of tours: the track of each UAV over the ground below it, from take-off to landing."""

from __future__ import annotations

import numpy as np
import pandas as pd

from instances.environment.terrain import Terrain
from reports.figures.chart import Axis, Chart, Panel, Series
from reports.figures.flight import colour_of
from reports.figures.static import drawn
from reports.figures.style import INK, Style
from reports.figures.svg import Drawn
from reports.figures.wind import KM

MOST_POINTS = 600
"""Of a profile that is drawn: more are not told apart on a page."""


def draw_heights(flown: pd.DataFrame, ground: Terrain | None) -> Drawn:
    """Return a height profile a UAV. flown : columns uav, x, y, z [m]; ground : flat at 0 m where None."""
    panels = []
    for k, track in flown.groupby("uav"):
        points, z = track[["x", "y"]].to_numpy(), track["z"].to_numpy()
        below = np.zeros(len(z)) if ground is None else ground(points)
        travelled = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))) / KM
        nearest = int(np.argmin(z - below))
        shown = np.unique(np.append(np.linspace(0, len(z) - 1, MOST_POINTS).astype(int), nearest))
        x, floor = travelled[shown], np.full(len(shown), min(0.0, float(below.min())))
        at, low, high = travelled[nearest], below[nearest], z[nearest]
        series = [
            Series("ground", x, below[shown], low=floor, high=below[shown], size=0, width=0.8),
            Series(f"UAV {k}", x, z[shown], Style(colour_of(int(str(k))), "-", "o"), size=0),
            Series("nearest to the ground", [at, at], [low, high], Style(INK, "-", "_"), width=0.8),
        ]
        ends = Axis("flown", "km", span=(0.0, float(travelled[-1]) or 1.0))
        title = f"UAV {k}, at least {high - low:.0f} m above the ground"
        panels.append(Panel(ends, Axis("height", "m"), series, title))
    flat = "" if ground is not None else " No terrain was given: the ground is taken as flat at 0 m."
    caption = (
        "Heights above mean sea level along each tour, over the ground below (grey), and where the track is nearest to "
        f"it (mark). Take-off and landing, at the depot, are not drawn.{flat}"
    )
    return drawn("heights", "Heights of the tours", caption, Chart(panels, 1, 1.6))
