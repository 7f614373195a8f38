"""Whether readings speak against the model that is planned by.

Of the model fitted to them by restricted likelihood p (`formulations.mapping.likelihood`), and of the one believed,

    log p(y | fitted) − log p(y | believed) > REFUTED

says that the belief is refuted: if it held, twice the left side would be about χ²-distributed with three degrees of
freedom, those of σ_f, l and the nugget (S. S. Wilks, Annals of Mathematical Statistics 9, 1938). Both are taken with
the fitted mean.
"""

from __future__ import annotations

import math

import numpy as np

from formulations.mapping.likelihood import RestrictedLikelihood
from formulations.mapping.map_model import MapModel
from instances.arrays import Floats

REFUTED = 4.0
"""Log-likelihood [nats] by which a fit is to be ahead: 5 % of true beliefs fall behind so far."""
LEAST = 1e-6
"""The nugget of a model that has none, in sensor noises."""


def ahead(fitted: MapModel, believed: MapModel, noise_sd: float, X: Floats, y: Floats, t: Floats) -> float:
    """Return by how much [nats] `fitted` explains readings `y` (N,) at `X` (N, 2) [m], `t` (N,) [s] better.

    noise_sd : σ_n of a reading. Raises LinAlgError where a covariance is not positive in float64.
    """
    drifts, shadows = min(fitted.tau, believed.tau) < math.inf, fitted.shadows
    mapped = fitted.kernel.relative_sd
    varied = None if mapped is None else mapped(X)
    times = t if drifts else None
    likelihood = RestrictedLikelihood(noise_sd, X, y, fitted.trend, times, varied, shadowed=shadows is not None)

    def value(model: MapModel) -> float:
        kernel, nugget = model.kernel, max(model.nugget_sd, LEAST * noise_sd)
        over = [model.tau] * drifts + ([shadows.contrast, shadows.in_sight] if shadows else [])
        theta = np.log([kernel.signal_sd, *kernel.length_scales, nugget, *over])
        return likelihood.value(type(kernel), theta, kernel.direction)

    return value(fitted) - value(believed)
