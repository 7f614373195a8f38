"""Radio propagation: free space, diffraction over terrain, and shadowing.

Free space (paper, §RF Signal Intensity Data): P_L = −10 log₁₀ (G λ² / (4πd)²) dB.

Diffraction: the Bullington construction of Recommendation ITU-R P.526 (§ "Complete method for a general terrain
path", Bullington part). Terrain between the terminals, raised by the bulge of an Earth of effective radius a_e,
is replaced by one knife edge where the two horizon lines meet; with ν its diffraction parameter,

    J(ν) = 6.9 + 20 log₁₀(√((ν − 0.1)² + 1) + ν − 0.1) dB for ν > −0.78, else 0
    L    = J + (1 − exp(−J/6)) (10 + 0.02 d),   d in km

Irregular Terrain Model: the accurate one, in the folder ``itm``.

Shadowing: log-normal, that is Gaussian in dB, with correlation exp(−d/D) (M. Gudmundson, Electronics Letters 27(23),
1991), drawn on the grid by circulant embedding.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from instances.arrays import Floats
from instances.environment.itm.loss import attenuation_map
from instances.environment.radio import RadioMap, RadioSource
from instances.environment.terrain import Terrain
from instances.environment.terrain_profile import profile
from instances.errors import InputError, suggestion
from instances.kernels import njit

EFFECTIVE_EARTH = 4.0 / 3.0 * 6_371_000.0
"""a_e [m] for the median refractivity gradient."""

MODELS = ("diffraction", "free-space", "itm")

Model = Literal["diffraction", "free-space", "itm"]


@njit(cache=True)
def knife_edge(v: float) -> float:
    """Return J(ν), the loss [dB] of one knife edge."""
    if v <= -0.78:
        return 0.0
    return 6.9 + 20.0 * math.log10(math.sqrt((v - 0.1) ** 2 + 1.0) + v - 0.1)


@njit(cache=True)
def bullington(heights: Floats, step: float, transmitter: float, receiver: float, wavelength: float) -> float:
    """Return the diffraction loss [dB] along a profile.

    heights : terrain [m] at equal distances of `step` [m], the terminals' own ground first and last, shape (k,).
    transmitter, receiver : antenna heights [m] above sea level.
    """
    k = len(heights)
    d = step * (k - 1)
    if k < 3 or d <= 0.0:
        return 0.0
    slope = (receiver - transmitter) / d
    up_t, up_r, v_sight = -math.inf, -math.inf, -math.inf
    for i in range(1, k - 1):
        d1, d2 = step * i, d - step * i
        h = heights[i] + d1 * d2 / (2.0 * EFFECTIVE_EARTH)
        up_t = max(up_t, (h - transmitter) / d1)
        up_r = max(up_r, (h - receiver) / d2)
        clearance = h - (transmitter * d2 + receiver * d1) / d
        v_sight = max(v_sight, clearance * math.sqrt(2.0 * d / (wavelength * d1 * d2)))
    v = v_sight
    if up_t >= slope:  # the terrain cuts the line of sight: one edge where the horizon lines meet
        at = (receiver - transmitter + up_r * d) / (up_t + up_r)
        clearance = transmitter + up_t * at - (transmitter * (d - at) + receiver * at) / d
        v = clearance * math.sqrt(2.0 * d / (wavelength * at * (d - at)))
    loss = knife_edge(v)
    return loss + (1.0 - math.exp(-loss / 6.0)) * (10.0 + 0.02 * d / 1000.0)


@njit(cache=True)
def _diffraction_map(
    ground: Floats, x0: float, y0: float, dx: float, dy: float,
    ax: float, ay: float, mast: float, xs: Floats, ys: Floats, altitude: Floats, wavelength: float,
) -> Floats:  # fmt: skip
    out = np.empty((len(ys), len(xs)))
    for j in range(len(ys)):
        for i in range(len(xs)):
            heights = profile(ground, x0, y0, dx, dy, ax, ay, xs[i], ys[j], min(dx, dy))
            step = math.hypot(xs[i] - ax, ys[j] - ay) / (len(heights) - 1)
            out[j, i] = bullington(heights, step, mast, altitude[j, i], wavelength)
    return out


def free_space_loss(distance: Floats, wavelength: float) -> Floats:
    """Return 20 log₁₀(4πd/λ) [dB] at `distance` [m], without the antennas' gains."""
    return np.asarray(20.0 * np.log10(4.0 * np.pi * np.maximum(distance, wavelength) / wavelength))


