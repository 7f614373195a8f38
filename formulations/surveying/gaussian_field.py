"""A field drawn from a Gaussian process on a lattice, by circulant embedding.

On a torus longer than the region by several length scales the covariance is diagonal in Fourier space, so that a draw
is one filtered noise (C. R. Dietrich, G. N. Newsam, SIAM J. Sci. Comput. 18, 1997); the little negative power that the
embedding can have is dropped. Between the nodes the field is bilinear.
"""

from __future__ import annotations

import math

import numpy as np

from formulations.kernel import Kernel
from instances.arrays import Floats
from instances.environment.radio import RadioMap

MARGIN = 8.0
"""Length scales by which the torus is longer than the region."""
MOST_NODES = 4096
"""Of the margin: longer ones would take more memory than is reasonable."""


def gaussian_field(
    kernel: Kernel, bounds: tuple[float, float, float, float], cells: int, seed: int, level: float = 0.0, unit: str = ""
) -> RadioMap:
    """Return a draw of mean `level` over `bounds` (x0, y0, x1, y1) [m], `cells` along the longer side."""
    x0, y0, x1, y1 = bounds
    size = max(x1 - x0, y1 - y0) / cells
    nx, ny = (max(2, round(side / size)) + 1 for side in (x1 - x0, y1 - y0))
    x, y = np.linspace(x0, x1, nx), np.linspace(y0, y1, ny)
    squares = [
        _lags(axis, MARGIN * scale) ** 2 / scale**2
        for axis, scale in zip((y, x), kernel.length_scales[::-1], strict=True)
    ]
    covariance = kernel.signal_sd**2 * kernel.correlation(np.add.outer(*squares))
    power = np.maximum(np.fft.fft2(covariance).real, 0.0)
    drawn = np.random.default_rng(seed).standard_normal(power.shape)
    field = np.fft.ifft2(np.fft.fft2(drawn) * np.sqrt(power)).real
    return RadioMap(x, y, level + field[:ny, :nx], unit)


def _lags(axis: Floats, margin: float) -> Floats:
    """Return the distances [m] from the torus's first node, `margin` [m] beyond `axis`, shape (k,)."""
    step = float(axis[1] - axis[0])
    count = len(axis) + math.ceil(min(margin / step, MOST_NODES))
    return step * np.minimum(np.arange(count), count - np.arange(count))
