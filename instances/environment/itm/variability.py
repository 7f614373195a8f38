"""Variability of the Irregular Terrain Model: quantiles over time, locations and situations [Alg, §5].

Curves of [TN101, eqs. III.69, III.70] and constants of [Alg, Table 5.1], for the seven radio climates: equatorial,
continental subtropical, maritime subtropical, desert, continental temperate, maritime temperate over land and over sea.
"""

from __future__ import annotations

import math

import numpy as np

from instances.kernels import njit

CLIMATES = (
    "equatorial",
    "continental-subtropical",
    "maritime-subtropical",
    "desert",
    "continental-temperate",
    "maritime-temperate-land",
    "maritime-temperate-sea",
)

# Rows: c1, c2, x1, x2, x3 of each curve [dB, dB, m, m, m]; columns: climates.
_MEDIAN = np.array(
    [
        [-9.67, -0.62, 1.26, -9.21, -0.62, -0.39, 3.15],
        [12.7, 9.19, 15.5, 9.05, 9.19, 2.86, 857.9],
        [144.9e3, 228.9e3, 262.6e3, 84.1e3, 228.9e3, 141.7e3, 2222e3],
        [190.3e3, 205.2e3, 185.2e3, 101.1e3, 205.2e3, 315.9e3, 164.8e3],
        [133.8e3, 143.6e3, 99.8e3, 98.6e3, 143.6e3, 167.4e3, 116.3e3],
    ]
)
_LOW = np.array(
    [
        [2.13, 2.66, 6.11, 1.98, 2.68, 6.86, 8.51],
        [159.5, 7.67, 6.65, 13.11, 7.16, 10.38, 169.8],
        [762.2e3, 100.4e3, 138.2e3, 139.1e3, 93.7e3, 187.8e3, 609.8e3],
        [123.6e3, 172.5e3, 242.2e3, 132.7e3, 186.8e3, 169.6e3, 119.9e3],
        [94.5e3, 136.4e3, 178.6e3, 193.5e3, 133.5e3, 108.9e3, 106.6e3],
    ]
)
_HIGH = np.array(
    [
        [2.11, 6.87, 10.08, 3.68, 4.75, 8.58, 8.43],
        [102.3, 15.53, 9.60, 159.3, 8.12, 13.97, 8.19],
        [636.9e3, 138.7e3, 165.3e3, 464.4e3, 93.2e3, 216.0e3, 136.2e3],
        [134.8e3, 143.7e3, 225.7e3, 93.1e3, 135.9e3, 152.0e3, 188.5e3],
        [95.6e3, 98.6e3, 129.7e3, 94.2e3, 113.4e3, 122.7e3, 122.9e3],
    ]
)
# Frequency gain 1 … of the low and high side, then C_D and z_D of the tail.
_GAIN_LOW = np.array([[1.0, 1.0, 1.0, 1.0, 0.92, 1.0, 1.0], [0, 0, 0, 0, 0.25, 0, 0], [0, 0, 0, 0, 1.77, 0, 0]])
_GAIN_HIGH = np.array(
    [[1.0, 0.93, 1.0, 0.93, 0.93, 1.0, 1.0], [0, 0.31, 0, 0.19, 0.31, 0, 0], [0, 2.00, 0, 1.79, 2.00, 0, 0]]
)
_TAIL = np.array([[1.224, 0.801, 1.380, 1.000, 1.224, 1.518, 1.518], [1.282, 2.161, 1.282, 20.0, 1.282, 1.282, 1.282]])


@njit(cache=True)
def _curve(table: np.ndarray, climate: int, d: float) -> float:
    c1, c2, x1 = table[0, climate], table[1, climate], table[2, climate]
    x2, x3 = table[3, climate], table[4, climate]
    near = (d / x1) ** 2
    return (c1 + c2 / (1.0 + ((d - x2) / x3) ** 2)) * near / (1.0 + near)


@njit(cache=True)
def _gain(table: np.ndarray, climate: int, q: float) -> float:
    return table[0, climate] + table[1, climate] / ((table[2, climate] * q) ** 2 + 1.0)


@njit(cache=True)
def deviate(share: float) -> float:
    """Return z with P(Z > z) = `share`, by Abramowitz & Stegun 26.2.23 (error < 4.5e-4) as prescribed."""
    x = min(share, 1.0 - share)
    t = math.sqrt(-2.0 * math.log(x))
    top = (0.010328 * t + 0.802853) * t + 2.515516
    z = t - top / (((0.001308 * t + 0.189269) * t + 1.432788) * t + 1.0)
    return -z if share > 0.5 else z


@njit(cache=True)
def quantile_loss(
    attenuation: float, d: float, he1: float, he2: float, rough: float, f: float, climate: int,
    time: float, location: float, situation: float, mode: int, no_location: bool, no_situation: bool,
) -> float:  # fmt: skip
    """Return the attenuation [dB] not exceeded for the given shares (0 to 1) of time, locations and situations.

    attenuation : reference value [dB]; d [m]; he1, he2 : effective heights [m]; rough : Δh(d) [m]; f [MHz];
    climate : 0 to 6; mode : 0 single message, 1 accidental, 2 mobile, 3 broadcast; no_location, no_situation : leave
    that variability out.
    """
    wave = f / 47.7
    reach = math.sqrt(2.0 * 9000e3 * he1) + math.sqrt(2.0 * 9000e3 * he2) + (575.7e12 / wave) ** (1.0 / 3.0)
    effective = 130e3 * d / reach if d < reach else 130e3 + d - reach
    z_s = deviate(situation)
    z_t = z_s if mode == 0 else deviate(time)
    z_l = z_s if mode <= 1 else z_t if mode == 2 else deviate(location)
    sd_s = 0.0 if no_situation else 5.0 + 3.0 * math.exp(-effective / 100e3)
    sd_l = 0.0 if no_location else 10.0 * wave * rough / (wave * rough + 13.0)
    q = math.log(0.133 * wave)
    low = _curve(_LOW, climate, effective) * _gain(_GAIN_LOW, climate, q)
    high = _curve(_HIGH, climate, effective) * _gain(_GAIN_HIGH, climate, q)
    tail, z_tail = _TAIL[0, climate] * high, _TAIL[1, climate]
    sd_t = low if z_t < 0.0 else high if z_t <= z_tail else tail + (high - tail) * z_tail / z_t
    y_t, y_l = sd_t * z_t, sd_l * z_l
    rest = sd_s**2 + y_t**2 / (7.8 + z_s**2) + y_l**2 / (24.0 + z_s**2)
    if mode == 0:
        sure, unsure = 0.0, math.sqrt(sd_t**2 + sd_l**2 + rest) * z_s
    elif mode == 1:
        sure, unsure = y_t, math.sqrt(sd_l**2 + rest) * z_s
    elif mode == 2:
        sure, unsure = math.sqrt(sd_t**2 + sd_l**2) * z_t, math.sqrt(rest) * z_s
    else:
        sure, unsure = y_t + y_l, math.sqrt(rest) * z_s
    result = attenuation - _curve(_MEDIAN, climate, effective) - sure - unsure
    if result < 0.0:
        result *= (29.0 - result) / (29.0 - 10.0 * result)
    return result
