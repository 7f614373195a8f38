"""The wind as the search sees it: gauge potential and vorticity on a grid, from exact line integrals.

This is for energies; what the search of flight times needs besides is a `wind_surface`.

On a grid over the region, the circulation along every grid edge is W_e = ∫ w·dσ, exactly. Its discrete Hodge split
W_e = φ_j − φ_i + R_e, with the least Σ R_e², gives the potential φ: the normal equations are the grid's Laplacian with
free ends, which the DCT-II diagonalises. Shifting costs by potentials leaves every argmin unchanged,

    c_ij + (φ_j − φ_i)/v0²,

shrinks |w|/v0 and keeps edges positive where the raw cost would not be. The circulation around a cell over its area
is its mean vorticity ω (Stokes), all that bends a path: free geodesics have curvature ω/v0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.fft import dctn, idctn

from formulations.moving_cost.wind_surface import NO_SURFACE, WindSurface, wind_surface
from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError
from instances.kernels import njit
from instances.moving_cost import CostKind, CostMeasure
from instances.wind_triangle import refuse_strong

CELLS = 160
"""Cells along the region's longer side."""


class Vorticity(NamedTuple):
    """Vorticity ω [1/s] at cell centres (rows, columns), bilinear between: first centre (x, y) [m], spacing [m]."""

    x: float
    y: float
    dx: float
    dy: float
    omega: Floats


class Bending(NamedTuple):
    """What bends the cheapest paths, for kernels: the vorticity bends those of least energy, the wind the quickest.

    timed : whether the cost is time. speed [m/s] : held constant. Without times the wind may be empty.
    """

    timed: bool
    speed: float
    vorticity: Vorticity
    wind: WindSurface


@njit(cache=True)
def vorticity_at(x: float, y: float, field: Vorticity) -> tuple[float, float, float]:
    """Vorticity [1/s] and its gradient [1/(s·m)] at a point; continued constant outside."""
    rows, columns = field.omega.shape
    fx = min(max((x - field.x) / field.dx, 0.0), columns - 1.0)
    fy = min(max((y - field.y) / field.dy, 0.0), rows - 1.0)
    i, j = min(int(fx), columns - 2), min(int(fy), rows - 2)
    s, t = fx - i, fy - j
    a, b, c, d = field.omega[j, i], field.omega[j, i + 1], field.omega[j + 1, i], field.omega[j + 1, i + 1]
    low, high = a + s * (b - a), c + s * (d - c)
    slope_x = ((b - a) + t * ((d - c) - (b - a))) / field.dx
    return low + t * (high - low), slope_x, (high - low) / field.dy


@dataclass(frozen=True, eq=False)
class SearchField:
    """Gauge potential `phi` [m²/s] at grid nodes, what bends paths, and how much the wind matters."""

    origin: tuple[float, float]
    spacing: tuple[float, float]
    phi: Floats
    bending: Bending
    max_speed: float
    rms_vorticity: float

    def potential(self, points: Floats) -> Floats:
        """Return φ [m²/s] at `points` (k, 2) [m], bilinear."""
        f = (points - np.array(self.origin)) / np.array(self.spacing)
        rows, columns = self.phi.shape
        i = np.clip(f[:, 0].astype(int), 0, columns - 2)
        j = np.clip(f[:, 1].astype(int), 0, rows - 2)
        s, t = f[:, 0] - i, f[:, 1] - j
        low = self.phi[j, i] * (1 - s) + self.phi[j, i + 1] * s
        high = self.phi[j + 1, i] * (1 - s) + self.phi[j + 1, i + 1] * s
        return low * (1 - t) + high * t


def search_field(measure: CostMeasure, region: Region) -> SearchField:
    """Split the wind of `measure` over the bounding box of `region`.

    Raises InputError where |w| ≥ v0 inside the region and, for energies, the potential part does not explain it: no
    path cost is then sure to be positive (the paper assumes v0 > w_σ).
    """
    wind, v0, timed = measure.wind, measure.speed, measure.kind is CostKind.TIME
    x0, y0, x1, y1 = region.bounds
    cells = max(x1 - x0, y1 - y0) / CELLS
    nx, ny = (max(8, math.ceil(side / cells)) + 1 for side in (x1 - x0, y1 - y0))
    dx, dy = (x1 - x0) / (nx - 1), (y1 - y0) / (ny - 1)
    nodes = np.stack(np.meshgrid(np.linspace(x0, x1, nx), np.linspace(y0, y1, ny)), axis=-1)
    along_x = wind.line_integral(nodes[:, :-1], nodes[:, 1:]).reshape(ny, nx - 1)
    along_y = wind.line_integral(nodes[:-1], nodes[1:]).reshape(ny - 1, nx)
    phi = _potential(along_x, along_y, dx, dy)
    omega = (along_x[:-1] + along_y[:, 1:] - along_x[1:] - along_y[:, :-1]) / (dx * dy)
    inside = region.contains(nodes.reshape(-1, 2)).reshape(ny, nx)
    w = wind(nodes.reshape(-1, 2)).reshape(ny, nx, 2)
    residual = w - np.stack([np.gradient(phi, dx, axis=1), np.gradient(phi, dy, axis=0)], axis=-1)
    speed, left = (np.where(inside, np.hypot(f[..., 0], f[..., 1]), 0.0) for f in (w, residual))
    if timed:
        refuse_strong(nodes.reshape(-1, 2), speed.ravel(), v0)
    elif speed.max() >= v0 and left.max() >= v0:
        j, i = np.unravel_index(np.argmax(left), left.shape)
        x, y = nodes[j, i]
        raise InputError(
            f"wind: at ({x:.0f}, {y:.0f}) m it blows with {speed[j, i]:.3g} m/s ({left[j, i]:.3g} m/s of it not a "
            f"potential wind), not less than the ground speed of {v0:.3g} m/s"
        )
    cell_inside = inside[:-1, :-1] & inside[1:, 1:] & inside[:-1, 1:] & inside[1:, :-1]
    rms = math.sqrt(float((omega[cell_inside] ** 2).mean())) if cell_inside.any() else 0.0
    vorticity = Vorticity(x0 + dx / 2, y0 + dy / 2, dx, dy, omega)
    surface = wind_surface(wind, region.bounds, (dx, dy)) if timed else NO_SURFACE
    bending = Bending(timed, v0, vorticity, surface)
    return SearchField((x0, y0), (dx, dy), phi, bending, float(speed.max()), rms)


def _potential(along_x: Floats, along_y: Floats, dx: float, dy: float) -> Floats:
    """Return φ at the nodes with the least Σ (W_e − Δφ)², x-edges weighted dy/dx and y-edges dx/dy."""
    ny, nx = along_x.shape[0], along_y.shape[1]
    divergence = np.zeros((ny, nx))
    divergence[:, :-1] -= along_x * dy / dx
    divergence[:, 1:] += along_x * dy / dx
    divergence[:-1] -= along_y * dx / dy
    divergence[1:] += along_y * dx / dy
    eigen_x, eigen_y = (4 * np.sin(np.pi * np.arange(n) / (2 * n)) ** 2 for n in (nx, ny))
    laplacian = eigen_x[None, :] * dy / dx + eigen_y[:, None] * dx / dy
    laplacian[0, 0] = 1.0
    spectrum = dctn(divergence, type=2) / laplacian
    spectrum[0, 0] = 0.0
    return np.asarray(idctn(spectrum, type=2))
