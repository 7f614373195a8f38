"""Paths of the moving cost on the map: the paper's figure of a wind field, the tasks, and paths from one start."""

from __future__ import annotations

from pathlib import Path

from instances.paths import Paths
from instances.scenario import Scenario
from reports.figures.style import COLOURS, INK, PAPER, new_figure
from reports.figures.svg import Drawn, save_figure
from reports.figures.wind import KM, map_axes, wind_arrows


def save_paths(scenario: Scenario, paths: Paths, path: Path | str, start: int | None = None) -> None:
    """Draw `paths` from node `start` (the first depot where left out) and write the picture to `path`."""
    save_figure(draw_paths(scenario, paths, start).figure, path)


def draw_paths(scenario: Scenario, paths: Paths, start: int | None = None) -> Drawn:
    """Return the paper's figure: wind arrows, region, tasks, and the paths from one node and back to it."""
    node = paths.n_nodes - scenario.n_depots if start is None else start
    points = scenario.points
    n = len(points) - scenario.n_depots
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
        axes.set_title("outward" if outward else "back")
        if not outward:
            axes.set_ylabel("")
    figure.suptitle(f"{scenario.name}: paths from node {node} and back to it, airspeed {scenario.airspeed:g} m/s")
    return Drawn(
        "paths",
        "Paths of the moving cost",
        "The cheapest paths from one node (star) to every task (dots) and depot (squares), and back, among the no-fly "
        "zones (grey) in the wind (arrows). The two differ: with the wind a detour pays, against it the straight way.",
        figure,
    )
