"""The tours planned in the wind beside those of the calm twin, over the wind that both are flown in."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.axes import Axes

from instances.arrays import Floats
from instances.scenario import Scenario
from reports.figures.flight import colour_of, stars
from reports.figures.style import COLOURS, FAINT, PAPER, RC, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes, wind_arrows

ARROWHEADS = 6
"""Along each tour: they say which way round it is flown."""


@rc_context(RC)
def draw_calm_twin(scenario: Scenario, tasks: Floats, plans: list[tuple[str, pd.DataFrame]]) -> Drawn:
    """Return the figure of `plans`, each a title and its reference paths: columns uav, x, y [m]."""
    assert scenario.wind is not None
    figure = new_figure(9.6, 5.3)
    for axes, (title, paths) in zip(figure.subplots(1, 2, sharey=True), plans, strict=True):
        map_axes(axes, scenario.free)
        wind_arrows(axes, scenario.wind, scenario.free, colour=f"{FAINT}66")
        for k, path in paths.groupby("uav"):
            x, y = path["x"].to_numpy() / KM, path["y"].to_numpy() / KM
            colour = colour_of(int(str(k)))
            axes.plot(x, y, color=colour, linewidth=1.6, zorder=3)
            _heads(axes, np.stack([x, y], axis=1), colour)
        axes.scatter(*(tasks.T / KM), s=14, color=COLOURS[0], edgecolors=PAPER, linewidths=0.5, zorder=5)
        stars(axes, scenario.depots)
        axes.set_title(title)
        axes.label_outer()
    caption = (
        "The same tasks and UAVs. Left: planned in the wind. Right: planned as if the air were calm, and flown in the "
        "wind. Arrowheads on the tours say which way round they are flown."
    )
    return Drawn("calm", "Planned in the wind, and for calm air", caption, figure)


def _heads(axes: Axes, path: Floats, colour: str) -> None:
    """Draw heads along a path (k, 2) [km], evenly spaced."""
    passed = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    behind = (np.arange(ARROWHEADS) + 0.5) / ARROWHEADS * passed[-1]
    tails, tips = (np.stack([np.interp(at, passed, c) for c in path.T], axis=1) for at in (behind, behind + 0.01))
    for tail, tip in zip(tails, tips, strict=True):
        towards = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 13}
        axes.annotate("", tip, tail, arrowprops=towards, zorder=4).set_in_layout(False)
