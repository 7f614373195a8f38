"""`certificate`: an upper bound on the mutual information of every placement of n tasks, replicates included.

I ≤ IG(P_T) = ½ log det(I + K_T/σ²) under every noise convention (data processing). With φ(x) the feature of x in the
kernel's Hilbert space, K_T = ΦᵀΦ. For any Θ ≻ 0 on that space with eigenvalues θ_1 ≤ θ_2 ≤ … and largest θ_max,

    log det(K_T + σ²I) ≤ n log(max_x φ(x)ᵀΘφ(x) + σ²θ_max) − Σ_{i≤n} log θ_i                                    (1)

Proof: X = ΦΦᵀ + σ²P, P the projection on an n-dimensional space that holds the range of Φ, has the n eigenvalues μ_i
of K_T + σ²I; von Neumann's Σ μ_i↓ θ_i↑ ≤ tr ΘX ≤ n (max_x φᵀΘφ + σ²θ_max); arithmetic and geometric mean of the n
numbers μ_i θ_i.

Θ comes from the factorisation relaxation of maximum-entropy sampling (Nikolov 2015; Chen, Fampa & Lee 2023) over a
design w ≥ 0, Σw = n, on nodes x_j: with λ_1 ≥ λ_2 ≥ … the eigenvalues of A = Σ w_j φ(x_j)φ(x_j)ᵀ + σ²-shift and k the
one index for which λ_k > r ≥ λ_{k+1}, r = Σ_{i>k} λ_i / (n − k), Θ has 1/λ_i on the k leading eigenvectors v_i and
1/r on all the rest of the space, so that

    h(x) = φ(x)ᵀΘφ(x) = Σ_{i≤k} (v_iᵀφ(x))²/λ_i + (σ_f² − Σ_{i≤k} (v_iᵀφ(x))²)/r

A kernel with a map of the prior standard deviation, D K D with 0 ⪯ D ⪯ 1, is bounded by the stationary one of its
greatest σ_f: det(I + D K D/σ²) = det(I + K^½ D² K^½/σ²) ≤ det(I + K/σ²).

w is improved by multiplicative updates w_j ← w_j (h(x_j) + σ²/r), as for D-optimal designs (Yu 2010). Any w gives a
valid bound. For the maximum over the region see supremum.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from formulations.blas import one_thread
from formulations.kernel import SquaredExponential
from formulations.task_location.boundary import is_rectangle
from formulations.task_location.criterion import Criterion
from formulations.task_location.supremum import supremum
from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError

ROUNDING = 1e-7
"""Relative: added to a bound for the rounding of eigenvectors and sums (1e-13 where the leading λ_i are alike)."""
SMALLEST = 1e-9
"""Eigenvectors of a λ_i below this share of λ_1 are too inexact to be used: they join the rest."""


@dataclass(frozen=True)
class Certificate:
    """A bound [nats]; which argument gave it; and how many design updates it took."""

    bound: float
    kind: str
    updates: int = 0


@dataclass(frozen=True, eq=False)
class Theta:
    """The Θ of one design, in the form needed for h: see the top of this file.

    rows : v_i = Σ_j rows[i, j] φ(x_j), shape (k, N). weights : 1/λ_i, shape (k,). floor : 1/r, the largest eigenvalue.
    log_smallest : Σ_{i≤n} log θ_i.
    """

    rows: Floats
    weights: Floats
    floor: float
    log_smallest: float

    @classmethod
    def of_design(cls, prior: Floats, design: Floats, n: int, noise: float) -> Theta:
        """Return Θ of `design` (N,) on nodes with prior covariance `prior` (N, N)."""
        root = np.sqrt(design)
        values, vectors = np.linalg.eigh(root[:, None] * prior * root)
        values, vectors = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
        k, rest = _split(values, float(np.sum(values)), n)
        usable = int(np.count_nonzero(values > SMALLEST * values[0]))
        if usable < k:
            k, rest = usable, float(values[usable:].sum()) / (n - usable)
        lead = values[:k]
        rows = (vectors[:, :k] * root[:, None] / np.sqrt(lead)).T
        shifted = lead + noise
        floor = max(1.0 / (rest + noise), float(np.max(1.0 / shifted, initial=0.0)))
        return cls(rows, 1.0 / shifted, floor, -float(np.log(shifted).sum()) + (n - k) * math.log(floor))

    def heights(self, covariance: Floats, variance: float) -> Floats:
        """Return h(x) from k(x_j, x), shape (N, p), and σ_f²; shape (p,)."""
        squares = (self.rows @ covariance) ** 2
        return np.asarray((self.weights - self.floor) @ squares + variance * self.floor)

    def expansion(self, nodes: Floats, points: Floats, kernel: SquaredExponential) -> tuple[Floats, Floats]:
        """Return h and (∂²h/∂x², ∂²h/∂y²) at `points` (p, 2), shapes (p,) and (p, 2)."""
        covariance = kernel(nodes, points)
        along = self.rows @ covariance  # v_iᵀφ(x)
        coefficient = self.weights - self.floor
        curvature = np.empty((len(points), 2))
        for d, scale in enumerate(kernel.length_scales):
            gap = (points[None, :, d] - nodes[:, d, None]) / scale
            slope = self.rows @ (-gap * covariance)
            bend = self.rows @ ((gap * gap - 1) * covariance)
            curvature[:, d] = 2 * coefficient @ (slope * slope + along * bend) / scale**2
        return np.asarray(coefficient @ (along * along) + kernel.signal_sd**2 * self.floor), curvature


@one_thread()
def certificate(criterion: Criterion, region: Region, n: int, *, updates: int = 300) -> Certificate:
    """Return an upper bound on I, under the criterion's convention, of every n points of `region`.

    updates : multiplicative updates of the design at most; more make the bound tighter, never wrong.
    """
    if n < 1:
        raise InputError(f"certificate: the number of tasks must be at least 1, got {n}")
    options = [
        Certificate(trivial_bound(criterion, n), "every task alone"),
        Certificate(criterion.ceiling(), "what the test readings hold"),
        information_gain_bound(criterion, region, n, updates=updates),
    ]
    return min(options, key=lambda c: c.bound)


def trivial_bound(criterion: Criterion, n: int) -> float:
    """Return ½ n ln(1 + σ_f²/σ_n²) (Hadamard)."""
    return 0.5 * n * math.log1p(criterion.kernel.signal_sd**2 / criterion.noise)


def information_gain_bound(criterion: Criterion, region: Region, n: int, *, updates: int = 300) -> Certificate:
    """Return (1) for the design that `updates` multiplicative updates lead to."""
    kernel, noise = criterion.kernel.stationary, criterion.noise
    variance = kernel.signal_sd**2
    nodes = design_nodes(region, criterion.scales)
    prior = kernel(nodes, nodes)
    design = np.full(len(nodes), n / len(nodes))
    done = 0
    for done in range(1, updates + 1):  # noqa: B007 - reported
        theta = Theta.of_design(prior, design, n, noise)
        heights = theta.heights(prior, variance) + noise * theta.floor
        design *= heights
        design *= n / design.sum()
        if heights.max() < 1.0 + 2e-4:
            break
    support = design > 1e-7 * design.max()  # any design will do: nodes without weight only cost time
    nodes, prior, design = nodes[support], prior[np.ix_(support, support)], design[support]
    theta = Theta.of_design(prior, design, n, noise)
    highest = variance * theta.floor  # h ≤ ‖φ‖² ‖Θ‖, attained where k = 0
    if len(theta.rows):
        highest = min(
            highest, supremum(lambda points: theta.expansion(nodes, points, kernel), region, criterion.scales, highest)
        )
    bound = 0.5 * (n * math.log(highest + noise * theta.floor) - theta.log_smallest - n * math.log(noise))
    return Certificate(bound + ROUNDING * abs(bound), "information gain, continuous", done)


def _split(values: Floats, total: float, n: int) -> tuple[int, float]:
    """Return Nikolov's k < n and r = Σ_{i>k} λ_i/(n − k) for eigenvalues in descending order."""
    left = total
    for k in range(min(n, len(values))):
        rest = left / (n - k)
        if values[k] <= rest:
            return k, rest
        left -= float(values[k])
    k = min(n, len(values)) - 1
    return k, float(values[k:].sum()) / (n - k)


def design_nodes(region: Region, scales: Floats) -> Floats:
    """Return nodes for a design: a lattice, three points a length scale (13 to 21 a side), and the border."""
    x0, y0, x1, y1 = region.bounds
    sides = np.array([x1 - x0, y1 - y0])
    counts = np.clip(np.ceil(3 * sides / scales) + 1, 13, 21).astype(int)
    axes = [np.linspace(low, high, count) for low, high, count in zip((x0, y0), (x1, y1), counts, strict=True)]
    lattice = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    inside = lattice[region.contains(lattice)]
    if is_rectangle(region):
        return inside
    gap = float((sides / (counts - 1)).min())
    border = shapely.get_coordinates(shapely.segmentize(region.polygon.simplify(gap / 10), gap))
    return np.concatenate([inside, np.unique(border, axis=0)])
