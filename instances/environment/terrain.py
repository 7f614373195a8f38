"""Terrain: the ground's elevation on a rectangular grid, from a digital elevation model or synthetic mountains.

Files are GeoTIFF or NetCDF (extra ``geo``) or ESRI ASCII grids, in metres of a map projection or, for a site whose
place on Earth is known, in any projection or degrees (`instances.environment.site`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.raster import (
    METRES,
    Raster,
    bilinear,
    check_grid,
    netcdf_raster,
    node_bounds,
    open_netcdf,
    read_ascii_grid,
    read_geotiff,
)
from instances.environment.site import Site, check_metres
from instances.errors import InputError, naming, shown
from instances.extent import LARGEST, positive

ELEVATIONS = (
    "surface_altitude",
    "height",
    "ground_level_altitude",
    "altitude",
    "elevation",
    "z",
    "Band1",
    "HGT",
    "topo",
)
"""CF standard names and usual variable names of elevations."""
FINER = 4
"""Nodes along each cell of a model in another projection: heights above the ground are told from them."""


@dataclass(frozen=True, eq=False)
class Terrain:
    """Elevation of the ground on a rectangular grid.

    Parameters
    ----------
    origin
        (x, y) [m] of node (0, 0), the south-western one.
    spacing
        (dx, dy) [m] between nodes.
    height
        Elevation [m], shape (rows, columns), rows going north.
    source
        The file, for sentences.
    crs
        Its map projection, where the file says so.

    Raises
    ------
    InputError
        Where the grid has fewer than 2 × 2 nodes or an elevation is missing.
    """

    origin: tuple[float, float]
    spacing: tuple[float, float]
    height: Floats
    source: str = ""
    crs: str = ""

    def __post_init__(self) -> None:
        where = f"terrain {self.source}".strip()
        h = np.ascontiguousarray(self.height, dtype=np.float64)
        h.setflags(write=False)
        object.__setattr__(self, "height", h)
        if h.ndim != 2 or min(h.shape) < 2:
            raise InputError(f"{where}: elevations must fill a grid of at least 2 × 2, got shape {h.shape}")
        check_grid(where, self.origin, self.spacing, h)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max [m] of the nodes."""
        return node_bounds(self.origin, self.spacing, self.height.shape)

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the elevation [m] at `points` (k, 2) [m], bilinear, constant outside, shape (k,)."""
        p = (np.asarray(points, dtype=float).reshape(-1, 2) - np.array(self.origin)) / np.array(self.spacing)
        return bilinear(self.height, p[:, 0], p[:, 1])

    def resampled(self, cells: int) -> Terrain:
        """Return the same ground on about square cells, `cells` of them along the longer side, bilinear."""
        x0, y0, x1, y1 = self.bounds
        size = max(x1 - x0, y1 - y0) / cells
        columns, rows = (max(2, round(side / size)) + 1 for side in (x1 - x0, y1 - y0))
        xs, ys = np.linspace(x0, x1, columns), np.linspace(y0, y1, rows)
        h = self(np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)).reshape(rows, columns)
        spacing = (float(xs[1] - xs[0]), float(ys[1] - ys[0]))
        return Terrain((x0, y0), spacing, h, self.source, self.crs)


def mountains(
    size: float = 20_000.0, cells: int = 200, relief: float = 1500.0, length_scale: float = 10_000.0, seed: int = 0
) -> Terrain:
    """Return seeded synthetic mountains on a square of `size` [m] with its lower left corner at the origin.

    A Gaussian random field with spectrum ∝ (1 + (kL)²)^(−2.2), L = `length_scale` [m] over 2π, about the roughness of
    real ranges (B. Mandelbrot, The Fractal Geometry of Nature, 1982), stretched from 0 to `relief` [m]; valleys
    are flattened by squaring.
    """
    positive(size, "mountains: size [m]")
    positive(length_scale, "mountains: length_scale [m]")
    if not (cells >= 2 and 0 <= relief <= LARGEST):
        raise InputError("mountains: relief must be ≥ 0 and cells at least 2")
    n = cells + 1
    wide = 2 * n  # twice the square: the field of a Fourier series is periodic
    k = 2 * np.pi * np.fft.fftfreq(wide, size / cells)
    kk = k[:, None] ** 2 + k[None, :] ** 2
    amplitude = (1 + kk * (length_scale / (2 * np.pi)) ** 2) ** -1.1
    noise = np.fft.fft2(np.random.default_rng(seed).standard_normal((wide, wide)))
    field = np.fft.ifft2(noise * amplitude).real[:n, :n]
    unit = (field - field.min()) / np.ptp(field)
    return Terrain((0.0, 0.0), (size / cells, size / cells), relief * unit**2, f"mountains of seed {seed}")


def read_terrain(path: Path | str, site: Site | None = None) -> Terrain:
    """Read a digital elevation model by the ending of its name, for `site`; InputError names the file and the fault."""
    path = Path(path)
    raster = _raster(path)
    if raster.unit and raster.unit.lower() not in METRES:
        raise InputError(f"{path}: elevations must be in metres, their unit is {shown(raster.unit)}")
    if site is not None:
        raster = site.local(raster, path, FINER)
    else:
        with naming(path):
            check_metres(raster.crs)
    return Terrain(raster.origin, raster.spacing, raster.values, str(path), raster.crs)


def _raster(path: Path) -> Raster:
    if path.suffix in (".nc", ".nc4", ".cdf"):
        return _read_netcdf(path)
    if path.suffix != ".asc" and path.suffix.lower() not in (".tif", ".tiff"):
        raise InputError(f"{path}: a terrain file must be GeoTIFF (.tif), NetCDF (.nc) or an ASCII grid (.asc)")
    return read_ascii_grid(path) if path.suffix == ".asc" else read_geotiff(path)


def _read_netcdf(path: Path) -> Raster:
    with open_netcdf(path) as data:
        named = [z for name, z in data.data_vars.items() if z.attrs.get("standard_name", name) in ELEVATIONS]
        if not named:
            have = ", ".join(f"'{name}'" for name in data.data_vars) or "none"
            raise InputError(
                f"{path}: no variable with standard_name surface_altitude or named elevation (it has: {have})"
            )
        z = named[0].squeeze(drop=True)
        if z.ndim != 2:
            raise InputError(f"{path}: variable '{z.name}' must have two dimensions, it has {tuple(z.sizes)}")
        unit = str(z.attrs.get("units", "m"))
        if unit not in METRES:
            raise InputError(f"{path}: variable '{z.name}' must be in metres, its units are '{unit}'")
        return netcdf_raster(data, z, path)
