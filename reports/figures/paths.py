"""Moving costs: the paper's figure of paths from one start, the methods compared, and the paper's scaling claim."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.ticker import LogLocator

from instances.paths import Paths
from instances.scenario import Scenario
from reports.figures.style import COLOURS, DASHES, INK, MARKERS, PAPER, RC, new_figure, plain
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes, wind_arrows

LEAST = 1e-7
"""Excess under which paths count as equal in a figure."""


def draw_paths(scenario: Scenario, paths: Paths) -> Drawn:
    """Return the paper's figure: wind arrows, region, tasks, and the paths from the first depot and back to it.

    paths : between all nodes of `scenario`, or only its first ones; where these hold no depot, from the first task.
    """
    points, n = scenario.points[: paths.n_nodes], scenario.n_tasks
    node = n if n < len(points) else 0
    with rc_context(RC):
        figure = new_figure(7.2, 3.9)
        for axes, outward in zip(figure.subplots(1, 2, sharey=True), (True, False), strict=True):
            map_axes(axes, scenario.free)
            if scenario.wind is not None:
                wind_arrows(axes, scenario.wind, scenario.free)
            for other in range(len(points)):
                if other != node:
                    line = paths.between(node, other) if outward else paths.between(other, node)
                    axes.plot(*(line.T / KM), color=COLOURS[0] if outward else COLOURS[1], linewidth=0.9, zorder=3)
            axes.scatter(*(points[:n].T / KM), s=12, color=INK, zorder=4, linewidths=0)
            axes.scatter(*(points[n:].T / KM), s=34, marker="s", color=INK, edgecolors=PAPER, linewidths=0.9, zorder=5)
            axes.scatter(*(points[node] / KM), s=170, marker="*", color=COLOURS[3], edgecolors=PAPER, zorder=6)
            axes.set_title(
                f"{'from' if outward else 'back to'} node {node}, {scenario.cost.speed_name} {scenario.speed:g} m/s"
            )
            if not outward:
                axes.set_ylabel("")
    caption = (
        "The cheapest paths from one node (star) to every task (dots) and depot (squares), and back, among the "
        "no-fly zones (grey) in the wind (arrows). The two differ: with the wind a detour pays, against it the "
        "straight way."
    )
    return Drawn("paths", "Paths of the moving cost", caption, figure)


def draw_methods(methods: pd.DataFrame) -> Drawn:
    """Return excess over the best known path against CPU time, a row of `methods` a mark.

    Columns: method, options, cpu [s], mean, p95, largest (relative excess over all pairs).
    """
    with rc_context(RC):
        figure = new_figure(7.2, 3.4)
        axes = figure.subplots()
        for k, (name, rows) in enumerate(methods.groupby("method", sort=False)):
            colour = COLOURS[k % len(COLOURS)]
            for _, row in rows.iterrows():
                shown = np.maximum([row["mean"], row["p95"], row["largest"]], LEAST)
                axes.plot([row["cpu"]] * 2, shown[[0, 2]], color=colour, linewidth=1.0, alpha=0.7)
                axes.scatter(row["cpu"], shown[1], s=26, marker="_", color=colour)
                at = (row["cpu"], shown[0])
                axes.annotate(str(row["options"]), at, xytext=(5, -3), textcoords="offset points", fontsize=7.5)
            marks = np.maximum(rows["mean"], LEAST)
            axes.scatter(rows["cpu"], marks, s=34, marker=MARKERS[k], color=colour, label=str(name), zorder=3)
        axes.set(xscale="log", yscale="log", xlabel="CPU time, all pairs [s]", ylabel="excess over the best known path")
        low, high = axes.get_xlim()
        axes.set_xlim(low, high * 2.5)
        axes.set_ylim(bottom=LEAST / 2)
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        plain(axes.xaxis)
        plain(axes.yaxis)
        axes.legend(loc="upper right")
    caption = (
        "Relative excess of each method's paths over the best known ones, against the CPU time for all pairs: mean "
        f"(mark), 95 % quantile (dash) and largest (end of the line); below {LEAST:g} shown as {LEAST:g}. Lower left "
        "is better."
    )
    return Drawn("methods", "Methods compared", caption, figure)


def draw_claim(scaling: pd.DataFrame) -> Drawn:
    """Return the paper's scaling claim measured: CPU time against the number of starts, a column a way to plan.

    Columns: starts, and CPU times [s] of "one query a pair", "one tree a start", "shared edges", "refined".
    """
    with rc_context(RC):
        figure = new_figure(7.2, 3.4)
        axes = figure.subplots()
        for k, name in enumerate(c for c in scaling.columns if c != "starts"):
            look: dict[str, Any] = {"color": COLOURS[k], "marker": MARKERS[k], "linestyle": DASHES[k]}
            axes.plot(scaling["starts"], scaling[name], label=name, **look)
        axes.set(xscale="log", yscale="log", xlabel="number of starts n", ylabel="CPU time [s]")
        axes.set_xticks(scaling["starts"])
        plain(axes.xaxis)
        plain(axes.yaxis)
        axes.legend(loc="upper left")
    caption = (
        "FMT* with one query for each of the n(n − 1) pairs (extrapolated from one), with one tree for each start, and "
        "with trees that share what is known about edges; and refined, which polishes every pair."
    )
    return Drawn("claim", "n planning problems instead of n², and shared edges", caption, figure)
