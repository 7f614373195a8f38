"""A guaranteed upper bound on the maximum of h(x) = φ(x)ᵀΘφ(x) over a region, φ the features of the kernel.

On a cell of sides δ, h is at most its largest corner plus the error of bilinear interpolation,

    (1/8) Σ_d δ_d² max_cell |∂_d² h|,   max_cell |∂_d² h| ≤ max_corners |∂_d² h| + ½ Σ_e δ_e max |∂_d² ∂_e h|

(every point of the cell is within δ/2 of a corner along each axis). With z = x/l and V = σ_f² ‖Θ‖, the norms of the
features' derivatives, ‖φ‖ = σ_f, ‖∂φ‖ = σ_f, ‖∂_x∂_yφ‖ = σ_f, ‖∂²φ‖ = √3 σ_f, ‖∂_x²∂_yφ‖ = √3 σ_f and
‖∂³φ‖ = √15 σ_f (moments of a Gaussian, by axis), bound the third derivatives by the product rule:

    |∂_x³ h| ≤ 2 (√15 + 3√3) V,      |∂_x² ∂_y h| ≤ 2 (√3 + 2 + √3) V

Cells that meet the region are halved until the bound is tight where h is highest.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import shapely

from instances.arrays import Floats
from instances.environment.region import Region

STRAIGHT = 2 * (math.sqrt(15) + 3 * math.sqrt(3))
MIXED = 2 * (2 * math.sqrt(3) + 2)
CORNERS = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
FIRST_CELLS = 20
"""Cells a length scale to begin with."""
MOST_CORNERS = 250_000
"""A level with more corners is not evaluated: the bound of the level before stands."""


def supremum(
    expansion: Callable[[Floats], tuple[Floats, Floats]],
    region: Region,
    scales: Floats,
    magnitude: float,
    tolerance: float = 3e-4,
) -> float:
    """Return an upper bound on max h over `region`, above it by at most about `tolerance` (relative).

    expansion : maps points (p, 2) [m] to h (p,) and its second derivatives (p, 2) along x and y [1/m²].
    scales : the kernel's length scales (2,) [m]. magnitude : V.
    """
    x0, y0, x1, y1 = region.bounds
    origin, sides = np.array([x0, y0]), np.array([x1 - x0, y1 - y0])
    counts = np.clip(np.ceil(sides / scales * FIRST_CELLS), 1, 400).astype(int)
    cells = np.stack(np.meshgrid(*map(np.arange, counts)), axis=-1).reshape(-1, 2)  # whole numbers: lower left corners
    found, closed, still_open = -math.inf, -math.inf, math.inf
    while True:
        side = sides / counts
        low = origin + cells * side
        cells = cells[shapely.intersects(region.polygon, shapely.box(*low.T, *(low + side).T))]
        if not len(cells):
            return closed
        lattice, which = np.unique((cells[:, None] + CORNERS).reshape(-1, 2), axis=0, return_inverse=True)
        if len(lattice) > MOST_CORNERS:
            return max(closed, still_open)
        corners = origin + lattice * side
        values, curvature = _in_parts(expansion, corners)
        inside = region.contains(corners)
        found = max(found, float(values[inside].max(initial=-math.inf)))
        delta = side / scales
        third = (
            0.5 * magnitude * np.array([STRAIGHT * delta[0] + MIXED * delta[1], MIXED * delta[0] + STRAIGHT * delta[1]])
        )
        bend = np.abs(curvature)[which].reshape(-1, 4, 2).max(axis=1) * scales**2 + third
        bounds = values[which].reshape(-1, 4).max(axis=1) + bend @ delta**2 / 8
        high = bounds > found + tolerance * abs(found)
        closed = max(closed, float(bounds[~high].max(initial=-math.inf)))
        still_open = float(bounds[high].max(initial=-math.inf))
        cells, counts = (2 * cells[high][:, None] + CORNERS).reshape(-1, 2), 2 * counts


def _in_parts(expansion: Callable[[Floats], tuple[Floats, Floats]], points: Floats) -> tuple[Floats, Floats]:
    """Evaluate `expansion` some thousand points at a time, so that what it needs stays in the cache."""
    parts = [expansion(part) for part in np.array_split(points, max(1, len(points) // 2000))]
    return np.concatenate([h for h, _ in parts]), np.concatenate([c for _, c in parts])
