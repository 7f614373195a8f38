"""What a mission was told of its region before it planned: how much places count, and how little of them is known."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib import rc_context

from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.value_map import ValueMap
from reports.figures.field import UNCERTAINTY, extent_of, show
from reports.figures.placement import MAP, tasks
from reports.figures.style import RC, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import map_axes

TITLES = {"weights": "how much places count", "prior_sd": "prior uncertainty"}


@rc_context(RC)
def draw_value_maps(maps: Mapping[str, ValueMap | None], region: Region, points: Floats, unit: str) -> Drawn | None:
    """Return the maps there are, ``weights`` and ``prior_sd``, with the tasks (n, 2) [m]; None where there is none.

    unit : of the field.
    """
    found = {name: given for name, given in maps.items() if given is not None}
    if not found:
        return None
    figure = new_figure(7.2 if len(found) > 1 else 4.6, 3.5)
    plots = figure.subplots(1, len(found), squeeze=False)[0]
    labels = {"weights": "weight", "prior_sd": f"prior sd [{unit}]"}
    for axes, (name, given) in zip(plots, found.items(), strict=True):
        nodes = np.stack(np.meshgrid(given.x, given.y), axis=-1).reshape(-1, 2)
        inside = region.contains(nodes).reshape(given.values.shape)
        colours = MAP if name == "weights" else UNCERTAINTY
        image = show(axes, np.where(inside, given.values, np.nan), extent_of(given.x, given.y), colours)
        figure.colorbar(image, ax=axes, label=labels[name], shrink=0.85)
        map_axes(axes, region)
        tasks(axes, points)
        axes.set_title(TITLES[name])
    caption = "What was known before planning, dark where much counts or little is known; discs are the tasks."
    return Drawn("value-maps", "What was told of the region", caption, figure)
