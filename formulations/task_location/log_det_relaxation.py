"""The D-optimal relaxation of Joshi & Boyd (2009) in cvxpy: a cross-check that reads like the mathematics.

    max ½ log det(I + K^½ diag(w) K^½ / σ²)   s.t.  0 ≤ w ≤ 1,  Σw = n

over candidate sites; at a 0/1 vector w it is the information gain of those sites, so its optimum bounds every choice.
At the paper's signal-to-noise ratio it is loose (a spread-out w learns more than any n sites), which is why
certificate.py is what placements are measured against. Meant for at most 36 sites.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from formulations.task_location.criterion import Criterion
from instances.arrays import Floats
from instances.errors import InputError

MOST_SITES = 36


def log_det_relaxation(criterion: Criterion, sites: Floats, n: int) -> tuple[float, Floats]:
    """Return the relaxation's optimum [nats] (to the solver's 1e-7 or so) and w, shape (N,)."""
    if len(sites) > MOST_SITES:
        raise InputError(f"log_det relaxation: meant for at most {MOST_SITES} sites, got {len(sites)}")
    if not 1 <= n <= len(sites):
        raise InputError(f"log_det relaxation: {n} tasks do not fit on {len(sites)} sites")
    values, vectors = np.linalg.eigh(criterion.kernel(sites, sites))
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    w = cp.Variable(len(sites))
    information = cp.log_det(np.eye(len(sites)) + root @ cp.diag(w) @ root / criterion.noise)  # type: ignore[attr-defined]
    problem = cp.Problem(cp.Maximize(information), [w >= 0, w <= 1, cp.sum(w) == n])  # type: ignore[attr-defined]
    problem.solve(solver=cp.CLARABEL)
    return 0.5 * float(problem.value), np.asarray(w.value)
