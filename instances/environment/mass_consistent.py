"""Mass-consistent flow over terrain: the divergence-free wind nearest to an inflow profile.

Variational model of Y. Sasaki (1970) and C. A. Sherman (J. Appl. Meteor. 17, 1978), as in WindNinja: minimise
∫ |u − u0|² dV subject to ∇·u = 0. With the multiplier λ,

    u = u0 + ∇λ,    ∫ (u0 + ∇λ)·∇ψ dV = 0 for all ψ,    λ = 0 on the sides and the top (open),

so that nothing flows through the ground, weakly. Trilinear elements follow the terrain: z = h + s·D, D = H − h the
depth of air below the lid H, s from 0 to 1. Since D and the slopes p = ∂h/∂x, q = ∂h/∂y depend on (x, y) alone, the
form separates into plane and vertical factors,

    ∫ D ∇₂λ·∇₂ψ − (1−s)(p,q)·(∇₂λ ψ_s + λ_s ∇₂ψ) + ((p² + q²)(1−s)² + 1)/D · λ_s ψ_s  dx dy ds,

five plane stencils of nine points, each with one tridiagonal vertical matrix: a matrix-vector product touches 45
numbers a column. Conjugate gradients are preconditioned by the same operator over flat ground, which a sine transform
in x and y and a tridiagonal solve in s invert.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dstn

from instances.arrays import Floats
from instances.environment.terrain import Terrain
from instances.environment.wind_grid import Grid
from instances.errors import InputError, shown
from instances.extent import positive
from instances.kernels import njit

TOLERANCE = 1e-5
"""Of the residual of conjugate gradients, relative to the right-hand side's."""
PROFILES = ("uniform", "log", "power")


@dataclass(frozen=True)
class Inflow:
    """Wind far upstream: `velocity` (u, v) [m/s] at `reference` [m] above ground, and how it varies with height.

    profile : "uniform"; "log", ∝ ln(1 + z/roughness); "power", ∝ z^exponent (z above ground).
    """

    velocity: tuple[float, float]
    profile: str = "log"
    reference: float = 1000.0
    roughness: float = 0.5
    exponent: float = 0.143

    def __post_init__(self) -> None:
        if self.profile not in PROFILES:
            raise InputError(f"wind: unknown profile {shown(self.profile)} (known: {', '.join(PROFILES)})")
        positive(self.reference, "wind: reference [m]")
        positive(self.roughness, "wind: roughness [m]")
        if not 0 <= self.exponent <= 10:
            raise InputError(f"wind: exponent must be from 0 to 10, got {self.exponent}")

    def factor(self, z: Floats) -> Floats:
        """Return the speed at heights `z` [m] above ground over that at the reference height."""
        z = np.maximum(np.asarray(z, dtype=float), 0.0)
        if self.profile == "uniform":
            return np.ones_like(z)
        if self.profile == "log":
            return np.log1p(z / self.roughness) / math.log1p(self.reference / self.roughness)
        return (z / self.reference) ** self.exponent


@dataclass(frozen=True, eq=False)
class Flow:
    """A solved flow over `terrain`: multiplier `lam` (rows, columns, levels) [m²/s] on `levels` s; lid at `top` [m]."""

    terrain: Terrain
    inflow: Inflow
    top: float
    levels: Floats
    lam: Floats
    iterations: int

    def slice(self, altitude: float) -> Grid:
        """Return the horizontal wind at `altitude` [m] above the datum; InputError where the ground is higher."""
        h = self.terrain.height
        if not h.max() < altitude < self.top:
            j, i = np.unravel_index(np.argmax(h), h.shape)
            x, y = (o + k * d for o, k, d in zip(self.terrain.origin, (i, j), self.terrain.spacing, strict=True))
            raise InputError(
                f"wind: altitude must lie between the highest ground, {h.max():.0f} m at ({x:.0f}, {y:.0f}) m, and the "
                f"lid of the flow at {self.top:.0f} m, got {altitude:g} m"
            )
        lam = _at_altitude(self.lam, self.levels, h, self.top, altitude)
        dx, dy = self.terrain.spacing
        factor = self.inflow.factor(altitude - h)
        u = self.inflow.velocity[0] * factor + np.gradient(lam, dx, axis=1, edge_order=2)
        v = self.inflow.velocity[1] * factor + np.gradient(lam, dy, axis=0, edge_order=2)
        source = f"flow over {self.terrain.source or 'terrain'} at {altitude:g} m"
        return Grid(self.terrain.origin, self.terrain.spacing, u, v, source, self.terrain.crs)


