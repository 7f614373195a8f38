"""Mission curves: error, uncertainty, coverage and information against time, and the ways to fly compared."""

from __future__ import annotations

import pandas as pd
from matplotlib import rc_context

from reports.figures.style import COLOURS, DASHES, FAINT, INK, MARKERS, RC, new_figure
from reports.figures.svg import Drawn


@rc_context(RC)
def draw_progress(ticks: pd.DataFrame, unit: str) -> Drawn:
    """Return RMSE and posterior sd, NLPD, coverage and information against time. ticks : a row a tick."""
    figure = new_figure(7.2, 5.2)
    (error, density), (covered, information) = figure.subplots(2, 2, sharex=True)
    t = ticks["time"]
    error.plot(t, ticks["rmse"], color=COLOURS[1], label="RMSE of the map")
    error.plot(t, ticks["mean_sd"], color=COLOURS[0], linestyle=(0, (5, 1.6)), label="mean posterior sd")
    error.plot(t, ticks["max_sd"], color=FAINT, linestyle=(0, (1.2, 1.4)), label="greatest posterior sd")
    error.set(ylabel=f"[{unit}]", ylim=(0, None), title="error and uncertainty")
    error.legend(loc="upper right")
    density.plot(t, ticks["nlpd"], color=COLOURS[1])
    density.set(ylabel="NLPD [nats]", title="negative log predictive density")
    covered.plot(t, 100 * ticks["coverage"], color=COLOURS[2])
    covered.axhspan(90, 98, color=COLOURS[2], alpha=0.12, linewidth=0)
    covered.axhline(95, color=INK, linewidth=0.8, linestyle=(0, (3, 2)))
    covered.set(ylabel="covered [%]", xlabel="time [s]", ylim=(min(40.0, 100 * ticks["coverage"].min() - 3), 101))
    covered.set_title("truth inside the 95 % interval")
    information.plot(t, ticks["information"], color=COLOURS[4])
    information.set(ylabel="IG [nats]", xlabel="time [s]", ylim=(0, None), title="information gathered")
    caption = (
        "Judged at every map cell after each round of measurements. The 95 % interval is honest where it covers about "
        "95 % of the truth (band: 90 to 98 %). Steps are where the hyperparameters are fitted anew; information is "
        "½ log det(I + K/σ_n²) under the planning kernel, whatever is fitted, and only grows."
    )
    return Drawn("progress", "Error and uncertainty against time", caption, figure)


@rc_context(RC)
def draw_comparison(ticks: pd.DataFrame, unit: str) -> Drawn:
    """Return RMSE and NLPD against the length flown so far, a line a plan. ticks : name, flown [m], rmse, nlpd."""
    figure = new_figure(7.2, 3.3)
    error, density = figure.subplots(1, 2)
    for rank, (name, mine) in enumerate(ticks.groupby("name", sort=False)):  # the mission first
        km = mine["flown"] / 1e3
        colour, dash, marker = COLOURS[rank % len(COLOURS)], DASHES[rank % len(DASHES)], MARKERS[rank % len(MARKERS)]
        for axes, column in ((error, "rmse"), (density, "nlpd")):
            width = 2.4 if name == "mission" else 1.4
            axes.plot(km, mine[column], color=colour, linestyle=dash, linewidth=width, label=str(name))
            axes.scatter(km.iloc[-1:], mine[column].iloc[-1:], color=colour, marker=marker, s=26, zorder=4)
    error.set(ylabel=f"RMSE [{unit}]", xlabel="flown by all UAVs [km]", ylim=(0, None))
    density.set(ylabel="NLPD [nats]", xlabel="flown by all UAVs [km]")
    error.legend(loc="upper right")
    caption = (
        "Same field, UAVs, sensor and mapping; only the tours differ. Lower is better; the mark is where each plan "
        "ends. This is the mission's own field and noise, one draw: who wins is judged over all draws."
    )
    return Drawn("comparison", "Against what a person would fly otherwise", caption, figure)