def shadowing(
    shape: tuple[int, int], spacing: tuple[float, float], sd: float, decorrelation: float, seed: int
) -> Floats:
    """Return a Gaussian field [dB] of standard deviation `sd` and correlation exp(−d/`decorrelation`) on a grid.

    shape (ny, nx); spacing (dx, dy) [m]; decorrelation [m]. Drawn on a torus twice as long each way; the little
    negative power that the embedding of an exponential can have is dropped.
    """
    ny, nx = shape
    lag_y, lag_x = (np.minimum(np.arange(2 * k), 2 * k - np.arange(2 * k)) for k in (ny, nx))
    distance = np.hypot.outer(lag_y * spacing[1], lag_x * spacing[0])
    power = np.maximum(np.fft.fft2(np.exp(-distance / decorrelation)).real, 0.0)
    noise = np.random.default_rng(seed).standard_normal(power.shape)
    field = np.fft.ifft2(np.fft.fft2(noise) * np.sqrt(power)).real
    return np.asarray(sd * field[:ny, :nx])


def radio_map(
    source: RadioSource,
    bounds: tuple[float, float, float, float],
    terrain: Terrain | None = None,
    *,
    altitude: float = 3000.0,
    above_ground: bool = False,
    model: Model = "diffraction",
    shadowing_sd: float = 4.0,
    decorrelation: float = 2000.0,
    seed: int = 0,
    cells: int = 200,
) -> RadioMap:
    """Return the signal at `altitude` [m above sea level, or above the ground] over `bounds` (x0, y0, x1, y1) [m].

    terrain : the ground, flat at 0 m where None. shadowing_sd [dB], 0 for none; decorrelation [m]; cells : along the
    longer side. The Irregular Terrain Model's own median excess takes the place of the diffraction loss; add shadowing
    for what it leaves out. Raises InputError where the altitude is below ground or a value makes no sense.
    """
    if model not in MODELS:
        raise InputError(f"unknown propagation model '{model}'{suggestion(model, MODELS)} (known: {', '.join(MODELS)})")
    x0, y0, x1, y1 = bounds
    if not (x1 > x0 and y1 > y0 and cells >= 2 and shadowing_sd >= 0 and decorrelation > 0):
        raise InputError("radio map: bounds, cells, shadowing_sd and decorrelation must be positive")
    size = max(x1 - x0, y1 - y0) / cells
    xs = np.linspace(x0, x1, max(2, round((x1 - x0) / size)) + 1)
    ys = np.linspace(y0, y1, max(2, round((y1 - y0) / size)) + 1)
    ground = terrain or Terrain((x0, y0), (x1 - x0, y1 - y0), np.zeros((2, 2)))
    highest = float(ground.height.max())
    if altitude <= 0.0 and above_ground:
        raise InputError(f"radio map: the altitude above the ground must be positive, got {altitude:g} m")
    if altitude <= highest and not above_ground:
        raise InputError(f"radio map: the altitude ({altitude:g} m) must be above the terrain (up to {highest:g} m)")
    nodes = np.stack(np.meshgrid(xs, ys), axis=-1)
    level = np.full(nodes.shape[:2], altitude)
    receiver = level + ground(nodes).reshape(level.shape) if above_ground else level
    ax, ay = source.position
    mast = float(ground([[ax, ay]])[0]) + source.height
    distance = np.sqrt(np.add.outer((ys - ay) ** 2, (xs - ax) ** 2) + (receiver - mast) ** 2)
    sent = source.power_dbm + source.transmitter_gain_dbi + source.receiver_gain_dbi
    signal = sent - free_space_loss(distance, source.wavelength)
    if model == "diffraction":
        grid = (ground.height, *ground.origin, *ground.spacing)
        signal -= _diffraction_map(*grid, ax, ay, mast, xs, ys, receiver, source.wavelength)
    if model == "itm":
        signal -= attenuation_map(ground, source.position, source.height, (xs, ys), receiver, source.frequency)
    if shadowing_sd > 0:
        signal += shadowing(
            (len(ys), len(xs)), (float(xs[1] - xs[0]), float(ys[1] - ys[0])), shadowing_sd, decorrelation, seed
        )
    return RadioMap(xs, ys, signal)
