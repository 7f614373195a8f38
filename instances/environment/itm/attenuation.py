"""Reference attenuation of the Irregular Terrain Model: the median loss beyond free space [dB].

Three regions in distance: line of sight (two rays blended with extended diffraction), diffraction (knife edges
blended with a smooth Earth, after Vogler 1964) and forward scatter by the troposphere. A path is the tuple
(θ₁, θ₂, d₁, d₂, h_e1, h_e2, Δh) of ``profile.terrain_parameters``; `f` is in MHz, `z` the ground's impedance.
"""

from __future__ import annotations

import cmath
import math

from instances.environment.itm.profile import roughness
from instances.kernels import njit

Path = tuple[float, float, float, float, float, float, float]

WAVE = 47.7
"""f [MHz] / 47.7 is the wave number [1/m]."""

EARTH = 6_370_000.0
"""Radius the smooth-Earth curves are normalised by [m]."""


@njit(cache=True)
def _fresnel(v2: float) -> float:
    """Knife-edge loss by ν² [TN101, eqs. III.24b, c]."""
    if v2 < 5.76:
        return 6.02 + 9.11 * math.sqrt(v2) - 1.27 * v2
    return 12.953 + 10.0 * math.log10(v2)


@njit(cache=True)
def _height_gain(x: float, k: float) -> float:
    """Vogler's height function F(x, K) [Alg, §6]."""
    if x < 200.0:
        w = -math.log(k)
        if k < 1e-5 or x * w**3 > 5495.0:
            return 17.372 * math.log(x) - 117.0 if x > 1.0 else -117.0
        return 2.5e-5 * x * x / k - 8.686 * w - 15.0
    far = 0.05751 * x - 4.343 * math.log(x)
    if x < 2000.0:
        w = 0.0134 * x * math.exp(-0.005 * x)
        far = (1.0 - w) * far + w * (17.372 * math.log(x) - 117.0)
    return far


@njit(cache=True)
def _smooth_parameters(radius: float, f: float, z: complex) -> tuple[float, float]:
    """Vogler's K and the factor that normalises a distance [km] on a sphere of `radius` [m]."""
    c = (4.0 / 3.0 * EARTH / radius) ** (1.0 / 3.0)
    k = 0.017778 * c * f ** (-1.0 / 3.0) / abs(z)
    return k, (1.607 - k) * c * c * f ** (1.0 / 3.0)


@njit(cache=True)
def _smooth_earth(d: float, path: Path, earth: float, sight: float, f: float, z: complex) -> float:
    """Smooth-Earth diffraction by Vogler's three radii [Alg, eq. 4.20]."""
    _, _, d1, d2, he1, he2, _ = path
    beyond = d / earth - sight
    middle = (d - d1 - d2) / beyond
    _, scale0 = _smooth_parameters(middle, f, z)
    k1, scale1 = _smooth_parameters(0.5 * d1 * d1 / he1, f, z)
    k2, scale2 = _smooth_parameters(0.5 * d2 * d2 / he2, f, z)
    x1, x2 = scale1 * d1 / 1000.0, scale2 * d2 / 1000.0
    x0 = scale0 * middle * beyond / 1000.0 + x1 + x2
    return 0.05751 * x0 - 10.0 * math.log10(x0) - _height_gain(x1, k1) - _height_gain(x2, k2) - 20.0


@njit(cache=True)
def _knife_edges(d: float, path: Path, earth: float, sight: float, f: float) -> float:
    """Two knife edges at the horizons [TN101, eqs. I.1, I.7]."""
    _, _, d1, d2, _, _, _ = path
    beyond, gap = d / earth - sight, d - d1 - d2
    factor = 0.0795775 * (f / WAVE) * beyond * beyond * gap
    return _fresnel(factor * d1 / (gap + d1)) + _fresnel(factor * d2 / (gap + d2))


@njit(cache=True)
def _clutter_height(d: float, irregular: float) -> float:
    """Terrain standard deviation σ_h [m] in the first Fresnel zone [ERL79, eq. 3.6a]."""
    rough = roughness(d, irregular)
    return 0.78 * rough * math.exp(-0.5 * rough**0.25)


