"""Newton steps of a path towards the free geodesic, without obstacles; those of flight times are in `newton_time`.

v0·C(σ) = length − (1/v0) ∫ w·dσ (paper, eq. moving_cost). By Stokes' theorem, moving a path sideways changes
∫ w·dσ by the vorticity ω of the strip between, so only ω enters. For a polyline x_0 … x_N with unit segments t_k
and unit normals n_k (left of the path), the derivative with respect to a sideways move y_k of node k is

    g_k = (t_k − t_{k+1})·n_k + (1/v0) ∫ hat_k(σ) ω(σ) (n_k·n) |dσ|,

whose root is the polyline twin of the free geodesic, curvature ω/v0. The Hessian is tridiagonal: one Thomas solve a
Newton step.
"""

from __future__ import annotations

import math

import numpy as np

from formulations.moving_cost.field import Bending, Vorticity, vorticity_at
from formulations.moving_cost.newton_terms import GAUSS_1, GAUSS_2, Terms
from formulations.moving_cost.newton_time import time_terms
from instances.arrays import Bools, Floats
from instances.kernels import njit


@njit(cache=True)
def newton_step(p: Floats, held: Bools, bending: Bending) -> tuple[Floats, Floats, Floats]:
    """Gradient g [1], normals and Newton offsets y [m] of the nodes of `p`; held nodes do not move."""
    normal = _normals(p)
    if bending.timed:
        terms = time_terms(p, normal, bending.wind, bending.speed)
    else:
        terms = energy_terms(p, normal, bending.vorticity, bending.speed)
    g, diagonal, bend, off, off_bend = terms
    y = np.zeros(len(p))
    if not _thomas(diagonal + bend, off + off_bend, g, held, y):
        # Not convex here: drop what the wind's change takes away from the rest's curvature.
        _thomas(diagonal + np.maximum(bend, 0.0), off, g, held, y)
    return g, normal, y


@njit(cache=True)
def _normals(p: Floats) -> Floats:
    """Return a unit normal, left of the path, at each node but the ends, where it is 0."""
    n = len(p)
    normal = np.zeros((n, 2))
    for k in range(1, n - 1):
        tx, ty = p[k + 1, 0] - p[k - 1, 0], p[k + 1, 1] - p[k - 1, 1]
        size = math.hypot(tx, ty)
        if size > 0.0:
            normal[k, 0], normal[k, 1] = -ty / size, tx / size
    return normal


@njit(cache=True)
def energy_terms(p: Floats, normal: Floats, field: Vorticity, v0: float) -> Terms:
    """Return the derivatives of v0·C of the polyline `p` by sideways moves of its nodes."""
    n = len(p)
    g, diagonal, bend, off, off_bend = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    for k in range(n - 1):
        dx, dy = p[k + 1, 0] - p[k, 0], p[k + 1, 1] - p[k, 1]
        h = math.hypot(dx, dy)
        tx, ty = dx / h, dy / h
        a = -normal[k, 0] * ty + normal[k, 1] * tx  # n_k·n of the segment
        b = -normal[k + 1, 0] * ty + normal[k + 1, 1] * tx
        g[k] -= tx * normal[k, 0] + ty * normal[k, 1]
        g[k + 1] += tx * normal[k + 1, 0] + ty * normal[k + 1, 1]
        diagonal[k] += a * a / h
        diagonal[k + 1] += b * b / h
        off[k] = -a * b / h
        for s in (GAUSS_1, GAUSS_2):
            w, wx, wy = vorticity_at(p[k, 0] + s * dx, p[k, 1] + s * dy, field)
            weight = 0.5 * h / v0
            g[k] += weight * (1 - s) * w * a
            g[k + 1] += weight * s * w * b
            slope = weight * (wy * tx - wx * ty)
            bend[k] += slope * (1 - s) * (1 - s) * a * a
            bend[k + 1] += slope * s * s * b * b
            off_bend[k] += slope * s * (1 - s) * a * b
    return Terms(g, diagonal, bend, off, off_bend)


@njit(cache=True)
def _thomas(diagonal: Floats, off: Floats, g: Floats, held: Bools, y: Floats) -> bool:
    """Solve the tridiagonal H y = −g over the nodes not held; False where H is not safely positive definite."""
    n = len(g)
    upper, right = np.zeros(n), np.zeros(n)
    for k in range(n):
        if held[k]:
            upper[k], right[k] = 0.0, 0.0
            continue
        below = off[k - 1] if k > 0 and not held[k - 1] else 0.0
        pivot = diagonal[k] - (below * upper[k - 1] if k > 0 else 0.0)
        if pivot < 0.02 * diagonal[k] or pivot <= 0.0:
            return False
        above = off[k] if k < n - 1 and not held[k + 1] else 0.0
        upper[k] = above / pivot
        right[k] = (-g[k] - (below * right[k - 1] if k > 0 else 0.0)) / pivot
    for k in range(n - 1, -1, -1):
        y[k] = right[k] - (upper[k] * y[k + 1] if k < n - 1 else 0.0)
    return True
