"""The environment on the map: the wind's arrows, speed and vorticity, which alone bends paths."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from instances.arrays import Bools, Floats
from instances.environment.region import Region
from instances.environment.wind import WindField
from reports.figures.style import FAINT, INK, PAPER, RC, new_figure
from reports.figures.svg import Drawn

KM = 1e3
ARROWS = 15
"""Arrows along the longer side of the region."""
LONGEST = 0.95
"""Length of the longest arrow, in distances between arrows."""


@rc_context(RC)
def draw_wind(wind: WindField, region: Region) -> Drawn:
    """Return the figure of `wind` in `region`: arrows over its speed, and its vorticity beside them."""
    xs, ys, points, inside = _raster(region, 160)
    w = wind(points).reshape(len(ys), len(xs), 2)
    curl = np.gradient(w[..., 1], xs[1] - xs[0], axis=1) - np.gradient(w[..., 0], ys[1] - ys[0], axis=0)
    most = 1e3 * (float(np.abs(curl[inside]).max()) or 1e-9)
    figure = new_figure(7.2, 3.4)
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, values, label, colours, low, high in (
        (left, np.hypot(w[..., 0], w[..., 1]), "speed [m/s]", "cividis", None, None),
        (right, 1e3 * curl, "vorticity [10⁻³ 1/s]", "PuOr", -most, most),
    ):
        shown = np.ma.masked_where(~inside, values)
        image = axes.pcolormesh(xs / KM, ys / KM, shown, cmap=colours, vmin=low, vmax=high, rasterized=True)
        figure.colorbar(image, ax=axes, label=label, shrink=0.85)
        map_axes(axes, region)
    wind_arrows(left, wind, region, colour=PAPER, edge=INK)
    right.set_ylabel("")
    caption = (
        "Left: the wind's direction (arrows, as long as it is fast; the one above the map is the key) and speed. "
        "Right: its vorticity. Paths of least energy have curvature vorticity / ground speed, so a wind without "
        "vorticity bends none of them and changes none of their tours; to flight times any wind matters."
    )
    return Drawn("wind", "Wind", caption, figure)


def map_axes(axes: Axes, region: Region) -> None:
    """Give `axes` the outline of the region with its no-fly zones, in kilometres."""
    for ring in region.polygon.interiors:
        outline = Outline(np.asarray(ring.coords) / KM, closed=True)
        axes.add_patch(PathPatch(outline, facecolor=FAINT, alpha=0.55, edgecolor=INK, linewidth=0.8, zorder=2))
    axes.plot(*(np.asarray(region.polygon.exterior.coords).T / KM), color=INK, linewidth=0.8)
    axes.set(aspect="equal", xlabel="x, east [km]", ylabel="y, north [km]")
    axes.grid(visible=False)


def wind_arrows(axes: Axes, wind: WindField, region: Region, colour: str = FAINT, edge: str = "none") -> None:
    """Draw arrows of the wind inside the region, on a grid, and above the map one of known speed to read them by."""
    _, _, points, inside = _raster(region, ARROWS)
    p = points[inside.ravel()]
    w = wind(p)
    top = float(np.hypot(w[:, 0], w[:, 1]).max(initial=0.0))
    if top == 0:
        return
    x0, y0, x1, y1 = region.bounds
    scale = top / (max(x1 - x0, y1 - y0) / KM / ARROWS * LONGEST)
    arrows = axes.quiver(
        *(p.T / KM), *w.T, facecolor=colour, edgecolor=edge, linewidth=0.35, angles="xy", scale_units="xy", scale=scale,
        width=0.0055, headwidth=3.6, headlength=4.0, headaxislength=3.6, minshaft=1.3, pivot="mid", zorder=2,
    )  # fmt: skip
    speed = round_below(top)
    key = {"labelpos": "W", "coordinates": "axes", "color": INK, "labelsep": 0.05, "fontproperties": {"size": 7.5}}
    axes.set_title(axes.get_title() or " ")  # makes room for the key
    axes.quiverkey(arrows, 0.96, 1.035, speed, f"{speed:g} m/s", **key)


def round_below(value: float) -> float:
    """Return the greatest of …, 0.1, 0.2, 0.5, 1, 2, 5, 10, … that is not above `value` > 0."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (power, 2 * power, 5 * power) if step <= value * (1 + 1e-9)))


def _raster(region: Region, cells: int) -> tuple[Floats, Floats, Floats, Bools]:
    """Return cell centres along x and y, all of them (k, 2) [m], and which lie in the region (rows, columns)."""
    x0, y0, x1, y1 = region.bounds
    size = max(x1 - x0, y1 - y0) / cells
    nx, ny = max(2, round((x1 - x0) / size)), max(2, round((y1 - y0) / size))
    xs, ys = x0 + (np.arange(nx) + 0.5) * (x1 - x0) / nx, y0 + (np.arange(ny) + 0.5) * (y1 - y0) / ny
    points = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    return xs, ys, points, region.contains(points).reshape(ny, nx)
