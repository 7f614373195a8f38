"""Heights of tours: the track of each UAV over the ground below it, from take-off to landing."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context

from instances.environment.terrain import Terrain
from reports.figures.flight import colour_of
from reports.figures.style import FAINT, INK, RC, WIDTH, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM

MOST_POINTS = 600
"""Of a profile that is drawn: more are not told apart on a page."""


@rc_context(RC)
def draw_heights(flown: pd.DataFrame, ground: Terrain | None) -> Drawn:
    """Return a height profile a UAV. flown : columns uav, x, y, z [m]; ground : flat at 0 m where None."""
    tracks = list(flown.groupby("uav"))
    figure = new_figure(WIDTH, 1.35 * len(tracks) + 0.5)
    plots = figure.subplots(len(tracks), 1, sharey=True, squeeze=False)[:, 0]
    for axes, (k, track) in zip(plots, tracks, strict=True):
        points, z = track[["x", "y"]].to_numpy(), track["z"].to_numpy()
        below = np.zeros(len(z)) if ground is None else ground(points)
        travelled = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))) / KM
        nearest = int(np.argmin(z - below))
        shown = np.unique(np.append(np.linspace(0, len(z) - 1, MOST_POINTS).astype(int), nearest))
        axes.fill_between(travelled[shown], below[shown], min(0.0, below.min()), color=FAINT, alpha=0.45, linewidth=0)
        axes.plot(travelled[shown], z[shown], color=colour_of(int(str(k))))
        at, low, high = travelled[nearest], below[nearest], z[nearest]
        axes.plot([at, at], [low, high], color=INK, linewidth=0.8, marker="_", markersize=5)
        axes.set_title(f"UAV {k}, at least {high - low:.0f} m above the ground", loc="left")
        axes.set_xlim(0.0, travelled[-1])
        axes.set_ylabel("height [m]")
    plots[-1].set_xlabel("flown [km]")
    flat = "" if ground is not None else " No terrain was given: the ground is taken as flat at 0 m."
    caption = (
        "Heights above mean sea level along each tour, over the ground below (grey), and where the track is nearest to "
        f"it (mark). Take-off and landing, at the depot, are not drawn.{flat}"
    )
    return Drawn("heights", "Heights of the tours", caption, figure)
