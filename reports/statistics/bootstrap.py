"""Bootstrap: an interval for a mean over instances, without assuming how the figures are distributed.

Bias-corrected and accelerated: B. Efron, Better bootstrap confidence intervals, J. Am. Stat. Assoc. 82 (1987) 171–185.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import bootstrap

RESAMPLES = 2000


def bootstrap_interval(values: ArrayLike, confidence: float = 0.95, seed: int = 0) -> tuple[float, float]:
    """Return the interval of the mean of `values`; not a number for fewer than two finite ones."""
    v = np.asarray(values, dtype=float)
    v = v[np.isfinite(v)]
    if v.size < 2:
        return float("nan"), float("nan")
    if np.ptp(v) == 0:
        return float(v[0]), float(v[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a resample may be constant; then BCa is not defined and percentiles are
        for method in ("BCa", "percentile"):
            found = bootstrap(
                (v,), np.mean, vectorized=True, confidence_level=confidence, n_resamples=RESAMPLES, method=method,
                rng=np.random.default_rng(seed), batch=max(1, 2_000_000 // v.size),
            ).confidence_interval  # fmt: skip
            if np.isfinite(found.low) and np.isfinite(found.high):
                break
    return float(found.low), float(found.high)
