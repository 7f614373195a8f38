"""The map as it grows: uncertainty, estimate and flown portion, early and at the end; and the last one judged."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, PowerNorm

from instances.arrays import Floats
from instances.environment.region import Region
from reports.figures.field import SIGNAL, UNCERTAINTY, UNCERTAINTY_POWER, show
from reports.figures.flight import colour_of, legend_of, stars
from reports.figures.style import INK, PAPER, RC, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes
from reports.products import Maps

EARLY = 0.2
"""Share of the mission's time at which its initial stage is drawn."""


@rc_context(RC)
def draw_stages(
    maps: Maps, region: Region, depots: Floats, flown: pd.DataFrame, samples: pd.DataFrame, unit: str
) -> Drawn:
    """Return the paper's figure: (a) initial and (b) final stage, each as uncertainty, estimate and flown portion."""
    early = int(np.argmin(np.abs(maps.time - EARLY * maps.time[-1])))
    figure = new_figure(7.2, 9.2)
    plots = figure.subplots(3, 2, sharex=True, sharey=True)
    most = float(np.nanmax(maps.sd[early]))
    signal = Normalize(*signal_range(maps))
    for column, (k, words) in enumerate(((early, "(a) initial stage"), (len(maps.time) - 1, "(b) final stage"))):
        now = maps.time[k]
        top, middle, bottom = plots[:, column]
        sd = show(top, maps.sd[k], maps.extent, UNCERTAINTY, PowerNorm(UNCERTAINTY_POWER, 0.0, most))
        mean = show(middle, maps.mean[k], maps.extent, norm=signal)
        seen = samples[samples["time"] <= now + 1e-6]
        middle.scatter(seen["x"] / KM, seen["y"] / KM, s=9, color=INK, edgecolors=PAPER, linewidths=0.4)
        _portion(bottom, flown, now)
        stars(bottom, depots, 70)
        for axes in (top, middle, bottom):
            map_axes(axes, region)
            axes.label_outer()
        top.set_title(f"{words}\n{now:.0f} s, {len(seen)} samples")
    figure.colorbar(sd, ax=plots[0], label=f"uncertainty, posterior sd [{unit}]")
    figure.colorbar(mean, ax=plots[1], label=f"estimated field [{unit}]")
    empty = figure.colorbar(mean, ax=plots[2], label=" ")  # keeps the columns in line
    empty.ax.set_visible(False)
    legend_of(figure, [int(str(k)) for k in flown["uav"].unique()])
    caption = (
        "Top: what is not known, dark where the uncertainty is high (square-root scale). Middle: the estimated field "
        "with the samples it rests on (dots). Bottom: the portion of the paths that has been flown (coloured) of the "
        "whole (pale)."
    )
    return Drawn("stages", "Initial and final stage", caption, figure)


@rc_context(RC)
def draw_judged(maps: Maps, region: Region, unit: str) -> Drawn:
    """Return the last map against the truth: truth, estimate, error and uncertainty."""
    figure = new_figure(7.2, 6.2)
    plots = figure.subplots(2, 2, sharex=True, sharey=True)
    signal = signal_range(maps)
    error = maps.mean[-1] - maps.truth
    most = float(np.nanquantile(np.abs(error), 0.99)) or 1.0
    shown = (
        (plots[0, 0], maps.truth, "truth", f"[{unit}]", SIGNAL, signal),
        (plots[0, 1], maps.mean[-1], "estimate", f"[{unit}]", SIGNAL, signal),
        (plots[1, 0], error, "estimate − truth", f"error [{unit}]", "PuOr", (-most, most)),
        (plots[1, 1], maps.sd[-1], "uncertainty", f"posterior sd [{unit}]", UNCERTAINTY, (0.0, None)),
    )
    for axes, values, title, label, colours, ends in shown:
        image = show(axes, values, maps.extent, colours, Normalize(*ends))
        figure.colorbar(image, ax=axes, label=label, shrink=0.9)
        map_axes(axes, region)
        axes.label_outer()
        axes.set_title(title)
    caption = (
        "Error and uncertainty should look alike: where the map says it knows little, it may be wrong. Errors beyond "
        "the 99 % quantile have the colour of the ends."
    )
    return Drawn("judged", "The last map against the truth", caption, figure)


def signal_range(maps: Maps) -> tuple[float, float]:
    """Return the range of colours shared by the truth and its estimates."""
    return float(np.nanquantile(maps.truth, 0.002)), float(np.nanquantile(maps.truth, 0.998))


def _portion(axes: Axes, flown: pd.DataFrame, now: float) -> None:
    for k, track in flown.groupby("uav"):
        colour = colour_of(int(str(k)))
        axes.plot(track["x"] / KM, track["y"] / KM, color=colour, alpha=0.22, linewidth=1.0)
        done = track[track["time"] <= now]
        axes.plot(done["x"] / KM, done["y"] / KM, color=colour, linewidth=1.8)
        axes.scatter(done["x"].iloc[-1:] / KM, done["y"].iloc[-1:] / KM, s=22, color=colour, edgecolors=INK, zorder=5)