@njit(cache=True)
def _diffraction(
    d: float, path: Path, h: tuple[float, float], earth: float, sight: float, f: float, z: complex
) -> float:
    """Diffraction loss at distance d: edges and smooth Earth, weighted by the terrain's roughness."""
    _, _, d1, d2, he1, he2, irregular = path
    smooth_sight = math.sqrt(2.0 * he1 * earth) + math.sqrt(2.0 * he2 * earth)
    clutter = 1e-5 * h[0] * h[1] * f * _clutter_height(smooth_sight, irregular)
    q = h[0] * h[1] + 10.0  # low antennas with known paths [ERL79, p. 3-8]
    ratio = 1.0 + (he1 * he2 - h[0] * h[1]) / q
    wave = min(roughness(d, irregular) * f / WAVE, 6283.2)
    q = (math.sqrt(ratio) + (d1 + d2 - sight * earth) / d) * wave
    w = 25.1 / (25.1 + math.sqrt(q))  # [ERL79, eq. 3.23]
    loss = w * _smooth_earth(d, path, earth, sight, f, z) + (1.0 - w) * _knife_edges(d, path, earth, sight, f)
    return loss + min(15.0, 5.0 * math.log10(1.0 + clutter))


@njit(cache=True)
def _line_of_sight(d: float, path: Path, smooth_sight: float, slope: float, zero: float, f: float, z: complex) -> float:
    """Loss in sight at distance d: direct and reflected ray, blended with the diffraction line [Alg, 4.46–50]."""
    _, _, _, _, he1, he2, irregular = path
    grazing = (he1 + he2) / math.sqrt(d * d + (he1 + he2) ** 2)
    wave = f / WAVE
    reflected = (grazing - z) / (grazing + z) * math.exp(-min(10.0, wave * _clutter_height(d, irregular) * grazing))
    q = reflected.real**2 + reflected.imag**2
    if q < 0.25 or q < grazing:
        reflected = reflected * math.sqrt(grazing / q)
    phase = wave * 2.0 * he1 * he2 / d
    if phase > math.pi / 2.0:
        phase = math.pi - (math.pi / 2.0) ** 2 / phase
    both = complex(math.cos(phase), -math.sin(phase)) + reflected
    two_rays = -10.0 * math.log10(both.real**2 + both.imag**2)
    w = 1.0 / (1.0 + f * irregular / max(10e3, smooth_sight))
    return w * two_rays + (1.0 - w) * (slope * d + zero)


@njit(cache=True)
def _frequency_gain(r: float, efficiency: float) -> float:
    """H₀(r, η) [Alg, eq. 6.13], interpolated between the curves of whole η from 1 to 5."""
    a = (25.0, 80.0, 177.0, 395.0, 705.0)
    b = (24.0, 45.0, 68.0, 80.0, 105.0)
    eta = min(max(efficiency, 1.0), 5.0)
    i = int(eta)
    q = eta - i
    gain = 10.0 * math.log10(1.0 + a[i - 1] / r**4 + b[i - 1] / r**2)
    if q != 0.0:
        gain = (1.0 - q) * gain + q * 10.0 * math.log10(1.0 + a[i] / r**4 + b[i] / r**2)
    return gain


@njit(cache=True)
def _scatter(
    d: float, path: Path, earth: float, sight: float, refractivity: float, f: float, before: float
) -> tuple[float, float]:
    """Troposcatter loss at distance d [Alg, eq. 4.63] and its H₀; `before` is H₀ at the farther distance, or −1."""
    t1, t2, d1, d2, he1, he2, _ = path
    wave = f / WAVE
    gain = before
    if before <= 15.0:
        offset, ratio = d1 - d2, he2 / he1
        if offset < 0.0:
            offset, ratio = -offset, 1.0 / ratio
        angle = t1 + t2 + d / earth
        r1, r2 = 2.0 * wave * angle * he1, 2.0 * wave * angle * he2
        if r1 < 0.2 and r2 < 0.2:
            return 1001.0, before  # not defined here [Alg, p. 11]
        s = (d - offset) / (d + offset)
        q = min(max(0.1, ratio / s), 10.0)
        s = max(0.1, s)
        crossing = (d - offset) * (d + offset) * angle * 0.25 / d
        air = 0.031 - refractivity * 2.32e-3 + refractivity**2 * 5.67e-6
        eta = crossing / 1.7556e3 * (1.0 + air * math.exp(-(min(1.7, crossing / 8.0e3) ** 6)))
        mean = 0.5 * (_frequency_gain(r1, eta) + _frequency_gain(r2, eta))
        change = min(mean, 6.0 * (0.6 - math.log10(max(eta, 1.0))) * math.log10(s) * math.log10(q))
        gain = max(mean + change, 0.0)
        if eta < 1.0:
            root = math.sqrt(2.0)
            low = ((1.0 + root / r1) * (1.0 + root / r2)) ** 2 * (r1 + r2) / (r1 + r2 + 2.0 * root)
            gain = eta * gain + (1.0 - eta) * 10.0 * math.log10(low)
        if gain > 15.0 and before >= 0.0:
            gain = before
    bend = d / earth - sight
    x = bend * d
    if x <= 10e3:
        decay = 133.4 + 0.332e-3 * x - 10.0 * math.log10(x)
    elif x <= 70e3:
        decay = 104.6 + 0.212e-3 * x - 2.5 * math.log10(x)
    else:
        decay = 71.8 + 0.157e-3 * x + 5.0 * math.log10(x)
    loss = decay + 10.0 * math.log10(wave * WAVE * bend**4) - 0.1 * (refractivity - 301.0) * math.exp(-x / 40e3) + gain
    return loss, gain


