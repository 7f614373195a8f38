"""Mission curves: error, uncertainty, coverage and information against time, and the ways to fly compared."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.figures.chart import QUIET, REFERENCE, Axis, Chart, Panel, Rule, Series
from reports.figures.static import drawn
from reports.figures.style import COLOURS, DASHES, FAINT, MARKERS, Style
from reports.figures.svg import Drawn


def draw_progress(ticks: pd.DataFrame, unit: str) -> Drawn:
    """Return RMSE and posterior sd, NLPD, coverage and information against time. ticks : a row a tick."""
    t, percent = ticks["time"].to_numpy(float), 100 * ticks["coverage"].to_numpy(float)

    def line(name: str, column: str, look: Style) -> Series:
        return Series(name, t, ticks[column], look, size=0)

    error = [
        line("RMSE of the map", "rmse", Style(COLOURS[1], "-", "o")),
        line("mean posterior sd", "mean_sd", Style(COLOURS[0], DASHES[1], "o")),
        line("greatest posterior sd", "max_sd", Style(FAINT, DASHES[2], "o")),
    ]
    density = [line("NLPD", "nlpd", Style(COLOURS[4], DASHES[3], "o"))]
    honest = np.full(2, 95.0)
    covered = [
        Series("", t[[0, -1]], honest, QUIET, low=honest - 5, high=honest + 3, size=0, width=0),
        Series("truth inside the 95 % interval", t, percent, Style(COLOURS[2], "-", "o"), size=0),
    ]
    gathered = [line("information gathered", "information", Style(COLOURS[3], DASHES[1], "o"))]
    x = Axis("time", "s")
    least = min(40.0, float(percent.min()) - 3)
    panels = [
        Panel(x, Axis("error, uncertainty", unit, span=(0.0, None)), error, "error and uncertainty"),
        Panel(x, Axis("NLPD", "nats"), density, "negative log predictive density"),
        Panel(x, Axis("covered", "%", span=(least, 101.0)), covered, "truth inside the 95 % interval",
              [Rule("y", 95.0, REFERENCE)]),
        Panel(x, Axis("IG", "nats", span=(0.0, None)), gathered, "information gathered"),
    ]  # fmt: skip
    caption = (
        "Judged at every map cell after each round of measurements. The 95 % interval is honest where it covers about "
        "95 % of the truth (band: 90 to 98 %). Steps are where the hyperparameters are fitted anew; information is "
        "½ log det(I + K/σ_n²) under the planning kernel, whatever is fitted, and only grows."
    )
    return drawn("progress", "Error and uncertainty against time", caption, Chart(panels, 2, 2.3))


def look_of(rank: int) -> Style:
    """Return how the plan of this rank is drawn; the mission has rank 0."""
    return Style(COLOURS[rank % len(COLOURS)], DASHES[rank % len(DASHES)], MARKERS[rank % len(MARKERS)])


def draw_comparison(ticks: pd.DataFrame, unit: str) -> Drawn:
    """Return RMSE and NLPD against the length flown so far, a line a plan. ticks : name, flown [m], rmse, nlpd."""
    error, density = list[Series](), list[Series]()
    for rank, (name, mine) in enumerate(ticks.groupby("name", sort=False)):  # the mission first
        km, look, width = mine["flown"].to_numpy(float) / 1e3, look_of(rank), 2.4 if rank == 0 else 1.4
        for series, column in ((error, "rmse"), (density, "nlpd")):
            of = mine[column].to_numpy(float)
            series.append(Series(str(name), km, of, look, width=width, size=5, marked="end"))
    x = Axis("flown by all UAVs", "km")
    panels = [
        Panel(x, Axis("RMSE", unit, span=(0.0, None)), error),
        Panel(x, Axis("NLPD", "nats"), density),
    ]
    caption = (
        "Same field, UAVs, sensor and mapping; only the tours differ. Lower is better; the mark is where each plan "
        "ends. This is the mission's own field and noise, one draw: who wins is judged over all draws."
    )
    return drawn("comparison", "Against what a person would fly otherwise", caption, Chart(panels, 2, 2.8))
