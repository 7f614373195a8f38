"""A wind that changes, in frames: its arrows while the tours are flown, and how far the UAVs have come."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context

from instances.arrays import Floats
from instances.environment.wind_changing import ChangingWind
from instances.scenario import Scenario
from reports.figures.flight import colour_of
from reports.figures.style import FAINT, INK, RC, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes

FRAMES = 4
ARROWS = 9
"""Arrows along the longer side of the region."""
LENGTH = 0.9
"""Of the longest arrow, in distances between arrows."""


def arrows_at(scenario: Scenario, wind: ChangingWind, times: Floats) -> tuple[Floats, Floats, float]:
    """Return places (k, 2) [m], velocities (times, k, 2) [m/s] there, and how long 1 m/s is drawn [m]."""
    x0, y0, x1, y1 = scenario.region.bounds
    size = max(x1 - x0, y1 - y0) / ARROWS
    nx, ny = max(2, round((x1 - x0) / size)), max(2, round((y1 - y0) / size))
    xs, ys = x0 + (np.arange(nx) + 0.5) * (x1 - x0) / nx, y0 + (np.arange(ny) + 0.5) * (y1 - y0) / ny
    places = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    places = places[scenario.free.contains(places)]
    w = np.stack([wind.velocities(places, np.full(len(places), time)) for time in times])
    return places, w, LENGTH * size / (float(np.hypot(w[..., 0], w[..., 1]).max(initial=0.0)) or 1.0)


@rc_context(RC)
def draw_wind_frames(scenario: Scenario, wind: ChangingWind, flown: pd.DataFrame) -> Drawn:
    """Return the figure of `wind` at some moments, with the tracks `flown` (uav, time [s], x, y [m]) up to them."""
    times = np.linspace(0.0, float(flown["time"].max()), FRAMES)
    places, w, scale = arrows_at(scenario, wind, times)
    figure = new_figure(7.2, 2.6)
    panels = figure.subplots(1, FRAMES, sharey=True)
    for axes, time, now in zip(panels, times, w, strict=True):
        map_axes(axes, scenario.free)
        axes.quiver(
            *(places.T / KM), *now.T, color=FAINT, angles="xy", scale_units="xy", scale=KM / scale, pivot="mid",
            width=0.008, headwidth=3.6, headlength=4.0, headaxislength=3.6,
        )  # fmt: skip
        for k, track in flown.groupby("uav"):
            done = track[track["time"] <= time + 1e-6]
            colour = colour_of(int(str(k)))
            axes.plot(done["x"] / KM, done["y"] / KM, color=colour, linewidth=1.0)
            axes.plot(done["x"].iloc[-1:] / KM, done["y"].iloc[-1:] / KM, "o", color=colour, markersize=3)
        axes.plot(*(scenario.depots.T / KM), "*", color=INK, markersize=4)
        axes.set_title(f"{time / 60:.0f} min")
        axes.set_xlabel("x [km]")
    for axes in panels[1:]:
        axes.set_ylabel("")
    top = float(np.hypot(w[..., 0], w[..., 1]).max(initial=0.0))
    caption = f"The wind at four moments, its longest arrow {top:.3g} m/s, and where the UAVs are by then."
    return Drawn("wind-frames", "Wind while it is flown", caption, figure)