def solve_flow(terrain: Terrain, inflow: Inflow, *, layers: int = 30, top: float | None = None) -> Flow:
    """Return the mass-consistent flow over `terrain`, on its own grid with `layers` layers of cells.

    top : lid [m]; by default three times the relief above the highest ground, at least 3000 m above it.
    """
    h = terrain.height
    lid = float(h.max() + max(3000.0, 3 * np.ptp(h))) if top is None else float(top)
    if not lid > h.max():
        raise InputError(f"wind: the lid of the flow, {lid:g} m, must be above the highest ground, {h.max():g} m")
    if layers < 2:
        raise InputError(f"wind: layers must be at least 2, got {layers}")
    s = np.linspace(0.0, 1.0, layers + 1) ** 1.5  # thinner layers near the ground
    dx, dy = terrain.spacing
    plane = _plane_stencils(h, lid, dx, dy)
    vertical = _vertical_matrices(s)
    table = np.linspace(0.0, (lid - float(h.min())) * (1 + 1e-9), 20_001)  # heights above ground
    b = _right_hand_side(h, lid, dx, dy, s, inflow.factor(table), float(table[1]), *inflow.velocity)
    solve_flat = _FlatSolver(h.shape, dx, dy, lid - float(h.mean()), vertical)
    lam, iterations = _conjugate_gradients(plane, vertical, b, solve_flat)
    return Flow(terrain, inflow, lid, s, lam, iterations)


def _vertical_matrices(s: Floats) -> Floats:
    """Return the five vertical matrices as (5, 3, levels): below, diagonal, above; without the lid's row and column.

    0: ∫φφ; 1: ∫(1−s) φ_i φ_j'; 2: its transpose; 3: ∫(1−s)² φ'φ'; 4: ∫φ'φ'; i the row, j the column.
    """
    n = len(s)
    out = np.zeros((5, 3, n))
    for k in range(n - 1):
        ds, gauss = s[k + 1] - s[k], 0.5 / math.sqrt(3)
        for t in (0.5 - gauss, 0.5 + gauss):
            r = 1 - (s[k] + t * ds)
            value, slope = np.array([1 - t, t]), np.array([-1 / ds, 1 / ds])
            for i in range(2):
                for j in range(2):
                    entry = (
                        value[i] * value[j],
                        r * value[i] * slope[j],
                        r * slope[i] * value[j],
                        r * r * slope[i] * slope[j],
                        slope[i] * slope[j],
                    )
                    out[:, 1 + j - i, k + i] += 0.5 * ds * np.array(entry)
    return out[:, :, :-1].copy()


