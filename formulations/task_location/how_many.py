"""How many tasks? The paper's over- and under-fitting study (§Meaning of Assigning Task Locations).

For each n: place n tasks, join them by one closed tour, sense every `spacing` along it. With σ_n the sensor's noise,

    MI1(n)  = IG(P_T; σ_n)            what the tasks alone would tell            [nats]
    MI2(n)  = IG(places along the tour; σ_n)   what is gathered on the way       [nats]
    σ_T(n)  : IG(P_T; σ_T) = MI2(n)   the planning noise that closes the gap ("the noise level is less" in the paper)
    uncovered(n): share of the region whose posterior sd after the tour stays over a limit

    lawnmower(n)                      IG along lanes to and fro of the same length     [nats]

IG is used for all so that they are comparable: it does not depend on the test points. Few tasks leave much of the
region uncovered (the paper's underfitted); with many, another kilometre of tour tells little (overfitted).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from formulations.mapping.lawnmower import lanes
from formulations.task_location.placement import PlacementMethod, PlacementProblem, lattice, place
from formulations.task_location.tour import along, closed_tour, tour_length
from formulations.task_location.uncertainty import information_gain, posterior_sd
from formulations.task_location.variance_reduction import Goal
from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError

MOST_UNCOVERED = 0.01
"""Share of the region that may stay over the sd limit after the tour."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One n of the study.

    points : (n, 2) [m]. order : of the closed tour. length [m] : of it. mutual_information [nats] : criterion (b).
    mi1, mi2 [nats], planning_noise : σ_T, None where no σ_T between 1e-6 and 1e3 closes the gap.
    uncovered : share of the region with a posterior sd over the limit after the tour, 0 to 1; uncovered_tasks after
    readings at the tasks alone. mean_sd, highest_sd : posterior sd after the tour.
    lawnmower [nats] : IG along a lawnmower track of this tour's length; None where no number of lanes comes near it.
    per_km [nats/km] : MI2 more than the trial before, for every km of tour more; None where the tour is no longer.
    """

    points: Floats
    order: list[int]
    length: float
    mutual_information: float
    mi1: float
    mi2: float
    planning_noise: float | None
    uncovered: float
    uncovered_tasks: float
    mean_sd: float
    highest_sd: float
    per_km: float | None = None
    lawnmower: float | None = None

    @property
    def n(self) -> int:
        """The number of tasks."""
        return len(self.points)


@dataclass(frozen=True)
class Recommendation:
    """The n that is recommended and the reason in words; underfitted and overfitted are the edges it lies between."""

    n: int
    reason: str
    underfitted_below: int
    overfitted_above: int


def trials(
    region: Region,
    criterion: Goal,
    numbers: Iterable[int],
    method: PlacementMethod,
    name: str,
    *,
    seed: int = 0,
    sd_limit: float = 3.0,
    spacing: float | None = None,
    observe: Callable[[Trial], None] | None = None,
) -> list[Trial]:
    """Return a Trial for each n in ascending order.

    sd_limit : what counts as uncovered, in the unit of the signal. spacing [m] : of the readings along the tour,
    a quarter of the shorter length scale unless given.
    """
    if not sd_limit > 0:
        raise InputError(f"study: the sd limit must be positive, got {sd_limit}")
    kernel, noise_sd = criterion.kernel, criterion.noise_sd
    step = min(kernel.length_scales) / 4 if spacing is None else spacing
    eye = lattice(region, 101)
    tracks = lawnmower_tracks(region, criterion, step)
    done: list[Trial] = []
    for n in sorted(set(numbers)):
        placement = place(PlacementProblem(region, criterion, n), method, name, seed=seed)
        order = closed_tour(placement.points, seed=seed)
        sensed = along(placement.points, order, step)
        after = posterior_sd(kernel, noise_sd, sensed, eye)
        length = tour_length(placement.points, order)
        mi2 = information_gain(kernel, noise_sd, sensed)
        more = length - done[-1].length if done else 0.0
        trial = Trial(
            points=placement.points,
            order=order,
            length=length,
            mutual_information=placement.mutual_information,
            mi1=information_gain(kernel, noise_sd, placement.points),
            mi2=mi2,
            planning_noise=planning_noise(criterion, placement.points, mi2),
            uncovered=float((after > sd_limit).mean()),
            uncovered_tasks=float((posterior_sd(kernel, noise_sd, placement.points, eye) > sd_limit).mean()),
            mean_sd=float(after.mean()),
            highest_sd=float(after.max()),
            per_km=(mi2 - done[-1].mi2) / (more / 1000) if more > 1.0 else None,
            lawnmower=_at(tracks, length),
        )
        done.append(trial)
        if observe is not None:
            observe(trial)
    return done


def lawnmower_tracks(region: Region, criterion: Goal, step: float, most: int = 25) -> Floats:
    """Return length [m] and IG [nats] of closed lawnmower tracks of 1 to `most` lanes, ascending, shape (most, 2)."""
    found = []
    for count in range(1, most + 1):
        track = lanes(region, count, 0)
        order = list(range(len(track)))
        gain = information_gain(criterion.kernel, criterion.noise_sd, along(track, order, step))
        found.append((tour_length(track, order), gain))
    return np.array(sorted(found))


def _at(tracks: Floats, length: float) -> float | None:
    """Return the information of a track of `length` between those tried, or None outside them."""
    if not tracks[0, 0] <= length <= tracks[-1, 0]:
        return None
    return float(np.interp(length, tracks[:, 0], tracks[:, 1]))


def planning_noise(criterion: Goal, points: Floats, target: float) -> float | None:
    """Return σ_T with IG(points; σ_T) = `target` [nats], or None where none between 1e-6 and 1e3 does."""
    eigenvalues = np.maximum(np.linalg.eigvalsh(criterion.kernel(points, points)), 0.0)

    def gap(log_sd: float) -> float:
        return 0.5 * float(np.log1p(eigenvalues * math.exp(-2 * log_sd)).sum()) - target

    low, high = math.log(1e-6), math.log(1e3)
    if gap(low) < 0 or gap(high) > 0:
        return None
    return math.exp(float(brentq(gap, low, high)))


def recommend(done: list[Trial]) -> Recommendation:
    """Return the n to take.

    Underfitted: below the first n from which on every number tried leaves at most MOST_UNCOVERED of the region over
    the sd limit after its tour. That n is taken, as every task more lengthens the tour. Overfitted: from the first n
    on at which a kilometre of tour tells less than a third of what it tells at the smallest n.
    """
    if not done:
        raise InputError("study: there is no trial to recommend from")
    bare = [trial for trial in done if trial.uncovered > MOST_UNCOVERED]
    covered = [trial for trial in done if not bare or trial.n > bare[-1].n]
    if not covered:
        last = done[-1]
        reason = (
            f"none of the numbers tried covers the region: {last.n} tasks leave {last.uncovered:.1%} of it over the sd "
            "limit after the tour; try more"
        )
        return Recommendation(last.n, reason, last.n, last.n)
    best = covered[0]
    first, here = _slope(done, done[0]), _slope(done, best)
    flat = [t for t in covered if first and (slope := _slope(done, t)) is not None and slope < first / 3]
    reason = f"the fewest tasks whose tour leaves at most {MOST_UNCOVERED:.0%} of the region over the sd limit"
    reason += f" ({best.uncovered:.1%}" + (f"; {bare[-1].n} leave {bare[-1].uncovered:.1%})" if bare else ")")
    if first is not None and here is not None:
        reason += f"; a kilometre of tour more tells {here:.2f} nats here, {first:.2f} at n = {done[0].n}"
    if best.lawnmower is not None:
        reason += f"; a lawnmower of the same {best.length / 1000:.0f} km gathers {best.lawnmower:.0f} nats, this tour"
        reason += f" {best.mi2:.0f}"
    reason += f"; the knee of MI2 against kilometres is at n = {_knee(done).n}"
    return Recommendation(best.n, reason, best.n, flat[0].n if flat else done[-1].n)


def _knee(done: list[Trial]) -> Trial:
    """Return the trial farthest above the chord of (km, MI2) (Satopää et al. 2011)."""
    km, mi2 = (np.array(values) for values in zip(*((t.length, t.mi2) for t in done), strict=True))
    if len(done) < 3 or km[-1] <= km[0]:
        return done[-1]
    above = (mi2 - mi2[0]) / max(mi2[-1] - mi2[0], 1e-12) - (km - km[0]) / (km[-1] - km[0])
    return done[int(np.argmax(above))]


def _slope(done: list[Trial], at: Trial) -> float | None:
    """Return dMI2/dkm from `at` to the trial with at least a fifth more tasks, or None at the end."""
    later = next((t for t in done if t.n >= 1.2 * at.n and t.length > at.length), None)
    return None if later is None else 1000 * (later.mi2 - at.mi2) / (later.length - at.length)
