"""Wind on a rectangular grid, bilinear between nodes: what data files bring and what flow models make.

Along a straight line a bilinear field is quadratic inside a cell, so two Gauss points per crossed cell integrate
it exactly; the loop over cells is the grid walk of Amanatides & Woo (Eurographics 1987). Outside the grid the
field continues constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.raster import check_grid, node_axes, node_bounds, write_netcdf
from instances.environment.wind import ends_of, points_of
from instances.errors import InputError
from instances.kernels import njit

GAUSS = 0.5 / math.sqrt(3.0)


@njit(cache=True)
def velocity_at(fx: float, fy: float, u: Floats, v: Floats) -> tuple[float, float]:
    """Velocity at grid coordinates (column, row), constant outside; not a number where one of them is none."""
    rows, columns = u.shape
    fx = min(max(fx, 0.0), columns - 1.0)
    fy = min(max(fy, 0.0), rows - 1.0)
    i, j = max(min(int(fx), columns - 2), 0), max(min(int(fy), rows - 2), 0)
    s, t = fx - i, fy - j
    a, b, c, d = (1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t
    return (
        a * u[j, i] + b * u[j, i + 1] + c * u[j + 1, i] + d * u[j + 1, i + 1],
        a * v[j, i] + b * v[j, i + 1] + c * v[j + 1, i] + d * v[j + 1, i + 1],
    )


@njit(cache=True)
def _next_line(f: float, df: float, now: float, last: int) -> float:
    """Parameter at which f + t·df next meets a grid line 0..last after `now`, or 2 for none."""
    if df == 0.0:
        return 2.0
    here = f + now * df
    line = math.floor(here + 1e-12) + 1 if df > 0 else math.ceil(here - 1e-12) - 1
    line = max(line, 0) if df > 0 else min(line, last)
    if line < 0 or line > last:
        return 2.0
    return (line - f) / df


@njit(cache=True)
def _line_integrals(a: Floats, b: Floats, x0: float, y0: float, dx: float, dy: float, u: Floats, v: Floats) -> Floats:
    out = np.zeros(len(a))
    rows, columns = u.shape
    for k in range(len(a)):
        fx, fy = (a[k, 0] - x0) / dx, (a[k, 1] - y0) / dy
        dfx, dfy = (b[k, 0] - a[k, 0]) / dx, (b[k, 1] - a[k, 1]) / dy
        gx, gy = dfx * dx, dfy * dy
        now, total = 0.0, 0.0
        pieces = 2 * (rows + columns)  # it crosses each line once; rounding may stop twice at one
        while now < 1.0:
            pieces -= 1
            then = min(_next_line(fx, dfx, now, columns - 1), _next_line(fy, dfy, now, rows - 1), 1.0)
            if pieces <= 0:
                then = 1.0
            middle, half = 0.5 * (now + then), GAUSS * (then - now)
            for t in (middle - half, middle + half):
                wu, wv = velocity_at(fx + t * dfx, fy + t * dfy, u, v)
                total += 0.5 * (then - now) * (wu * gx + wv * gy)
            now = max(then, now + 1e-13)
        out[k] = total
    return out


@njit(cache=True)
def _velocities(p: Floats, x0: float, y0: float, dx: float, dy: float, u: Floats, v: Floats) -> Floats:
    out = np.empty((len(p), 2))
    for k in range(len(p)):
        out[k, 0], out[k, 1] = velocity_at((p[k, 0] - x0) / dx, (p[k, 1] - y0) / dy, u, v)
    return out


@dataclass(frozen=True, eq=False)
class Grid:
    """Bilinear wind: `u`, `v` [m/s], shape (rows, columns), node (0, 0) at `origin` [m], rows `spacing[1]` apart.

    `spacing` (dx, dy) [m] is positive: columns go east, rows go north. `source` names the file it came from, `crs`
    the map projection of its coordinates where the file says so.
    """

    origin: tuple[float, float]
    spacing: tuple[float, float]
    u: Floats
    v: Floats
    source: str = ""
    crs: str = ""

    def __post_init__(self) -> None:
        where = f"wind grid {self.source}".strip()
        for name in ("u", "v"):
            array = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.u.ndim != 2 or self.u.shape != self.v.shape or min(self.u.shape) < 2:
            raise InputError(
                f"{where}: u and v must have one shape of at least 2 × 2, got {self.u.shape} and {self.v.shape}"
            )
        check_grid(where, self.origin, self.spacing, self.u, self.v)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max [m] of the nodes."""
        return node_bounds(self.origin, self.spacing, self.u.shape)

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        return _velocities(points_of(points), *self.origin, *self.spacing, self.u, self.v)

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b`, exact for the bilinear field."""
        return _line_integrals(*ends_of(a, b), *self.origin, *self.spacing, self.u, self.v)

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table and write the field as NetCDF ``wind.nc`` into `folder`."""
        if folder is None:
            raise InputError("wind: a grid is data and needs a folder to write its file into")
        name = "wind.nc"
        fields = {
            component: (values, {"standard_name": f"{axis}_wind", "units": "m s-1"})
            for component, values, axis in (("u", self.u, "x"), ("v", self.v, "y"))
        }
        axes = node_axes(self.origin, self.spacing, self.u.shape)
        write_netcdf(Path(folder) / name, *axes, fields, {"source": self.source, "crs": self.crs})
        return {"kind": "grid", "file": name}
