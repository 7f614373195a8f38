"""The second question: the fewest tasks that leave a posterior sd of at most x everywhere in the region.

    min n   s.t.   max over A of var(p | P_T) ≤ x²,   |P_T| = n

From above: tasks are added where the variance is highest until the limit is met, then one is taken away at a time
(the one missed least) and the others are moved by L-BFGS-B on a smooth stand-in for the maximum,

    J(P) = (Σ_g v_g^p)^(1/p),   v_g = var(g | P) on a lattice of watch points g,   p = 8, then 32,
    ∂J/∂p_i = Σ_g u_g (−2 α_ig ∂k(p_i, g) + 2 Σ_j α_ig α_jg ∂k(p_i, p_j)),  α = (K + σ²I)⁻¹ k(P, g),  u = ∂J/∂v,

until that fails. That the limit holds *everywhere* is then proved, not sampled: var(x | P) = φ(x)ᵀΘφ(x) with
0 ⪯ Θ ⪯ I, and supremum.py bounds such functions over the region.

From below: under the limit, any test points o with any noise s have (Hadamard) log det(K_o|T + s²I) ≤ m log(x² + s²),
so that I(y_T; y_o) ≥ ½ [log det(K_o + s²I) − m log(x² + s²)]; where that passes the certificate of n tasks, n are too
few. (Binney & Sukhatme 2012 and Jakkala & Akella, arXiv 2602.05198, ask the same of paths.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from formulations.kernel import SquaredExponential
from formulations.task_location.boundary import box
from formulations.task_location.certificate import certificate
from formulations.task_location.criterion import Criterion, log_det
from formulations.task_location.placement import lattice
from formulations.task_location.supremum import supremum
from formulations.task_location.uncertainty import posterior_sd
from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError

MOST_TASKS = 400
MARGINS = (0.998, 0.985, 0.96, 0.9)
"""The search aims at these fractions of the limit, one after another, until the proof between watch points succeeds."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """Tasks that keep the limit.

    points : (n, 2) [m]. worst_sd : proved upper bound on the posterior sd anywhere in the region, ≤ the limit.
    at_least : no fewer tasks can keep the limit. greedy : how many the greedy choice alone needed.
    """

    points: Floats
    worst_sd: float
    at_least: int
    greedy: int


def fewest_tasks(
    region: Region, kernel: SquaredExponential, noise_sd: float, max_sd: float, *, seed: int = 0, tries: int = 3
) -> Coverage:
    """Return few tasks whose noisy readings leave a posterior sd ≤ `max_sd` everywhere in `region`.

    tries : random restarts before the search gives up on one task fewer.
    Raises InputError for a limit that needs no task or more than `MOST_TASKS`, and for a map of the prior sd.
    """
    if kernel.relative_sd is not None:
        raise InputError("max-sd: cannot be proved under a map of the prior standard deviation, only under one number")
    if not 0 < max_sd < kernel.signal_sd:
        raise InputError(f"max-sd: must lie between 0 and the signal sd ({kernel.signal_sd}), got {max_sd}")
    watch = watch_points(region, kernel)
    spread = _Spread(region, kernel, noise_sd, watch)
    greedy = len(_greedy(kernel, noise_sd, watch, max_sd))
    for margin in MARGINS:
        points = _descended(spread, margin * max_sd, np.random.default_rng(seed), tries)
        worst = worst_sd(region, kernel, noise_sd, points)
        if worst <= max_sd:
            break
    else:
        raise InputError(
            f"max-sd: {max_sd} could not be proved everywhere; the region is too intricate for the lattice"
        )
    return Coverage(points, worst, tasks_needed(region, kernel, noise_sd, max_sd, len(points)), greedy)


def _descended(spread: _Spread, limit: float, rng: np.random.Generator, tries: int) -> Floats:
    """Return few tasks within `limit` at the watch points: greedy, then one fewer as long as that succeeds."""
    points = _greedy(spread.kernel, spread.noise_sd, spread.watch, limit)
    while len(points) > 1 and (fewer := _one_fewer(spread, points, limit, rng, tries)) is not None:
        points = fewer
    return points


def worst_sd(region: Region, kernel: SquaredExponential, noise_sd: float, points: Floats) -> float:
    """Return a proved upper bound on the posterior sd anywhere in `region`, tight to some 1e-4 (relative)."""
    inverse = np.linalg.inv(np.linalg.cholesky(kernel(points, points) + noise_sd**2 * np.eye(len(points))))

    def expansion(places: Floats) -> tuple[Floats, Floats]:
        covariance = kernel(points, places)
        along = inverse @ covariance
        second = np.empty((len(places), 2))
        for d, scale in enumerate(kernel.length_scales):
            gap = (places[None, :, d] - points[:, d, None]) / scale
            slope, bend = inverse @ (-gap * covariance), inverse @ ((gap * gap - 1) * covariance)
            second[:, d] = -2 * (slope * slope + along * bend).sum(axis=0) / scale**2
        return kernel.signal_sd**2 - (along * along).sum(axis=0), second

    scales = np.asarray(kernel.length_scales)
    return math.sqrt(max(supremum(expansion, region, scales, kernel.signal_sd**2, tolerance=1e-3), 0.0))


def tasks_needed(region: Region, kernel: SquaredExponential, noise_sd: float, max_sd: float, known: int) -> int:
    """Return a lower bound on the number of tasks; `known` suffice."""
    need, best = 0.0, None
    for cells in (5, 7, 10, 14, 20):
        tests = region.cell_centres(cells, cells)
        if not len(tests):
            continue
        prior = kernel(tests, tests)
        for s in (0.1 * max_sd, 0.3 * max_sd, max_sd, 3 * max_sd):
            total = log_det(prior + s * s * np.eye(len(tests))) - len(tests) * math.log(max_sd**2 + s * s)
            if 0.5 * total > need:
                need, best = 0.5 * total, Criterion(kernel, tests, noise_sd=noise_sd, test_noise_sd=s)
    if best is None:
        return 1
    low, high = 1, known  # certificate(high) may already be enough; below `low` it never is
    while low < high:
        middle = (low + high) // 2
        if certificate(best, region, middle, updates=60).bound >= need:
            high = middle
        else:
            low = middle + 1
    return low


def watch_points(region: Region, kernel: SquaredExponential) -> Floats:
    """Return a lattice of eight points a length scale (21 to 61 a side) and the border at the same spacing."""
    x0, y0, x1, y1 = region.bounds
    per_axis = int(np.clip(math.ceil(8 * max((x1 - x0), (y1 - y0)) / min(kernel.length_scales)) + 1, 21, 61))
    gap = max(x1 - x0, y1 - y0) / (per_axis - 1)
    border = shapely.get_coordinates(shapely.segmentize(region.polygon, gap))
    return np.concatenate([lattice(region, per_axis), border])


def _greedy(kernel: SquaredExponential, noise_sd: float, sites: Floats, limit: float) -> Floats:
    """Return sites of highest variance, one after another, until all are under `limit`."""
    variance = np.full(len(sites), kernel.signal_sd**2)
    rows = np.zeros((MOST_TASKS, len(sites)))
    chosen: list[int] = []
    while variance.max() > limit**2:
        if len(chosen) == MOST_TASKS:
            raise InputError(f"max-sd: more than {MOST_TASKS} tasks would be needed; allow a larger sd")
        best, step = int(np.argmax(variance)), len(chosen)
        row = kernel(sites[best][None], sites)[0] - rows[:step, best] @ rows[:step]
        rows[step] = row / math.sqrt(variance[best] + noise_sd**2)
        variance = np.maximum(variance - rows[step] ** 2, 0.0)
        chosen.append(best)
    return sites[chosen]


def _one_fewer(spread: _Spread, points: Floats, limit: float, rng: np.random.Generator, tries: int) -> Floats | None:
    """Return one point fewer within `limit` at the watch points, or None where the search finds none."""
    without = [np.delete(points, i, axis=0) for i in range(len(points))]
    least = min(without, key=lambda rest: float(spread.sd(rest).max()))
    width = 0.5 * np.asarray(spread.kernel.length_scales)
    for attempt in range(1 + tries):
        begin = least if attempt == 0 else spread.region.snap(least + rng.normal(size=least.shape) * width)
        moved = spread.lowered(begin)
        if spread.sd(moved).max() <= limit:
            return moved
    return None


class _Spread:
    """The posterior variance at the watch points as a function of the tasks."""

    def __init__(self, region: Region, kernel: SquaredExponential, noise_sd: float, watch: Floats) -> None:
        self.region, self.kernel, self.noise_sd, self.watch = region, kernel, noise_sd, watch
        self._scales = np.asarray(kernel.length_scales)

    def sd(self, points: Floats) -> Floats:
        """Return the posterior sd at the watch points."""
        return posterior_sd(self.kernel, self.noise_sd, points, self.watch)

    def lowered(self, begin: Floats) -> Floats:
        """Return `begin` moved to where J is lower, inside the region."""
        points = begin
        for power in (8.0, 32.0):
            done = minimize(
                self.norm,
                (points / self._scales).ravel(),
                args=(power,),
                jac=True,
                method="L-BFGS-B",
                bounds=box(self.region, self._scales, len(begin)),
                options={"maxiter": 80, "maxcor": 20},
            )
            points = self.region.snap(done.x.reshape(-1, 2) * self._scales)
        return points

    def norm(self, z: Floats, power: float) -> tuple[float, Floats]:
        """Return log J and its gradient at z = P / l, flat."""
        points = z.reshape(-1, 2) * self._scales
        to_watch, among = self.kernel(points, self.watch), self.kernel(points, points)
        alpha = cho_solve(cho_factor(among + self.noise_sd**2 * np.eye(len(points))), to_watch)
        variance = np.maximum(self.kernel.signal_sd**2 - np.einsum("ig,ig->g", to_watch, alpha), 1e-12)
        highest = float(variance.max())
        powers = (variance / highest) ** power
        total = float(powers.sum())
        weights = powers / variance / total  # ∂ log J / ∂v
        pairs = (alpha * weights) @ alpha.T
        gradient = np.empty((len(points), 2))
        for d in (0, 1):
            scaled, seen = points[:, d] / self._scales[d], self.watch[:, d] / self._scales[d]
            slope = -(scaled[:, None] - seen[None, :]) * to_watch
            mutual = -(scaled[:, None] - scaled[None, :]) * among
            gradient[:, d] = -2 * (alpha * weights * slope).sum(axis=1) + 2 * (pairs * mutual).sum(axis=1)
        return math.log(highest) + math.log(total) / power, gradient.ravel()
