"""The growing map: a slider over the maps that were kept, with axes, tracks and samples up to the moment."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib import colormaps
from matplotlib.image import imsave
from matplotlib.ticker import MaxNLocator

from instances.arrays import Floats
from instances.environment.wind_changing import ChangingWind
from reports.figures.field import SIGNAL, UNCERTAINTY, UNCERTAINTY_POWER
from reports.figures.flight import colour_of
from reports.figures.map import signal_range
from reports.figures.wind import KM
from reports.figures.wind_frames import arrows_at
from reports.pages.page import fragment
from reports.products import Products


def film(products: Products, flown: pd.DataFrame, samples: pd.DataFrame, ticks: pd.DataFrame) -> dict[str, Any]:
    """Return the growing map for the slider: a picture of estimate and uncertainty a kept tick, and the tracks."""
    maps = products.maps
    low, high = signal_range(maps)
    most = float(np.nanmax(maps.sd[0]))
    blowing = _blowing(products)
    judged = ticks.set_index("time")
    tracks = [
        {
            "uav": int(str(k)),
            "colour": colour_of(int(str(k))),
            "points": np.column_stack([track["x"] / 1e3, track["y"] / 1e3, track["time"]])[::6].round(3).tolist(),
        }
        for k, track in flown.groupby("uav")
    ]
    frames = [
        {
            "time": float(t),
            "mean": _picture(maps.mean[k], low, high, SIGNAL),
            "sd": _picture(maps.sd[k] ** UNCERTAINTY_POWER, 0.0, most**UNCERTAINTY_POWER, UNCERTAINTY),
            "rmse": round(float(judged.loc[t, "rmse"]), 3),
            "samples": int(judged.loc[t, "samples"]),
            **({"wind": blowing[k]} if blowing else {}),
        }
        for k, t in enumerate(maps.time)
    ]
    west, east, south, north = maps.extent
    box = {"west": west, "south": south, "width": east - west, "height": north - south}
    dots = samples[["x", "y", "time"]].to_numpy() / np.array([1e3, 1e3, 1.0])
    return {"frames": frames, "tracks": tracks, "samples": dots.round(3).tolist(), "unit": products.unit, "box": box}


def _blowing(products: Products) -> list[str]:
    """Return the arrows of a wind that changes at each kept map, as a path in kilometres; none where it stays."""
    scenario = products.scenario
    if not isinstance(scenario.wind, ChangingWind):
        return []
    places, w, scale = arrows_at(scenario, scenario.wind, products.maps.time)
    return [_arrows(places / KM, now * scale / KM) for now in w]


def _arrows(places: Floats, d: Floats) -> str:
    """Return arrows `d` (k, 2) about the middles `places` (k, 2) as the path of an SVG."""
    tail, head = places - d / 2, places + d / 2
    barbs = [head - 0.3 * (d @ np.array([[1.0, s], [-s, 1.0]])) for s in (0.5, -0.5)]
    ends = np.column_stack([tail, head, barbs[0], head, barbs[1]]).round(2).tolist()
    return "".join(
        f"M{a:g},{b:g}L{c:g},{e:g}M{f:g},{g:g}L{h:g},{i:g}L{j:g},{k:g}" for a, b, c, e, f, g, h, i, j, k in ends
    )


def player(products: Products, data: dict[str, Any]) -> Markup:
    """Return the slider and its two maps, as they are before the script runs: the last ones."""
    low, high = signal_range(products.maps)
    most, ramp = float(np.nanmax(products.maps.sd[0])), np.linspace(0, 1, 128)[None, :]
    last = data["frames"][-1]
    halfway = most * 0.5 ** (1 / UNCERTAINTY_POWER)
    panels = [
        {"key": key, "words": words, "bar": _picture(ramp, 0.0, 1.0, colours), "ends": _ends(ends), "last": last[key]}
        for key, words, colours, ends in (
            ("mean", "Estimated field", SIGNAL, (low, (low + high) / 2, high)),
            ("sd", "Uncertainty, square-root scale", UNCERTAINTY, (0.0, halfway, most)),
        )
    ]
    uavs = [(track["uav"], track["colour"]) for track in data["tracks"]]
    said = {
        "blowing": last.get("wind", ""),
        "box": data["box"],
        "unit": data["unit"],
        "uavs": uavs,
        "unit_star": _star(4.5),
    }
    depots = (products.scenario.depots / KM).round(4).tolist()
    return fragment("film.html.j2", panels=panels, frame=_frame(data["box"], products), depots=depots, **said)


def _frame(box: dict[str, float], products: Products) -> dict[str, Any]:
    """Return what surrounds a map: its view with room for axes, ticks [km], the region's outline, sizes."""
    size = max(box["width"], box["height"])
    letter, line = 0.037 * size, size / 350
    left, below, above = 3.6 * letter, 3.0 * letter, 0.7 * letter
    view = (box["west"] - left, -box["south"] - box["height"] - above,
            box["width"] + left + above, box["height"] + above + below)  # fmt: skip
    rings = [np.asarray(ring.coords)[:, :2] / KM for ring in _rings(products)]
    outline = "".join("M" + "L".join(f"{x:.4f},{y:.4f}" for x, y in ring) + "Z" for ring in rings)
    ticks = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10])
    xs, ys = (
        [float(t) for t in ticks.tick_values(low, low + length) if low - 1e-9 <= t <= low + length + 1e-9]
        for low, length in ((box["west"], box["width"]), (box["south"], box["height"]))
    )
    sizes = {"letter": round(letter, 4), "line": round(line, 4), "tick": round(0.4 * letter, 4)}
    said = " ".join(f"{value:.4f}" for value in view)
    return {"view": said, "outline": outline, "xs": xs, "ys": ys, "star": _star(0.026 * size), **sizes}


def _rings(products: Products) -> list[Any]:
    """Return the rings of the region without its no-fly zones."""
    polygon = products.scenario.free.polygon
    return [polygon.exterior, *polygon.interiors]


def _star(reach: float) -> str:
    """Return the path of a five-pointed star."""
    turns = np.arange(10) * np.pi / 5
    radius = np.where(np.arange(10) % 2 == 0, reach, 0.42 * reach)
    points = np.column_stack([radius * np.sin(turns), -radius * np.cos(turns)])
    return "M" + "L".join(f"{x:.4f},{y:.4f}" for x, y in points) + "Z"


def _ends(values: Iterable[float]) -> list[str]:
    """Return the numbers below a bar of colours, in three figures."""
    return [f"{value:.3g}".replace("-", "−") for value in values]


def _picture(values: Floats, low: float, high: float, colours: str) -> str:
    """Return a raster as a PNG data URI, a pixel a cell, north up; cells outside the region are clear."""
    shades = colormaps[colours](np.clip((values - low) / (high - low or 1.0), 0, 1), bytes=True)
    shades[~np.isfinite(values)] = 0
    buffer = io.BytesIO()
    imsave(buffer, np.ascontiguousarray(shades[::-1]), format="png")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