@njit(cache=True)
def _plane_stencils(h: Floats, lid: float, dx: float, dy: float) -> Floats:
    """Plane factors as nine-point stencils, (rows, columns, 5, 9), neighbour (b, a) at 3(b + 1) + a + 1.

    0: ∫D ∇ψ_i·∇ψ_j; 1: −∫(p,q)·∇ψ_i ψ_j; 2: −∫(p,q)·∇ψ_j ψ_i; 3: ∫(p² + q²)/D ψ_i ψ_j; 4: ∫ψ_i ψ_j/D.
    """
    rows, columns = h.shape
    out = np.zeros((rows, columns, 5, 9))
    gauss = 0.5 / math.sqrt(3.0)
    value, east, north = np.empty(4), np.empty(4), np.empty(4)
    for j in range(rows - 1):
        for i in range(columns - 1):
            for q in range(4):
                x = 0.5 + (gauss if q % 2 else -gauss)
                y = 0.5 + (gauss if q // 2 else -gauss)
                height, p, r = 0.0, 0.0, 0.0
                for a in range(4):
                    fx, fy = (x if a % 2 else 1 - x), (y if a // 2 else 1 - y)
                    value[a] = fx * fy
                    east[a] = (1.0 if a % 2 else -1.0) / dx * fy
                    north[a] = (1.0 if a // 2 else -1.0) / dy * fx
                    z = h[j + a // 2, i + a % 2]
                    height += z * value[a]
                    p += z * east[a]
                    r += z * north[a]
                depth, w = lid - height, 0.25 * dx * dy
                for a in range(4):
                    for b in range(4):
                        n = 3 * (b // 2 - a // 2 + 1) + (b % 2 - a % 2 + 1)
                        at = out[j + a // 2, i + a % 2]
                        at[0, n] += w * depth * (east[a] * east[b] + north[a] * north[b])
                        at[1, n] -= w * (p * east[a] + r * north[a]) * value[b]
                        at[2, n] -= w * (p * east[b] + r * north[b]) * value[a]
                        at[3, n] += w * (p * p + r * r) / depth * value[a] * value[b]
                        at[4, n] += w / depth * value[a] * value[b]
    return out


@njit(cache=True, fastmath=True)
def _apply(plane: Floats, vertical: Floats, x: Floats, y: Floats) -> None:
    """y = A x over the inner columns; x and y are (rows, columns, levels below the lid), zero on the sides."""
    rows, columns, n = x.shape
    part = np.zeros((5, n + 2))
    for j in range(1, rows - 1):
        for i in range(1, columns - 1):
            part[:] = 0.0
            for b in range(3):
                for a in range(3):
                    column = x[j + b - 1, i + a - 1]
                    c0, c1, c2 = plane[j, i, 0, 3 * b + a], plane[j, i, 1, 3 * b + a], plane[j, i, 2, 3 * b + a]
                    c3, c4 = plane[j, i, 3, 3 * b + a], plane[j, i, 4, 3 * b + a]
                    for k in range(n):
                        part[0, k + 1] += c0 * column[k]
                        part[1, k + 1] += c1 * column[k]
                        part[2, k + 1] += c2 * column[k]
                        part[3, k + 1] += c3 * column[k]
                        part[4, k + 1] += c4 * column[k]
            for k in range(n):
                total = 0.0
                for m in range(5):
                    total += (
                        vertical[m, 0, k] * part[m, k]
                        + vertical[m, 1, k] * part[m, k + 1]
                        + vertical[m, 2, k] * part[m, k + 2]
                    )
                y[j, i, k] = total


@njit(cache=True)
def _right_hand_side(
    h: Floats, lid: float, dx: float, dy: float, s: Floats, profile: Floats, step: float, u: float, v: float
) -> Floats:
    """−∫ u0·∇ψ dV at the inner nodes below the lid."""
    rows, columns, n = h.shape[0], h.shape[1], len(s) - 1
    out = np.zeros((rows, columns, n + 1))
    gauss = 0.5 / math.sqrt(3.0)
    for j in range(rows - 1):
        for i in range(columns - 1):
            for q in range(4):
                x = 0.5 + (gauss if q % 2 else -gauss)
                y = 0.5 + (gauss if q // 2 else -gauss)
                h0, h1, h2, h3 = h[j, i], h[j, i + 1], h[j + 1, i], h[j + 1, i + 1]
                height = (1 - y) * ((1 - x) * h0 + x * h1) + y * ((1 - x) * h2 + x * h3)
                p = ((1 - y) * (h1 - h0) + y * (h3 - h2)) / dx
                r = ((1 - x) * (h2 - h0) + x * (h3 - h1)) / dy
                depth, w = lid - height, 0.125 * dx * dy
                along = u * p + v * r
                for k in range(n):
                    ds = s[k + 1] - s[k]
                    for g in range(2):
                        t = 0.5 + (gauss if g else -gauss)
                        level = s[k] + t * ds
                        f = level * depth / step
                        m = min(int(f), len(profile) - 2)
                        speed = (profile[m] + (f - m) * (profile[m + 1] - profile[m])) * w * ds
                        for a in range(4):
                            fx, fy = (x if a % 2 else 1 - x), (y if a // 2 else 1 - y)
                            flat = depth * (
                                u * (1.0 if a % 2 else -1.0) / dx * fy + v * (1.0 if a // 2 else -1.0) / dy * fx
                            )
                            rise = along * (1 - level) * fx * fy / ds
                            column = out[j + a // 2, i + a % 2]
                            column[k] -= speed * (flat * (1 - t) + rise)
                            column[k + 1] -= speed * (flat * t - rise)
    out[0], out[rows - 1] = 0.0, 0.0
    out[:, 0], out[:, columns - 1] = 0.0, 0.0
    return out[:, :, :n].copy()


class _FlatSolver:
    """The operator over flat ground inverted, in single precision: the preconditioner."""

    def __init__(self, shape: tuple[int, int], dx: float, dy: float, depth: float, vertical: Floats) -> None:
        (stiff_y, mass_y), (stiff_x, mass_x) = (_line_spectra(n, d) for n, d in zip(shape, (dy, dx), strict=True))
        horizontal = depth * (stiff_y[:, None] * mass_x[None] + mass_y[:, None] * stiff_x[None])
        upward = mass_y[:, None] * mass_x[None] / depth
        scale = 4 * (shape[0] - 1) * (shape[1] - 1)  # of a sine transform there and back
        self._horizontal = (horizontal * scale).astype(np.float32)
        self._upward = (upward * scale).astype(np.float32)
        self._vertical = vertical.astype(np.float32)

    def __call__(self, r: Floats) -> Floats:
        inner: NDArray[np.float32] = dstn(r[1:-1, 1:-1].astype(np.float32), type=1, axes=(0, 1), overwrite_x=True)  # type: ignore[assignment]
        _thomas_columns(self._horizontal, self._upward, self._vertical, inner)
        inner = dstn(inner, type=1, axes=(0, 1), overwrite_x=True)
        out = np.zeros(r.shape)
        out[1:-1, 1:-1] = inner
        return out


def _line_spectra(nodes: int, d: float) -> tuple[Floats, Floats]:
    """Eigenvalues of the line's stiffness and mass matrices between fixed ends: sines diagonalise both."""
    c = np.cos(np.pi * np.arange(1, nodes - 1) / (nodes - 1))
    return 2 * (1 - c) / d, d * (2 + c) / 3


@njit(cache=True, fastmath=True)
def _thomas_columns(
    horizontal: NDArray[np.float32], upward: NDArray[np.float32], vertical: NDArray[np.float32], x: NDArray[np.float32]
) -> None:
    """Solve (horizontal·∫φφ + upward·∫φ'φ') x = x for every wave, in place."""
    rows, columns, n = x.shape
    upper = np.empty(n, dtype=np.float32)
    for j in range(rows):
        for i in range(columns):
            a, b = horizontal[j, i], upward[j, i]
            for k in range(n):
                low = a * vertical[0, 0, k] + b * vertical[4, 0, k]
                pivot = a * vertical[0, 1, k] + b * vertical[4, 1, k]
                value = x[j, i, k]
                if k > 0:
                    pivot -= low * upper[k - 1]
                    value -= low * x[j, i, k - 1]
                upper[k] = (a * vertical[0, 2, k] + b * vertical[4, 2, k]) / pivot
                x[j, i, k] = value / pivot
            for k in range(n - 2, -1, -1):
                x[j, i, k] -= upper[k] * x[j, i, k + 1]


@njit(cache=True, fastmath=True)
def _dot(a: Floats, b: Floats) -> float:
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total


@njit(cache=True, fastmath=True)
def _add(y: Floats, scale: float, x: Floats) -> None:
    """y += scale·x."""
    for k in range(len(y)):
        y[k] += scale * x[k]


@njit(cache=True, fastmath=True)
def _renew(p: Floats, beta: float, z: Floats) -> None:
    """p = z + beta·p."""
    for k in range(len(p)):
        p[k] = z[k] + beta * p[k]


def _conjugate_gradients(plane: Floats, vertical: Floats, r: Floats, solve_flat: _FlatSolver) -> tuple[Floats, int]:
    """Return the solution with the lid's zero level added, and the iterations; `r`, the right-hand side, is used up."""
    x, ax = np.zeros_like(r), np.zeros_like(r)
    flat = r.reshape(-1)
    start = math.sqrt(_dot(flat, flat))
    # Rounding of the right-hand side over flat ground, which is zero in exact arithmetic, is no flow.
    iterations, p, rz = 0, np.zeros_like(r), 1.0
    while start > 0 and iterations < 200 and math.sqrt(_dot(flat, flat)) > TOLERANCE * start:
        z = solve_flat(r)
        rz, before = _dot(flat, z.reshape(-1)), rz
        _renew(p.reshape(-1), rz / before if iterations else 0.0, z.reshape(-1))
        del z
        _apply(plane, vertical, p, ax)
        step = rz / _dot(p.reshape(-1), ax.reshape(-1))
        _add(x.reshape(-1), step, p.reshape(-1))
        _add(flat, -step, ax.reshape(-1))
        iterations += 1
    return np.concatenate([x, np.zeros((*x.shape[:2], 1))], axis=2), iterations


@njit(cache=True)
def _at_altitude(lam: Floats, levels: Floats, h: Floats, lid: float, altitude: float) -> Floats:
    """λ at one altitude: cubic interpolation in every column."""
    rows, columns = h.shape
    n = len(levels)
    out = np.empty((rows, columns))
    for j in range(rows):
        for i in range(columns):
            s = (altitude - h[j, i]) / (lid - h[j, i])
            k = min(max(np.searchsorted(levels, s) - 2, 0), n - 4) if n >= 4 else 0
            total = 0.0
            for a in range(k, min(k + 4, n)):
                weight = 1.0
                for b in range(k, min(k + 4, n)):
                    if b != a:
                        weight *= (s - levels[b]) / (levels[a] - levels[b])
                total += weight * lam[j, i, a]
            out[j, i] = total
    return out
