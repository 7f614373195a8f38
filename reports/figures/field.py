"""The field that is measured, on the map: the paper's figure of radio signal strength, over contours of the ground."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable

from instances.arrays import Floats
from instances.environment.radio import RadioMap
from instances.environment.region import Region
from instances.environment.terrain import Terrain
from reports.figures.style import INK, PAPER, RC, new_figure
from reports.figures.svg import Drawn
from reports.figures.wind import KM, map_axes

Extent = tuple[float, float, float, float]
"""West, east, south and north border [km]."""
SIGNAL = "viridis"
"""Colours of the field and its estimates: equal steps look equal, also in grey."""
UNCERTAINTY = "Greys"
"""Colours of uncertainty: dark where little is known, as in the paper."""
UNCERTAINTY_POWER = 0.5
"""Uncertainty is drawn by its square root, so that what is left at the end is seen beside what there was."""


@rc_context(RC)
def draw_field(field: RadioMap, region: Region, terrain: Terrain | None, source: tuple[float, float] | None) -> Drawn:
    """Return the field over `region`, and beside it the ground it comes from where there is one."""
    figure = new_figure(7.2 if terrain else 4.6, 3.5)
    plots = figure.subplots(1, 2 if terrain else 1, squeeze=False)[0]
    cells = np.stack(np.meshgrid(field.x, field.y), axis=-1).reshape(-1, 2)
    inside = region.contains(cells).reshape(field.values.shape)
    image = show(plots[0], np.where(inside, field.values, np.nan), extent_of(field.x, field.y))
    figure.colorbar(image, ax=plots[0], label=f"field [{field.unit}]", shrink=0.85)
    plots[0].set_title("what is measured")
    if terrain is not None:
        image = show(plots[1], terrain.height, extent_of(*_nodes(terrain)), "bone")
        figure.colorbar(image, ax=plots[1], label="ground [m]", shrink=0.85)
        plots[1].set_title("the ground below")
    for axes in plots:
        map_axes(axes, region)
        if source is not None:
            axes.scatter(*(np.array(source) / KM), marker="^", s=70, color=INK, edgecolors=PAPER, zorder=5)
    if terrain is not None:  # it may reach beyond the region
        plots[1].set(ylabel="", xlim=plots[0].get_xlim(), ylim=plots[0].get_ylim())
        plots[1].tick_params(labelleft=False)
    where = " The triangle is the transmitter." if source is not None else ""
    ground = " Right: the ground; ridges cast the shadows." if terrain is not None else ""
    return Drawn("field", "The field", f"The field the UAVs measure, at flight altitude.{where}{ground}", figure)


def show(axes: Axes, values: Floats, extent: Extent, colours: str = SIGNAL, norm: Any = None) -> ScalarMappable:
    """Draw a raster (rows going north) on `axes`; norm : of the scale of colours, as `imshow` takes it."""
    style: dict[str, Any] = {"origin": "lower", "interpolation": "nearest", "zorder": 0}
    return axes.imshow(np.ma.masked_invalid(values), extent=extent, cmap=colours, norm=norm, **style)


def _nodes(terrain: Terrain) -> tuple[Floats, Floats]:
    y, x = (np.arange(count, dtype=np.float64) for count in terrain.height.shape)
    return terrain.origin[0] + terrain.spacing[0] * x, terrain.origin[1] + terrain.spacing[1] * y


def extent_of(x: Floats, y: Floats) -> Extent:
    """Return the borders of the cells whose centres are at x and y [m]."""
    dx, dy = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
    return float(x[0] - dx) / KM, float(x[-1] + dx) / KM, float(y[0] - dy) / KM, float(y[-1] + dy) / KM
