"""Paths flown by the clock: which is taken when, and the independent check of what legs in a changing wind cost.

Of the paths planned for several moments, whoever departs flies the one that is quickest from then on:

    T_ij(t) = min_p T(σ_ij^p, t)

Each is a fixed track and "first in, first out", so their least is. `check_clocked` integrates the wind by other means
than the planner (`wind_flights`): Gauss quadrature of the slowness, at times of passing that are guessed, integrated
and put in again until they stay (Picard's iteration). Costs claimed for leg and knot must not be below the least of
its paths, which is what makes endurance safe, nor above the greatest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from instances.arrays import Bools, Floats, Ints
from instances.environment.region import Region
from instances.environment.wind_changing import ChangingWind
from instances.moving_cost import segments
from instances.paths import Paths, shape_faults
from instances.travel import Travel
from instances.wind_flights import polyline_times
from instances.wind_triangle import ground_speeds

PIECE = 75.0
"""Greatest length [m] of the pieces on which the check integrates, by three Gauss points each."""
ROUNDS = 30
"""Of Picard's iteration, at most."""
TOLERANCE = 5e-4
"""Difference between a claimed and a recomputed time, over that time, that counts as agreement."""


def beside(paths: Paths, times: Floats, count: int) -> Bools:
    """Return which of the plans, these paths and their later ones, lie beside `times` (k,) [s], shape (plans, k).

    They are those for `count` moments in turn, from the last one on that is not after the time.
    """
    moments, of = np.unique([0.0, *paths.departures], return_inverse=True)
    since = of[:, None] - (np.searchsorted(moments, times, side="right") - 1)[None, :]
    return np.asarray((since >= 0) & (since < count))


def flown_from(paths: Paths, i: int, j: int, departure: float, wind: ChangingWind, airspeed: float) -> Floats:
    """Return the polyline (k, 2) [m] from node `i` to `j` that is quickest when begun at `departure` [s]."""
    lines = [plan.between(i, j) for plan in (paths, *paths.later)]
    offsets = np.concatenate([[0], np.cumsum([len(line) for line in lines])]).astype(np.int64)
    begun = np.full(len(lines), departure)
    times = polyline_times(np.concatenate(lines), offsets, np.arange(len(lines)), begun, wind, airspeed)
    return lines[int(np.argmin(times))]


def tour_by_clock(
    paths: Paths, stops: Sequence[int], wind: ChangingWind, airspeed: float, begins: float = 0.0
) -> tuple[list[Floats], float]:
    """Return the legs of a tour through the nodes `stops`, each begun when the one before ends, and its landing [s].

    begins : its take-off [s].
    """
    clock, legs = begins, []
    for i, j in pairwise(stops):
        line = flown_from(paths, i, j, clock, wind, airspeed)
        offsets = np.array([0, len(line)])
        clock += float(polyline_times(line, offsets, np.zeros(1, dtype=np.int64), np.array([clock]), wind, airspeed)[0])
        legs.append(line)
    return legs, clock


def at_their_times(paths: Paths, tours: Sequence[Sequence[int]], wind: ChangingWind, airspeed: float) -> Paths:
    """Return `paths` with those legs of `tours` (nodes, depots at the ends) that are flown when the tours come to them.

    All other legs are the paths planned for take-off. No leg is in two tours.
    """
    n = paths.n_nodes
    lines = [paths.between(i, j) for i in range(n) for j in range(n)]
    for stops in tours:
        legs, _ = tour_by_clock(paths, stops, wind, airspeed)
        for (i, j), leg in zip(pairwise(stops), legs, strict=True):
            lines[i * n + j] = leg
    return Paths.of(n, lines)


def check_clocked(
    paths: Paths,
    travel: Travel,
    g: int,
    coordinates: Floats,
    region: Region,
    wind: ChangingWind,
    airspeed: float,
    service: Floats,
    legs: Callable[[Floats], Floats],
) -> list[str]:
    """Return what is wrong with `paths` and the costs of class `g` in `travel`, a sentence each.

    Where they lead is checked of all; what they cost of each leg at one knot, in turn, so that all knots are. service
    (N,) [s] at the nodes, the first half of it before a leg begins; legs : what legs cost where paths cost so much.
    """
    faults: list[str] = []
    plans = (paths, *paths.later)
    for when, plan in zip((0.0, *paths.departures), plans, strict=True):
        found, fatal = shape_faults(plan, coordinates, region)
        faults += [f"Planned for {when:g} s: {fault}" for fault in found]
        if fatal:
            return faults
    n, knots = paths.n_nodes, len(travel.departures)
    i, j = np.nonzero(~np.eye(n, dtype=bool))
    knot = np.arange(len(i)) % knots
    begun = np.zeros(n * n)
    begun[i * n + j] = travel.departures[knot] + 0.5 * service[i]
    each = np.stack([legs(_times(plan, begun, wind, airspeed).reshape(n, n))[i, j] for plan in plans])
    claimed = travel.cost[g, knot, i, j]
    if np.isnan(each).any():
        q = int(np.argmax(np.isnan(each).any(axis=0)))
        return [*faults, f"The path from {i[q]} to {j[q]} meets a wind in which the airspeed cannot keep it."]
    low, high = each.min(axis=0) * (1 - TOLERANCE), each.max(axis=0) * (1 + TOLERANCE)
    wrong = (claimed < low - 1e-3) | (claimed > high + 1e-3)
    if wrong.any():
        q = int(np.argmax(wrong))
        faults.append(
            f"The path from {i[q]} to {j[q]} takes {each[:, q].min():.9g} s from {travel.departures[knot[q]]:g} s on, "
            f"not the {claimed[q]:.9g} s claimed ({int(wrong.sum())} of {len(i)} differ)."
        )
    return faults


def _times(paths: Paths, begun: Floats, wind: ChangingWind, airspeed: float) -> Floats:
    """Return the time [s] of each path begun at `begun` (n²,) [s], NaN where it cannot be flown."""
    a, b, owner = segments(paths.points, paths.offsets)
    number = np.maximum(1, np.ceil(np.hypot(*(b - a).T) / PIECE)).astype(np.int64)
    which = np.repeat(np.arange(len(a)), number)
    inner = np.arange(len(which)) - np.repeat(np.cumsum(number) - number, number)
    d = ((b - a) / number[:, None])[which]
    start, of = a[which] + inner[:, None] * d, owner[which]
    far = np.hypot(*d.T)
    tangents = np.divide(d, far[:, None], out=np.zeros_like(d), where=far[:, None] > 0)
    took = far / airspeed
    for _ in range(ROUNDS):
        entered = begun[of] + _before(took, of)
        new = np.zeros(len(took))
        for node, weight in ((-(0.6**0.5), 5 / 18), (0.0, 8 / 18), (0.6**0.5, 5 / 18)):
            share = 0.5 + 0.5 * node
            speeds = ground_speeds(wind.velocities(start + share * d, entered + share * took), tangents, airspeed)
            new += weight * far / np.where(speeds > 0, speeds, np.nan)
        settled = np.abs(new - took).max(initial=0.0) <= 1e-6 or np.isnan(new).any()
        took = new
        if settled:
            break
    return np.bincount(of, took, minlength=len(begun)).astype(np.float64)


def _before(took: Floats, of: Ints) -> Floats:
    """Return what the pieces before each of the same path, (k,), took [s]."""
    total = np.concatenate([[0.0], np.cumsum(took)])
    first = np.searchsorted(of, of, side="left")
    return total[:-1] - total[first]
