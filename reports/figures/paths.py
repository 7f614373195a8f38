"""Moving costs: the paper's figure of paths from one start, the methods compared, and the paper's scaling claim."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context

from instances.paths import Paths
from instances.scenario import Scenario
from reports.figures.chart import Axis, Chart, Panel, Series
from reports.figures.static import drawn
from reports.figures.style import COLOURS, DASHES, INK, MARKERS, PAPER, RC, Style, new_figure
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
            axes.set_title(f"{'from' if outward else 'back to'} node {node}", loc="left")
            if not outward:
                axes.set_ylabel("")
    caption = (
        "The cheapest paths from one node (star) to every task (dots) and depot (squares), and back, among the "
        "no-fly zones (grey) in the wind (arrows). The two differ: with the wind a detour pays, against it the "
        f"straight way. Flown at {scenario.cost.speed_name} {scenario.speed:g} m/s."
    )
    return Drawn("paths", "Paths of the moving cost", caption, figure)


def draw_methods(methods: pd.DataFrame) -> Drawn:
    """Return excess over the best known path against CPU time, a row of `methods` a mark.

    Columns: method, options, cpu [s], mean, p95, largest (relative excess over all pairs).
    """
    series = []
    for k, (name, rows) in enumerate(methods.groupby("method", sort=False)):
        look = Style(COLOURS[k % len(COLOURS)], "-", MARKERS[k % len(MARKERS)])
        cpu, options = rows["cpu"].to_numpy(float), rows["options"].to_numpy(str)
        mean, p95, largest = (np.maximum(rows[column].to_numpy(float), LEAST) for column in ("mean", "p95", "largest"))
        told = {"options": options, "excess is": np.full(len(rows), "the mean")}
        ends = {"options": options, "excess is": np.full(len(rows), "the 95 % quantile")}
        series += [
            Series(str(name), cpu, mean, look, "points", mean, largest, "bars", told, size=6, labels="options"),
            Series(str(name), cpu, p95, look._replace(marker="_"), "points", more=ends, size=5),
        ]
    x, y = Axis("CPU time, all pairs", "s", "log"), Axis("excess over the best known path, relative", "", "log")
    caption = (
        "Relative excess of each method's paths over the best known ones, against the CPU time for all pairs: mean "
        f"(mark), 95 % quantile (dash) and largest (end of the line); below {LEAST:g} shown as {LEAST:g}. Lower left "
        "is better."
    )
    return drawn("methods", "Methods compared", caption, Chart([Panel(x, y, series)], height=3.3))


def draw_claim(scaling: pd.DataFrame) -> Drawn:
    """Return the paper's scaling claim measured: CPU time against the number of starts, a column a way to plan.

    Columns: starts, and CPU times [s] of "one query a pair", "one tree a start", "shared edges", "refined".
    """
    starts = scaling["starts"].to_numpy(float)
    series = [
        Series(str(name), starts, scaling[name], Style(COLOURS[k], DASHES[k], MARKERS[k]))
        for k, name in enumerate(column for column in scaling.columns if column != "starts")
    ]
    x = Axis("number of starts n", scale="log", ticks=starts.tolist())
    caption = (
        "FMT* with one query for each of the n(n − 1) pairs (extrapolated from one), with one tree for each start, and "
        "with trees that share what is known about edges; and refined, which polishes every pair."
    )
    chart = Chart([Panel(x, Axis("CPU time", "s", "log"), series)])
    return drawn("claim", "n planning problems instead of n², and shared edges", caption, chart)
