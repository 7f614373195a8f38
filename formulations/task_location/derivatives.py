"""Closed-form gradient and Hessian of the mutual information with respect to the task locations.

I = ½ log det(K + σ²I) − ½ log det(C + σ²I) with two kernel matrices, k(x, y) and c(x, y) = k(x, y) − φ(x)ᵀφ(y)
(criterion.py). For either one, with M = (matrix + σ²I)⁻¹, D^d_ij = ∂_{x^d} c(p_i, p_j) and unknowns (i, d), point i
in direction d:

    ∇[i, d]          = Σ_j M_ij D^d_ij
    H[(i,d), (j,e)]  = M_ij c_xy^{de}(i, j) − (D^d M)_ij (D^e M)_ji − M_ij (D^d M D^{eᵀ})_ij
                       + δ_ij Σ_k M_ik c_xx^{de}(i, k)

where c_xy^{de} = ∂_{x^d} ∂_{y^e} c and c_xx^{de} = ∂_{x^d} ∂_{x^e} c. (Derivation: d½ log det C = ½ tr M dC, twice.)
With the weights b(y) = Wᵀφ(y) that the test readings have in the prediction at y, φ = W k_o, a derivative of c in x
alone is ∂c(x, y) = ∂k(x, y) − ∂k_o(x)ᵀ b(y): products with the large W are needed for φ, b and ∂φ only.
Points are in units of the length scales here, so that both directions are alike: z = x / l. A map of the prior
standard deviation enters by the product rule (prior_slopes.py).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from formulations.task_location.criterion import Criterion
from formulations.task_location.prior_slopes import PriorSlopes
from instances.arrays import Floats


class Expansion:
    """The mutual information around one placement: value, gradient and Hessian, sharing what they have in common.

    points : (n, 2) [m].
    """

    def __init__(self, criterion: Criterion, points: Floats) -> None:
        self._criterion = criterion
        self._posterior = criterion.posterior
        self._scales = criterion.scales
        z = points / self._scales
        self._gaps = [z[:, d, None] - z[None, :, d] for d in (0, 1)]
        self._test_gaps = [z[None, :, d] - criterion.tests[:, d, None] / self._scales[d] for d in (0, 1)]
        variance = criterion.kernel.signal_sd**2
        self._prior = variance * np.exp(-0.5 * (self._gaps[0] ** 2 + self._gaps[1] ** 2))
        self._to_tests = variance * np.exp(-0.5 * (self._test_gaps[0] ** 2 + self._test_gaps[1] ** 2))
        self._mapped: PriorSlopes | None = None
        if (m := criterion.kernel.relative_sd) is not None:  # at the tasks it comes last, and is differentiated
            self._mapped = PriorSlopes.at(m, points, self._scales)
            self._to_tests *= m(criterion.tests)[:, None]

    @cached_property
    def _basis(self) -> Floats:
        """φ(p_i), shape (r, n)."""
        return np.asarray(self._criterion.whitening @ self._to_tests)

    @cached_property
    def _weights(self) -> Floats:
        """b(p_i), shape (m, n)."""
        return np.asarray(self._criterion.whitening.T @ self._basis)

    @cached_property
    def _slopes(self) -> tuple[list[Floats], list[Floats], list[Floats]]:
        """∂k, ∂k_o and ∂c with respect to z_i of the first argument, for d = x, y; without the map at the tasks."""
        prior = [-gap * self._prior for gap in self._gaps]
        tests = [-gap * self._to_tests for gap in self._test_gaps]
        return prior, tests, [self._posterior(p, t, self._weights) for p, t in zip(prior, tests, strict=True)]

    @cached_property
    def _left(self) -> Floats:
        """c(p_i, p_j), without the map at the tasks, shape (n, n)."""
        return self._posterior(self._prior, self._basis, self._basis)

    @cached_property
    def _inverses(self) -> tuple[Floats, Floats, float]:
        """(K + σ²I)⁻¹, (C + σ²I)⁻¹ and I."""
        noise = self._criterion.noise * np.eye(len(self._prior))
        prior, left = self._prior, self._left
        if self._mapped is not None:
            prior, left = self._mapped.matrix(prior), self._mapped.matrix(left)
        prior, log_prior = _inverse(prior + noise)
        posterior, log_posterior = _inverse(left + noise)
        return prior, posterior, 0.5 * (log_prior - log_posterior)

    @cached_property
    def _mapped_slopes(self) -> tuple[list[Floats], list[Floats]]:
        """∂k and ∂c with the map at the tasks."""
        prior, _, left = self._slopes
        if self._mapped is None:
            return prior, left
        return self._mapped.slopes(self._prior, prior), self._mapped.slopes(self._left, left)

    @property
    def value(self) -> float:
        """I [nats]."""
        return self._inverses[2]

    @cached_property
    def gradient(self) -> Floats:
        """∇I [nats/m], shape (n, 2)."""
        prior, posterior, _ = self._inverses
        parts = [
            (prior * d).sum(axis=1) - (posterior * c).sum(axis=1) for d, c in zip(*self._mapped_slopes, strict=True)
        ]
        return np.stack(parts, axis=1) / self._scales

    @cached_property
    def hessian(self) -> Floats:
        """∇²I [nats/m²], shape (2n, 2n), unknowns in the order x_0, y_0, x_1, y_1, …"""
        n = len(self._prior)
        gaps, far = self._gaps, self._test_gaps
        prior_inverse, posterior_inverse, _ = self._inverses
        plain, test_slopes, plain_left = self._slopes
        slopes, posterior_slopes = self._mapped_slopes
        basis_slopes = np.split(self._criterion.whitening @ np.hstack(test_slopes), 2, axis=1)
        result = np.zeros((n, 2, n, 2))
        for d, e in ((0, 0), (0, 1), (1, 1)):
            curvature = (far[d] * far[e] - (d == e)) * self._to_tests
            twice = self._prior * (gaps[d] * gaps[e] - (d == e))  # k_xx; k_xy = −k_xx: k depends on x − y alone
            mixed = self._posterior(-twice, basis_slopes[d], basis_slopes[e])
            own = self._posterior(twice, curvature, self._weights)
            apart = -twice
            if (m := self._mapped) is not None:
                mixed, own = m.mixed(d, e, self._left, plain_left, mixed), m.twice(d, e, self._left, plain_left, own)
                apart, twice = m.mixed(d, e, self._prior, plain, apart), m.twice(d, e, self._prior, plain, twice)
            block = _block(prior_inverse, slopes[d], slopes[e], apart, twice)
            block -= _block(posterior_inverse, posterior_slopes[d], posterior_slopes[e], mixed, own)
            result[:, d, :, e] = block
            result[:, e, :, d] = block.T
        scales = np.tile(self._scales, n)
        return np.asarray(result.reshape(2 * n, 2 * n) / scales / scales[:, None])


def _block(inverse: Floats, slope_d: Floats, slope_e: Floats, mixed: Floats, own: Floats) -> Floats:
    """Return H[(·, d), (·, e)] of ½ log det, shape (n, n), by the formula at the top."""
    left = slope_d @ inverse
    block = inverse * mixed - left * (slope_e @ inverse).T - inverse * (left @ slope_e.T)
    block[np.diag_indices_from(block)] += (inverse * own).sum(axis=1)
    return np.asarray(block)


def _inverse(matrix: Floats) -> tuple[Floats, float]:
    """Return the inverse and log det of a symmetric positive definite matrix."""
    factor = np.linalg.cholesky(matrix)
    half = np.linalg.inv(factor)
    return half.T @ half, 2.0 * float(np.log(np.diagonal(factor)).sum())
