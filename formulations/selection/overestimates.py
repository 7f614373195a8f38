"""Overestimates: linear functions that no set's worth exceeds,  f(S) ≤ a + Σ_{i∈S} w_i  for all S.

Prizes are their own. For information, with C ⪰ D ⪰ I as in `worth.py`, the two halves are bounded apart.

½ log det C[S] from above. For any scaling γ > 0 and binary y (y_i = 1 where i ∈ S)

    ½ log det C[S] = ¼ log det(Γ C Y C Γ + I − Y) − ½ Σ y_i log γ_i,      Γ = diag γ, Y = diag y,

and the right-hand side is concave in y ∈ [0, 1]ⁿ: its tangent at any point is an overestimate, exact at that point
where it is binary. (Anstreicher, "Efficient solution of maximum-entropy sampling problems", Oper. Res. 68, 2020, the
"linx" bound; a scaling of each task, Chen, Fampa, Lee, arXiv 2310.14661. Where tasks are independent, γ_i = 1/C_ii
makes it linear, hence tight.) In log γ it is convex, so the best scaling is found by descent; any is valid.

−½ log det D[S] from above: ½ log det D[S] is submodular, so it is at least Σ_{i∈S} of what i adds to all others,
½ log (1 / (D⁻¹)_ii).

Classic ones of Nemhauser & Wolsey (1981) complete the list: for submodular monotone f and any A,
f(S) ≤ f(A) + Σ_{i∈S∖A} f(i|A) − Σ_{i∈A∖S} f(i|T∖i).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.optimize

from formulations.selection.worth import Worth
from instances.arrays import Bools, Floats

_INSIDE = 1e-6
"""Tangents are taken this far inside [0, 1], where the matrix is never singular."""


class Overestimate(NamedTuple):
    """A linear function of y: `constant` a, `slope` w (n,)."""

    constant: float
    slope: Floats

    def at(self, y: Floats) -> float:
        """Return its value at y (n,)."""
        return self.constant + float(self.slope @ y)


def first_overestimates(worth: Worth, reachable: Bools) -> Iterator[Overestimate]:
    """Yield the overestimates to begin with."""
    if worth.prior is None:
        yield Overestimate(0.0, worth.prizes)
        return
    yield tangent(worth, np.where(reachable, 0.5, 0.0))
    single = 0.5 * np.log(np.diagonal(worth.prior))
    yield Overestimate(0.0, worth.prizes + single + _posterior_slope(worth))


def tangent(worth: Worth, y: Floats) -> Overestimate:
    """Return the tangent at y ∈ [0, 1]ⁿ of the concave extension of the worth, at its best scaling."""
    if worth.prior is None:
        return Overestimate(0.0, worth.prizes)
    at = np.clip(y, _INSIDE, 1 - _INSIDE)
    gamma = _best_scaling(worth.prior, at)
    scaled = gamma[:, None] * worth.prior
    inverse, log_det = _inverse(scaled, at)
    value = 0.25 * log_det - 0.5 * float(at @ np.log(gamma))
    curved = np.einsum("ji,jk,ki->i", scaled, inverse, scaled)
    slope = 0.25 * (curved - np.diagonal(inverse)) - 0.5 * np.log(gamma)
    rounding = worth.rounding + 1e-10 * float(np.abs(slope).sum())
    constant = value - float(slope @ at) + rounding
    return Overestimate(constant, slope + worth.prizes + _posterior_slope(worth))


def _inverse(scaled: Floats, y: Floats) -> tuple[Floats, float]:
    """Return M⁻¹ and log det M of M = ΓCYCΓ + I − Y."""
    matrix = (scaled * y) @ scaled.T + np.diag(1 - y)
    factor = scipy.linalg.cho_factor(matrix, lower=True, check_finite=False)
    inverse = scipy.linalg.cho_solve(factor, np.eye(y.size), check_finite=False)
    return inverse, 2.0 * float(np.log(np.diagonal(factor[0])).sum())


def _best_scaling(prior: Floats, y: Floats) -> Floats:
    """Return γ that makes the extension least at y, nearly."""

    def value(log_gamma: Floats) -> tuple[float, Floats]:
        inverse, log_det = _inverse(np.exp(log_gamma)[:, None] * prior, y)
        return 0.5 * log_det - float(y @ log_gamma), (1 - y) * (1 - np.diagonal(inverse))

    begin = -np.log(np.diagonal(prior))
    found = scipy.optimize.minimize(value, begin, jac=True, method="L-BFGS-B", options={"maxiter": 60})
    return np.asarray(np.exp(found.x))


def _posterior_slope(worth: Worth) -> Floats:
    """Return −½ log (1 / (D⁻¹)_ii), (n,), 0 where there is no D."""
    if worth.posterior is None:
        return np.zeros(worth.n_tasks)
    return 0.5 * np.log(np.diagonal(np.linalg.inv(worth.posterior)))
