"""Routes on the map: every UAV's tour from its depot, over the region and the wind, beside bars of the tours' costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.ticker import MaxNLocator

from instances import InputError, Instance, Routes, tour_costs
from instances.arrays import Floats
from instances.environment.region import Region, single_polygon
from instances.environment.wind import WindField
from instances.environment.wind_table import wind_from_toml
from instances.errors import one_line
from instances.families import FAMILIES
from instances.fleet import Return
from instances.paths import Paths
from instances.scenario import Scenario
from reports.figures.style import COLOURS, DASHES, FAINT, INK, PAPER, RC
from reports.numbers import counted

ARROWS_BELOW = 400
"""Legs get an arrow each where there are fewer tasks than this; more would hide the tours."""


def draw_routes(
    instance: Instance, routes: Routes, paths: Paths | None = None, scenario: Scenario | None = None
) -> Figure:
    """Return the tours on the map and, beside it, bars of their costs C_k [s].

    Below the tours lie the region and the wind of `scenario`, or where it is not given those that the instance states.
    paths : behind the costs of `instance`, drawn as legs; straight lines where not given. Where the instance has no
    coordinates only the bars are drawn.
    """
    with rc_context(RC):
        if instance.coordinates is None:
            figure = Figure(figsize=(7.2, 1.2 + 0.24 * min(instance.n_depots, 40)), layout="constrained")
            _bars(figure.add_subplot(), instance, routes)
        else:
            figure = Figure(figsize=(7.2, 4.6), layout="constrained")
            plan, bars = figure.subplots(1, 2, width_ratios=[2.6, 1.0])
            around = (scenario.free, scenario.wind) if scenario is not None else surroundings(instance)
            closed = scenario is None or scenario.fleet.returns is Return.OWN
            _map(plan, instance, [_legs(instance, k, route, paths, closed) for k, route in enumerate(routes)], *around)
            _bars(bars, instance, routes)
        figure.suptitle(_title(instance, routes), fontsize=10, color=INK)
    return figure


def surroundings(instance: Instance) -> tuple[Region | None, WindField | None]:
    """Return the region (None: open country) and wind (None: calm or not stated) that `instance` was made in.

    A family states them in the provenance: under ``surroundings`` or, over open country and in old files, ``metric``;
    where it does not, the family makes its scenario again, which counts if its nodes are those of `instance`.
    """
    stated = instance.provenance.get("surroundings", instance.provenance.get("metric"))
    try:
        if not isinstance(stated, Mapping):
            return _made_again(instance)
        walls, wind = stated.get("region"), stated.get("wind")
        region = Region(single_polygon({"type": "Polygon", "coordinates": walls})) if walls else None
        return region, wind_from_toml(wind) if wind else None
    except InputError:
        return None, None


def _made_again(instance: Instance) -> tuple[Region | None, WindField | None]:
    """Return region and wind of the scenario that a built-in family made `instance` of."""
    name, given, seed = (instance.provenance.get(key) for key in ("family", "parameters", "seed"))
    if instance.coordinates is None or not (isinstance(given, Mapping) and isinstance(seed, int) and seed >= 0):
        return None, None
    if not isinstance(name, str) or name not in FAMILIES.built_in:
        return None, None
    scenario = FAMILIES.load(name).scenario(instance.n_tasks, instance.n_depots, seed, given)
    same = np.array_equal(scenario.points, instance.coordinates)
    return (scenario.free, scenario.wind) if same else (None, None)


def _title(instance: Instance, routes: Routes) -> str:
    flying = sum(1 for route in routes if len(route))
    longest = tour_costs(instance, routes).max()
    uavs = f"{flying} of {instance.n_depots} UAVs fly"
    return f"{one_line(instance.name, 80)}: {instance.n_tasks} tasks, {uavs}, longest tour {longest:,.6g} s"


def _map(
    axes: Axes, instance: Instance, tours: list[list[Floats]], region: Region | None, wind: WindField | None
) -> None:
    """Draw region, wind, the legs of every UAV's tour, tasks and depots."""
    coordinates = _places(instance)
    scale, unit = (1e3, "km") if np.ptp(coordinates, axis=0).max() >= 5e3 else (1.0, "m")
    xy = coordinates / scale
    if region is not None:
        rings = Outline.make_compound_path(*(Outline(ring / scale, closed=True) for ring in region.rings))
        axes.add_patch(PathPatch(rings, facecolor=to_rgba(FAINT, 0.14), edgecolor=INK, linewidth=0.8))
    corners = np.vstack([coordinates, *(region.rings if region is not None else [])])
    if wind is not None:
        _wind_arrows(axes, wind, region, corners, scale)
    for k, legs in enumerate(tours):
        if legs:
            _tour(axes, [leg / scale for leg in legs], k, instance.n_tasks < ARROWS_BELOW)
    size = float(np.clip(30 - 5 * np.log(instance.n_tasks), 2, 20))
    axes.scatter(xy[: instance.n_tasks, 0], xy[: instance.n_tasks, 1], s=size, color=INK, zorder=4, linewidths=0)
    for k, depot in enumerate(xy[instance.n_tasks :]):
        colour = COLOURS[k % len(COLOURS)]
        axes.scatter(depot[0], depot[1], s=58, marker="s", color=colour, edgecolors=PAPER, linewidths=1.2, zorder=5)
    axes.set(aspect="equal", xlabel=f"x, east [{unit}]", ylabel=f"y, north [{unit}]")
    axes.grid(visible=False)
    axes.margins(0.04)
    for side in (axes.xaxis, axes.yaxis):
        side.set_major_locator(MaxNLocator(6))


