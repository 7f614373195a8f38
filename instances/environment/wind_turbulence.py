"""Stream-function turbulence: a seeded, divergence-free random wind.

w = (∂ψ/∂y, −∂ψ/∂x), ψ(x) = Σ_k a_k cos(k·x + p_k), with random directions and phases and wave numbers spread
over the scales from L to L/4; energy falls as |k|^(−5/3). After R. H. Kraichnan, Phys. Fluids 13
(1970). Every mode integrates along a straight segment in closed form:
∫ w·dσ = −a (k × d) · sin(k·m + p) · sinc(k·d/2), m the midpoint, d the segment.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.declared.winds import MOST_MODES
from instances.environment.wind import TableWind, ends_of, number, points_of
from instances.errors import InputError
from instances.extent import FINEST
from instances.kernels import njit


@njit(cache=True)
def _line_integrals(a: Floats, b: Floats, k: Floats, amplitude: Floats, phase: Floats) -> Floats:
    out = np.zeros(len(a))
    for i in range(len(a)):
        dx, dy = b[i, 0] - a[i, 0], b[i, 1] - a[i, 1]
        mx, my = 0.5 * (a[i, 0] + b[i, 0]), 0.5 * (a[i, 1] + b[i, 1])
        for j in range(len(k)):
            half = 0.5 * (k[j, 0] * dx + k[j, 1] * dy)
            sinc = np.sin(half) / half if abs(half) > 1e-4 else 1.0 - half * half / 6.0
            cross = k[j, 0] * dy - k[j, 1] * dx
            out[i] += amplitude[j] * cross * np.sin(k[j, 0] * mx + k[j, 1] * my + phase[j]) * sinc
    return out


@dataclass(frozen=True)
class Turbulence(TableWind):
    """Random wind of `rms` speed [m/s] and largest eddy size `length_scale` L [m], from `seed`, with `modes` waves."""

    kind = "turbulence"
    rms: float
    length_scale: float
    seed: int = 0
    modes: int = 48

    def __post_init__(self) -> None:
        object.__setattr__(self, "rms", number(self.rms, "rms [m/s]"))
        object.__setattr__(self, "length_scale", number(self.length_scale, "length_scale [m]"))
        if self.rms < 0 or self.length_scale < FINEST or not 1 <= self.modes <= MOST_MODES:
            raise InputError(f"wind: turbulence needs rms ≥ 0, length_scale ≥ {FINEST:g} m and 1 to {MOST_MODES} modes")

    @cached_property
    def _waves(self) -> tuple[Floats, Floats, Floats]:
        """Wave vectors (k, 2) [rad/m], amplitudes of ψ [m²/s], phases."""
        rng = np.random.default_rng(self.seed)
        size = 2 * np.pi / self.length_scale * np.exp(rng.uniform(0, np.log(4), self.modes))
        angle = rng.uniform(0, 2 * np.pi, self.modes)
        # Log-uniform wave numbers carry a weight |k|; the energy of a wave is a²k²/2.
        energy = (size * self.length_scale) ** (-5 / 3) * size
        speed = np.sqrt(2 * energy / energy.sum()) * self.rms
        k = size[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        return k, speed / size, rng.uniform(0, 2 * np.pi, self.modes)

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        k, amplitude, phase = self._waves
        slope = -amplitude * np.sin(points_of(points) @ k.T + phase)  # ∂ψ/∂(k·x)
        return np.column_stack([slope @ k[:, 1], -slope @ k[:, 0]])

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b`."""
        return _line_integrals(*ends_of(a, b), *self._waves)
