"""Cores of vortices: where the wind itself parts the paths between two points into several locally best ones.

A core bends paths like a lens. By how much a path is turned changes across it by about (ω − ω̄)/v0 a metre, ω being the
vorticity in the core and ω̄ that of the region; two paths from one point meet again behind it within the region's size L
only where that is more than 4/L or so (a lens half way between two points L apart). Weaker cores part no paths.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter

from formulations.moving_cost.field import Bending
from instances.arrays import Floats
from instances.environment.region import Region

WEAKEST = 3.0
"""(ω − ω̄) L/v0 of the weakest core."""
APART = 0.05
"""Least distance of cores from each other, as a fraction of the region's longer side."""
MOST = 8
"""Cores at most, the strongest."""


def vortex_cores(bending: Bending, region: Region) -> Floats:
    """Return the centres (k, 2) [m] of cores in `region` strong enough to part paths, the strongest first."""
    field = bending.vorticity
    rows, columns = field.omega.shape
    x, y = np.meshgrid(field.x + field.dx * np.arange(columns), field.y + field.dy * np.arange(rows))
    centres = np.column_stack([x.ravel(), y.ravel()])
    inside = region.contains(centres)
    x0, y0, x1, y1 = region.bounds
    size = max(x1 - x0, y1 - y0)
    mean = float(field.omega.ravel()[inside].mean()) if inside.any() else 0.0
    strength = np.abs(field.omega - mean) * size / bending.speed
    window = [max(3, round(APART * size / step)) for step in (field.dy, field.dx)]
    peak = (strength == maximum_filter(strength, window)) & (strength > WEAKEST) & inside.reshape(rows, columns)
    order = np.argsort(-strength[peak], kind="stable")[:MOST]
    return centres[peak.ravel()][order]
