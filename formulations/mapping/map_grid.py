"""The points at which a field is mapped: the centres of square cells over a region."""

from __future__ import annotations

import numpy as np

from instances.arrays import Bools, Floats
from instances.environment.region import Region


class MapGrid:
    """The cells of a map: centres x (nx,) and y (ny,) [m], and which of them lie in the region, (ny, nx)."""

    def __init__(self, x: Floats, y: Floats, inside: Bools) -> None:
        self.x, self.y, self.inside = x, y, inside

    @classmethod
    def over(cls, region: Region, cells: int) -> MapGrid:
        """Return about square cells over `region`, `cells` of them along the longer side."""
        x0, y0, x1, y1 = region.bounds
        size = max(x1 - x0, y1 - y0) / cells
        nx, ny = max(2, round((x1 - x0) / size)), max(2, round((y1 - y0) / size))
        x = x0 + (np.arange(nx) + 0.5) * (x1 - x0) / nx
        y = y0 + (np.arange(ny) + 0.5) * (y1 - y0) / ny
        points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        return cls(x, y, region.contains(points).reshape(ny, nx))

    @property
    def points(self) -> Floats:
        """The centres in the region, shape (p, 2) [m]."""
        return np.stack(np.meshgrid(self.x, self.y), axis=-1)[self.inside]

    def raster(self, values: Floats) -> Floats:
        """Return values (p,) at `points` as a raster (ny, nx), NaN outside the region."""
        out = np.full(self.inside.shape, np.nan)
        out[self.inside] = values
        return out
