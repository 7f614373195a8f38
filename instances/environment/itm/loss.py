"""Basic transmission loss of the Irregular Terrain Model, of one path and of a map.

Loss = free space + attenuation not exceeded for given shares of time, locations and situations. The Earth's effective
curvature follows from the surface refractivity N_s = N_0 exp(−h/9460 m): γ_e = 157e-9 (1 − 0.04665 exp(N_s/179.3)) 1/m
[TN101, eqs. 4.3, 4.4].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.itm.attenuation import ground_impedance, reference_attenuation
from instances.environment.itm.profile import roughness, terrain_parameters
from instances.environment.itm.variability import CLIMATES, quantile_loss
from instances.environment.terrain import Terrain
from instances.environment.terrain_profile import profile
from instances.errors import InputError, suggestion
from instances.kernels import njit

MODES = ("single-message", "accidental", "mobile", "broadcast")


@dataclass(frozen=True)
class Propagation:
    """What the model assumes of ground, air and statistics; the defaults are those of average ground.

    permittivity : ε_r of the ground; conductivity [S/m]; refractivity N_0 at sea level [N-units], 250 to 400;
    vertical : polarisation; climate : one of ``variability.CLIMATES``; time, location, situation : shares in (0, 1);
    mode : one of MODES; location_variability, situation_variability : whether they count.
    """

    permittivity: float = 15.0
    conductivity: float = 0.005
    refractivity: float = 301.0
    vertical: bool = True
    climate: str = "continental-temperate"
    time: float = 0.5
    location: float = 0.5
    situation: float = 0.5
    mode: str = "broadcast"
    location_variability: bool = True
    situation_variability: bool = True

    def __post_init__(self) -> None:
        for key, known in (("climate", CLIMATES), ("mode", MODES)):
            value = getattr(self, key)
            if value not in known:
                raise InputError(f"itm: unknown {key} '{value}'{suggestion(str(value), known)}")
        for key in ("time", "location", "situation"):
            if not 0.0 < getattr(self, key) < 1.0:
                raise InputError(f"itm: {key} must lie between 0 and 1, got {getattr(self, key)}")
        if not (self.permittivity >= 1 and self.conductivity > 0 and 250 <= self.refractivity <= 400):
            raise InputError("itm: permittivity ≥ 1, conductivity > 0 and refractivity from 250 to 400 are needed")


@njit(cache=True)
def _attenuation(
    heights: Floats, step: float, h1: float, h2: float, f: float, z: complex, refractivity: float,
    climate: int, time: float, location: float, situation: float, mode: int, no_location: bool, no_situation: bool,
) -> float:  # fmt: skip
    last = len(heights) - 1
    tenth = int(0.1 * last)
    surface = refractivity * math.exp(-heights[tenth : last - tenth + 1].mean() / 9460.0)
    earth = 1.0 / (157e-9 * (1.0 - 0.04665 * math.exp(surface / 179.3)))
    path = terrain_parameters(heights, step, earth, h1, h2)
    d = last * step
    reference = reference_attenuation(d, path, (h1, h2), earth, surface, f, z)
    _, _, _, _, he1, he2, irregular = path
    return quantile_loss(
        reference, d, he1, he2, roughness(d, irregular), f, climate,
        time, location, situation, mode, no_location, no_situation,
    )  # fmt: skip


def _settings(assumed: Propagation) -> tuple[Any, ...]:
    return (
        assumed.refractivity,
        CLIMATES.index(assumed.climate),
        assumed.time,
        assumed.location,
        assumed.situation,
        MODES.index(assumed.mode),
        not assumed.location_variability,
        not assumed.situation_variability,
    )


def path_loss(
    heights: ArrayLike,
    step: float,
    transmitter: float,
    receiver: float,
    frequency: float,
    assumed: Propagation | None = None,
) -> float:
    """Return the basic transmission loss [dB] along a terrain profile.

    heights : terrain [m above sea level] at equal distances of `step` [m], terminal to terminal, shape (k,), k ≥ 3.
    transmitter, receiver : antenna heights above ground [m], 0.5 to 3000; frequency [Hz], 20 MHz to 20 GHz.
    """
    assumed = assumed or Propagation()
    ground = np.ascontiguousarray(heights, dtype=np.float64)
    f = frequency / 1e6
    if ground.ndim != 1 or len(ground) < 3 or not np.isfinite(ground).all() or not step > 0:
        raise InputError("itm: a profile needs at least 3 finite heights [m] and a positive step [m]")
    if not (20.0 <= f <= 20_000.0):
        raise InputError(f"itm: the frequency must be 20 MHz to 20 GHz, got {f:g} MHz")
    if not (0.5 <= transmitter <= 3000.0 and 0.5 <= receiver <= 3000.0):
        raise InputError(f"itm: antennas must be 0.5 to 3000 m above ground, got {transmitter:g} and {receiver:g} m")
    z = ground_impedance(f, assumed.permittivity, assumed.conductivity, assumed.vertical)
    free_space = 32.45 + 20.0 * math.log10(f) + 20.0 * math.log10(step * (len(ground) - 1) / 1000.0)
    return free_space + float(_attenuation(ground, step, transmitter, receiver, f, z, *_settings(assumed)))


@njit(cache=True)
def _map(
    ground: Floats, x0: float, y0: float, dx: float, dy: float, ax: float, ay: float, mast: float,
    xs: Floats, ys: Floats, altitude: Floats, f: float, z: complex, refractivity: float,
    climate: int, time: float, location: float, situation: float, mode: int, no_location: bool, no_situation: bool,
) -> Floats:  # fmt: skip
    out = np.zeros((len(ys), len(xs)))
    for j in range(len(ys)):
        for i in range(len(xs)):
            heights = profile(ground, x0, y0, dx, dy, ax, ay, xs[i], ys[j], min(dx, dy))
            if len(heights) < 3:
                continue  # straight above the mast: free space
            step = math.hypot(xs[i] - ax, ys[j] - ay) / (len(heights) - 1)
            out[j, i] = _attenuation(
                heights, step, mast, altitude[j, i] - heights[-1], f, z, refractivity,
                climate, time, location, situation, mode, no_location, no_situation,
            )  # fmt: skip
    return out


def attenuation_map(
    terrain: Terrain,
    position: tuple[float, float],
    mast: float,
    nodes: tuple[Floats, Floats],
    altitude: Floats,
    frequency: float,
    assumed: Propagation | None = None,
) -> Floats:
    """Return the attenuation [dB] beyond free space from a mast to every node of a grid, shape (ny, nx).

    position, nodes (xs, ys) [m]; mast : height above ground [m]; altitude : of the receiver at each node above sea
    level [m], shape (ny, nx); frequency [Hz]. The model is meant for path distances above about 1 km and grazing
    angles below 0.2 rad; nearer to the mast it is what NTIA's reference computes, too, with a warning.
    """
    assumed = assumed or Propagation()
    f = frequency / 1e6
    z = ground_impedance(f, assumed.permittivity, assumed.conductivity, assumed.vertical)
    grid = (terrain.height, *terrain.origin, *terrain.spacing)
    return np.asarray(_map(*grid, *position, mast, *nodes, altitude, f, z, *_settings(assumed)))
