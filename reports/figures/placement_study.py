"""How many tasks: the paper's Fig. 1 (tours that over- and underfit) above the numbers that decide."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes

from instances.arrays import Floats
from instances.environment.region import Region
from reports.figures.placement import tasks, uncertainty
from reports.figures.style import COLOURS, FAINT, INK, RC, new_figure, plain
from reports.figures.svg import Drawn
from reports.figures.wind import KM


class Tour(NamedTuple):
    """One tour to draw: tasks (n, 2) [m], order, posterior sd after it on a grid (x, y, sd (q, p)), words."""

    points: Floats
    order: Sequence[int]
    sd: tuple[Floats, Floats, Floats]
    words: str


class Curves(NamedTuple):
    """What is drawn against n: MI1, MI2, a lawnmower's [nats], km of tour, share uncovered, σ_T; NaN where none."""

    n: Floats
    mi1: Floats
    mi2: Floats
    lawnmower: Floats
    km: Floats
    uncovered: Floats
    planning_noise: Floats


@rc_context(RC)
def draw_study(region: Region, tours: Sequence[Tour], curves: Curves, recommended: int, prior_sd: float) -> Drawn:
    """Return the tours of the paper's Fig. 1 above four curves against n, the recommended n marked."""
    figure = new_figure(7.2, 6.4)
    halves = figure.subfigures(2, 1, height_ratios=[1.05, 1.5], squeeze=False)
    upper, lower = halves[0, 0], halves[1, 0]
    panels = upper.subplots(1, len(tours), sharey=True, squeeze=False)[0]
    for axes, tour in zip(panels, tours, strict=True):
        shades = uncertainty(axes, region, tour.sd, prior_sd)
        closed = tour.points[[*tour.order, tour.order[0]]] / KM
        axes.plot(*closed.T, color=COLOURS[1], linewidth=1.0, zorder=4)
        tasks(axes, tour.points)
        axes.set_title(tour.words, fontsize=8.5)
        if axes is not panels[0]:
            axes.set_ylabel("")
    bar = upper.colorbar(shades, ax=list(panels), location="right", aspect=22, pad=0.01)
    bar.set_label("posterior sd")
    _curves(lower.subplots(2, 2, sharex=True), curves, recommended)
    caption = (
        "Above: the closed tour through few, the recommended number of, and many tasks, over the posterior standard "
        "deviation after sensing along it; too few leave dark gaps, too many fly over what is known. Below, against "
        "the number of tasks (dashed: the recommended one): information at the tasks alone (MI1), along the tour "
        "(MI2), and along a lawnmower track of the same length; share of the region left over the sd limit; "
        "information gained by another kilometre of tour; and the planning noise σ_T that would make MI1 equal MI2."
    )
    return Drawn("how-many-tasks", "How many tasks", caption, figure)


def _curves(panels: Any, curves: Curves, recommended: int) -> None:
    (information, uncovered), (marginal, noise) = panels
    information.plot(curves.n, curves.mi2, color=COLOURS[1], marker="s", markersize=3, label="MI2, along the tour")
    mown = {"color": FAINT, "linestyle": (0, (1.2, 1.4)), "label": "a lawnmower of the same length"}
    information.plot(curves.n, curves.lawnmower, **mown)
    information.plot(curves.n, curves.mi1, color=COLOURS[0], marker="o", markersize=3, label="MI1, at the tasks")
    information.set_ylabel("information [nats]")
    information.set_ylim(bottom=0, top=1.42 * float(np.nanmax([curves.mi1, curves.mi2, curves.lawnmower])))
    information.legend(loc="upper left", fontsize=7, borderpad=0.1)
    uncovered.plot(curves.n, 100 * curves.uncovered, color=COLOURS[2], marker="^", markersize=3)
    uncovered.set_ylabel("over the sd limit [%]")
    _marginal(marginal, curves)
    noise.plot(curves.n, curves.planning_noise, color=COLOURS[3], marker="D", markersize=3)
    noise.set_ylabel("planning noise σ_T")
    noise.set_yscale("log")
    plain(noise.yaxis)
    for axes in panels.flat:
        axes.axvline(recommended, color=FAINT, linewidth=1.0, linestyle=(0, (5, 3)))
        axes.set_xlim(left=0)
    for axes in panels[1]:
        axes.set_xlabel("number of tasks, n")
    information.annotate(
        f"n = {recommended}", (recommended, 0.0), xycoords=("data", "axes fraction"), xytext=(-3, 4), ha="right",
        textcoords="offset points", fontsize=8, color=INK,
    )  # fmt: skip


def _marginal(axes: Axes, curves: Curves) -> None:
    """Draw dMI2/dkm, from the trials at each place's two sides so that one odd tour does not hide the trend."""
    axes.set_ylabel("dMI2 / dkm [nats/km]")
    if len(curves.n) < 3:
        return
    reach = max(1, len(curves.n) // 8)
    low = np.maximum(np.arange(len(curves.n)) - reach, 0)
    high = np.minimum(np.arange(len(curves.n)) + reach, len(curves.n) - 1)
    more = curves.km[high] - curves.km[low]
    slope = np.divide(curves.mi2[high] - curves.mi2[low], more, out=np.full(len(more), np.nan), where=more > 0)
    axes.plot(curves.n, slope, color=COLOURS[4], marker="v", markersize=3)
    axes.set_ylim(bottom=0)