def _places(instance: Instance) -> Floats:
    return instance.coordinates if instance.coordinates is not None else np.zeros((instance.n_nodes, 2))


def _legs(instance: Instance, k: int, route: Sequence[int], paths: Paths | None, closed: bool) -> list[Floats]:
    """Return the polylines that UAV `k` flies from stop to stop: its class's paths, or straight lines without paths.

    closed : whether tours end where they began; of others the last leg is left out.
    """
    depot = instance.n_tasks + k
    steps = list(pairwise([depot, *route, *([depot] if closed else [])])) if len(route) else []
    if paths is None:
        return [_places(instance)[[i, j]] for i, j in steps]
    alike = len(paths.others) != instance.classes.max()  # classes of equal costs are one, whatever their paths
    own = paths if alike else paths.of_class(int(instance.classes[k]))
    return [own.between(i, j) for i, j in steps]


def wind_inside(wind: WindField, region: Region | None, corners: Floats) -> tuple[Floats, Floats]:
    """Return points (k, 2) [m] of a coarse grid over `corners`, those inside `region`, and the wind there [m/s]."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    cells = np.maximum(2, np.round(11 * span / span.max()).astype(int))
    grids = [lo + (np.arange(c) + 0.5) * s / c for lo, c, s in zip(low, cells, span, strict=True)]
    points = np.stack(np.meshgrid(*grids), axis=-1).reshape(-1, 2)
    if region is not None:
        points = points[region.contains(points)]
    return points, np.asarray(wind(points))


def _wind_arrows(axes: Axes, wind: WindField, region: Region | None, corners: Floats, scale: float) -> None:
    """Draw the wind on a coarse grid and say how strong the strongest arrow is [m/s]."""
    points, velocity = wind_inside(wind, region, corners)
    strongest = float(np.hypot(*velocity.T).max(initial=0.0))
    if strongest == 0:
        return
    axes.quiver(
        *(points / scale).T, *velocity.T, color=FAINT, pivot="mid", width=0.0035, headwidth=4.5,
        scale=strongest * 16, zorder=1,
    )  # fmt: skip
    axes.set_title(f"grey arrows: wind, up to {strongest:.2g} m/s", loc="left", fontsize=8)


def _tour(axes: Axes, legs: list[Floats], k: int, arrows: bool) -> None:
    """Draw the polylines `legs` of UAV k, with an arrow halfway along the longest straight part of each."""
    colour = COLOURS[k % len(COLOURS)]
    path = np.concatenate(legs)
    axes.plot(*path.T, color=colour, linestyle=DASHES[k // len(COLOURS) % len(DASHES)], linewidth=1.5, zorder=3)
    parts = [_longest(leg) for leg in legs if np.ptp(leg, axis=0).any()]
    if arrows and parts:
        middles = np.array([0.45 * a + 0.55 * b for a, b in parts])
        steps = np.array([(b - a) / np.hypot(*(b - a)) for a, b in parts])
        axes.quiver(
            *middles.T, *steps.T, color=colour, angles="xy", pivot="mid", scale=60, width=0.004, headwidth=6,
            headlength=6, headaxislength=5, minlength=0, zorder=3,
        )  # fmt: skip


def _longest(leg: Floats) -> tuple[Floats, Floats]:
    i = int(np.hypot(*np.diff(leg, axis=0).T).argmax())
    return leg[i], leg[i + 1]


def _bars(axes: Axes, instance: Instance, routes: Routes) -> None:
    costs = tour_costs(instance, routes)
    uavs = np.arange(len(costs))
    axes.barh(uavs, costs, color=[COLOURS[k % len(COLOURS)] for k in uavs], height=0.72)
    axes.axvline(costs.max(), color=INK, linewidth=0.9, linestyle=(0, (3, 2)))
    if len(costs) <= 24:
        top = costs.max() or 1.0
        for k, route in enumerate(routes):
            words = counted(len(route), "task") if len(route) else "stays home"
            axes.text(1.05 * top, k, words, va="center", fontsize=7.5)
        axes.set_xlim(0, 1.5 * top)  # room for the words
        axes.set_yticks(uavs, [str(k) for k in uavs])
    axes.invert_yaxis()
    axes.set_xlabel("tour cost $C_k$ [s]", parse_math=True)
    axes.set_ylabel("UAV k")
    axes.grid(axis="y", visible=False)
    axes.xaxis.set_major_locator(MaxNLocator(4))