@njit(cache=True)
def ground_impedance(f: float, permittivity: float, conductivity: float, vertical: bool) -> complex:
    """Return the ground's transfer impedance Z_g for relative permittivity ε and conductivity σ [S/m]."""
    e = complex(permittivity, 18_000.0 * conductivity / f)
    z = cmath.sqrt(e - 1.0)
    return z / e if vertical else z


@njit(cache=True)
def reference_attenuation(
    d: float, path: Path, h: tuple[float, float], earth: float, refractivity: float, f: float, z: complex
) -> float:
    """Return the reference attenuation [dB] beyond free space, ≥ 0, of a path of d metres.

    path : ``terrain_parameters``; h : antenna heights above ground [m]; earth : effective radius [m];
    refractivity : N_s at the surface [N-units].
    """
    t1, t2, d1, d2, he1, he2, _ = path
    smooth_sight = math.sqrt(2.0 * he1 * earth) + math.sqrt(2.0 * he2 * earth)
    horizon = d1 + d2
    sight = -max(t1 + t2, -horizon / earth)
    scale = (earth * earth / f) ** (1.0 / 3.0)
    # the diffraction loss is a line through two points far beyond the horizon
    d3 = max(smooth_sight, horizon + 5.0 * scale)
    d4 = d3 + 10.0 * scale
    a3 = _diffraction(d3, path, h, earth, sight, f, z)
    slope = (_diffraction(d4, path, h, earth, sight, f, z) - a3) / (d4 - d3)
    zero = a3 - slope * d3
    if d < smooth_sight:
        loss = _in_sight(d, path, smooth_sight, slope, zero, f, z)
    else:
        a6, gain = _scatter(horizon + 400e3, path, earth, sight, refractivity, f, -1.0)
        a5, _ = _scatter(horizon + 200e3, path, earth, sight, refractivity, f, gain)
        loss = slope * d + zero
        if a5 < 1000.0:
            scatter_slope = (a6 - a5) / 200e3
            meet = (a5 - zero - scatter_slope * (horizon + 200e3)) / (slope - scatter_slope)
            change = max(smooth_sight, horizon + 1.088 * scale * math.log(f), meet)
            if d > change:
                loss = scatter_slope * d + (slope - scatter_slope) * change + zero
    return max(loss, 0.0)


@njit(cache=True)
def _in_sight(d: float, path: Path, smooth_sight: float, slope: float, zero: float, f: float, z: complex) -> float:
    """Loss within sight: A_o + k̂₁ d + k̂₂ ln d through three distances [ERL79, eqs. 3.16–3.21]."""
    _, _, d1, d2, he1, he2, _ = path
    horizon = d1 + d2
    at_sight = smooth_sight * slope + zero
    near = 0.04 * f * he1 * he2
    if zero >= 0.0:
        near = min(near, 0.5 * horizon)
        mid = near + 0.25 * (horizon - near)
    else:
        mid = max(-zero / slope, 0.25 * horizon)
    at_mid = _line_of_sight(mid, path, smooth_sight, slope, zero, f, z)
    k1 = k2 = 0.0
    curved = False
    if near < mid:
        at_near = _line_of_sight(near, path, smooth_sight, slope, zero, f, z)
        q = math.log(smooth_sight / near)
        span, part = smooth_sight - near, mid - near
        fit = (span * (at_mid - at_near) - part * (at_sight - at_near)) / (span * math.log(mid / near) - part * q)
        k2 = max(0.0, fit)
        curved = zero > 0.0 or k2 > 0.0
        if curved:
            k1 = (at_sight - at_near - k2 * q) / span
            if k1 < 0.0:
                k1, k2 = 0.0, max(at_sight - at_near, 0.0) / q
                if k2 == 0.0:
                    k1 = slope
    if not curved:
        k1, k2 = max(at_sight - at_mid, 0.0) / (smooth_sight - mid), 0.0
        if k1 == 0.0:
            k1 = slope
    return at_sight + k1 * (d - smooth_sight) + k2 * math.log(d / smooth_sight)
