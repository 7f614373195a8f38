"""What a terrain profile says to the Irregular Terrain Model: horizons, effective heights and irregularity Δh.

A profile is heights [m] above sea level at equal distances `step` [m], terminal to terminal, shape (k,).
"""

from __future__ import annotations

import math

import numpy as np

from instances.arrays import Floats
from instances.kernels import njit


@njit(cache=True)
def horizons(heights: Floats, step: float, earth: float, h1: float, h2: float) -> tuple[float, float, float, float]:
    """Return the horizon angles [rad] and distances [m] of both terminals: θ₁, θ₂, d₁, d₂ [TN101, eq. 6.15].

    earth : effective Earth radius a_e [m]; h1, h2 : antenna heights above ground [m]. In plain sight the horizon is
    the other terminal.
    """
    last = len(heights) - 1
    d = last * step
    z1, z2 = heights[0] + h1, heights[last] + h2
    t1 = (z2 - z1) / d - d / (2.0 * earth)
    t2 = (z1 - z2) / d - d / (2.0 * earth)
    d1 = d2 = d
    for i in range(1, last):
        x1, x2 = i * step, d - i * step
        up1 = (heights[i] - z1) / x1 - x1 / (2.0 * earth)
        up2 = (heights[i] - z2) / x2 - x2 / (2.0 * earth)
        if up1 > t1:
            t1, d1 = up1, x1
        if up2 > t2:
            t2, d2 = up2, x2
    return t1, t2, d1, d2


@njit(cache=True)
def line_fit(heights: Floats, step: float, begin: float, end: float) -> tuple[float, float]:
    """Return the least-squares line over [begin, end] [m], as its heights at the profile's first and last point."""
    last = len(heights) - 1
    i0 = int(max(begin / step, 0.0))
    i1 = last - int(max(last - end / step, 0.0))
    if i1 <= i0:
        i0 = max(i0 - 1, 0)
        i1 = last - max(last - (i1 + 1), 0)
    span = float(i1 - i0)
    centre = i0 + 0.5 * span
    # trapezoidal weights: the end points count half
    level = 0.5 * (heights[i0] + heights[i1])
    moment = 0.5 * (heights[i1] - heights[i0]) * 0.5 * span
    for i in range(i0 + 1, i1):
        level += heights[i]
        moment += heights[i] * (i - centre)
    level /= span
    slope = moment * 12.0 / ((span * span + 2.0) * span)
    return level - slope * centre, level + slope * (last - centre)


@njit(cache=True)
def irregularity(heights: Floats, step: float, begin: float, end: float) -> float:
    """Return Δh [m]: the interdecile range of heights about their line over [begin, end], for an endless path.

    The range over the path is divided by 1 − 0.8 exp(−D/50 km) [ERL79, eq. 3]. The profile is resampled to at most
    245 points.
    """
    last = len(heights) - 1
    x0, x1 = begin / step, end / step
    if x1 - x0 < 2.0:
        return 0.0
    tenth = min(max(4, int(0.1 * (x1 - x0 + 8.0))), 25)
    count = 10 * tenth - 5
    pitch = (x1 - x0) / (count - 1)
    sampled = np.empty(count)
    i = int(x0)
    beyond = x0 - (i + 1.0)  # how far past node i + 1
    for j in range(count):
        while beyond > 0.0 and i + 1 < last:
            beyond -= 1.0
            i += 1
        sampled[j] = heights[i + 1] + (heights[i + 1] - heights[i]) * beyond
        beyond += pitch
    first, final = line_fit(sampled, 1.0, 0.0, count - 1.0)
    slope = (final - first) / (count - 1.0)
    for j in range(count):
        sampled[j] -= first + slope * j
    ordered = np.sort(sampled)[::-1]
    spread = ordered[tenth - 1] - ordered[count - tenth]
    return spread / (1.0 - 0.8 * math.exp(-(end - begin) / 50e3))


@njit(cache=True)
def roughness(d: float, irregular: float) -> float:
    """Return Δh(d) [m] of a path of length d [m] [ERL79, eq. 3]."""
    return irregular * (1.0 - 0.8 * math.exp(-d / 50e3))


@njit(cache=True)
def _smooth_horizon(height: float, earth: float, irregular: float) -> float:
    return math.sqrt(2.0 * height * earth) * math.exp(-0.07 * math.sqrt(irregular / max(height, 5.0)))


@njit(cache=True)
def terrain_parameters(
    heights: Floats, step: float, earth: float, h1: float, h2: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return θ₁, θ₂ [rad], d₁, d₂ [m], effective heights h_e1, h_e2 [m] and Δh [m] of a path."""
    last = len(heights) - 1
    d = last * step
    t1, t2, d1, d2 = horizons(heights, step, earth, h1, h2)
    begin = min(15.0 * h1, 0.1 * d1)
    end = d - min(15.0 * h2, 0.1 * d2)
    irregular = irregularity(heights, step, begin, end)
    if d1 + d2 <= 1.5 * d:  # beyond the horizon: each terminal over the line of its own foreground
        ground1, _ = line_fit(heights, step, begin, 0.9 * d1)
        _, ground2 = line_fit(heights, step, d - 0.9 * d2, end)
        he1 = h1 + max(heights[0] - ground1, 0.0)
        he2 = h2 + max(heights[last] - ground2, 0.0)
        return t1, t2, d1, d2, he1, he2, irregular
    # well within line of sight: horizons of a typical path over such terrain
    ground1, ground2 = line_fit(heights, step, begin, end)
    he1 = h1 + max(heights[0] - ground1, 0.0)
    he2 = h2 + max(heights[last] - ground2, 0.0)
    d1, d2 = _smooth_horizon(he1, earth, irregular), _smooth_horizon(he2, earth, irregular)
    if d1 + d2 <= d:
        raised = (d / (d1 + d2)) ** 2
        he1, he2 = he1 * raised, he2 * raised
        d1, d2 = _smooth_horizon(he1, earth, irregular), _smooth_horizon(he2, earth, irregular)
    s1, s2 = math.sqrt(2.0 * he1 * earth), math.sqrt(2.0 * he2 * earth)
    t1 = (0.65 * irregular * (s1 / d1 - 1.0) - 2.0 * he1) / s1
    t2 = (0.65 * irregular * (s2 / d2 - 1.0) - 2.0 * he2) / s2
    return t1, t2, d1, d2, he1, he2, irregular
