"""Path bound: what no readings along tours of a given length can get the average variance below.

With φ(x) the features of the field, ξ_x ≥ 0 the number of readings at x, whole or not, M = I + Σ_x ξ_x φ(x)φ(x)ᵀ/σ² and
T = Σ_g w_g φ(g)φ(g)ᵀ, the average variance and its slope are

    J(ξ) = tr T M⁻¹,        −∂J/∂ξ_x = s(x) = |c(x)|²,   c(x) = T^½ M⁻¹ φ(x)/σ.

J is convex in ξ (F. Pukelsheim, Optimal Design of Experiments, 1993), so that for any ξ whatever, readings at x_i have

    J ≥ J(ξ) + Σ_x ξ_x s(x) − Σ_i s(x_i).

Reading i of a tour of at most L metres, one every d metres, lies within r_i = min(i d, L − i d) of its depot. The bound
puts the greatest s within r_i for s(x_i). ξ nears the best that spreads each reading over the places within its r_i, by
steps ξ ← ξ √s (Y. Yu, Ann. Stat. 38, 2010). What it says holds for readings anywhere in the region, not only on a grid:
around the middle of a cell of half-diagonal ρ, lengths in length scales,

    s ≤ s_0 + ρ|∇s_0| + ρ²(D² + n C),  C = √(3 λ_max(M^-½ T M^-½)) σ_f/σ ≥ |∂²c|,  D = |∂c_0| + ρC,  n = |c_0| + ρD.

φ are the features of the field's projection on its values at a lattice; what is left of the field is treated as known,
which lowers variances, so that the bound holds as well. Rounding is not proved: ROUNDING is taken off for it. What
is lost: a reading may be anywhere within r_i whatever its neighbours do, and readings may be fractions, so that where
endurance is scarce, and curves cannot be everywhere, the bound is far below what is reached. Nowhere is it below
`AverageVariance.lower_bound`, which is for as many readings anywhere.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky, eigh, eigvalsh, inv

from formulations.average_variance import AverageVariance
from formulations.blas import one_thread
from formulations.kernel import SquaredExponential
from instances.arrays import Bools, Floats
from instances.environment.region import Region

ROUNDING = 1e-6
"""Share by which the bound is lowered."""
LATTICE = 0.25
"""Step of the lattice, in length scales."""
CUT = 1e-13
"""Features of less than this share of the largest along an axis are left out: treated as known."""
PLACES = 0.125
"""Step between the places of ξ, in length scales."""
CELLS = 0.0125
"""Side of the cells in which s is bounded, in length scales."""
MOST_CELLS = 1000
"""Along a side of the region; in larger ones cells are larger and the bound looser."""
MOST_FEATURES = 2500
"""Of the field: a matrix of this size is inverted at every step."""
TINY = 1e-300
"""A slope is at least this."""


@one_thread()
def path_bound(
    judged: AverageVariance, region: Region, depots: Floats, length: float, spacing: float, steps: int = 50
) -> float:
    """Return a J that no tours from `depots` (m, 2) [m] and back pass from above, each at most `length` [m] long.

    judged : of the squared exponential; its known readings count. region : where UAVs stay. spacing : between two
    readings of a UAV [m], the first one spacing after its start. steps : towards the best ξ; any number gives a bound.

    For another kernel, a prior sd that varies and a field of more than MOST_FEATURES it is `judged.lower_bound`.
    """
    along = spacing * np.arange(1, int(length / spacing + 1e-9) + 1)
    if not len(along) or not len(depots):
        return judged.value(np.empty((0, 2))) * (1.0 - ROUNDING)
    by_number = judged.lower_bound(len(depots) * len(along))
    if not _Field.can_be(judged, region):
        return by_number
    radii, readings = np.unique(np.maximum(np.minimum(along, length - along), 0.0), return_counts=True)
    field = _Field(judged, region)
    reach = np.concatenate([_reached(field.places, depot, radii) for depot in depots])
    mass = np.tile(readings, len(depots))[:, None].astype(float)
    shares = reach / reach.sum(axis=1, keepdims=True)
    for _ in range(steps):
        shares *= np.sqrt(field.slopes((mass * shares).sum(axis=0)))
        shares /= shares.sum(axis=1, keepdims=True)
    xi = (mass * shares).sum(axis=0)
    most = field.greatest(xi, np.asarray(depots, dtype=float), radii)
    bound = field.value(xi) + float(xi @ field.slopes(xi)) - float((readings * most).sum())
    return max(bound * (1.0 - ROUNDING), by_number)


def _reached(places: Floats, depot: Floats, radii: Floats) -> Bools:
    """Return which `places` (p, 2) lie within each of `radii` (r,) of `depot`, at least the nearest, shape (r, p)."""
    away = np.hypot(*(places - depot).T)
    return np.asarray(away <= np.maximum(radii, away.min())[:, None])


class _Field:
    """J and its slopes for ξ on a lattice of places in the region, and bounds of s anywhere in it."""

    def __init__(self, judged: AverageVariance, region: Region) -> None:
        kernel = judged.kernel
        self.region, self.ratio = region, kernel.signal_sd / judged.noise_sd
        self.axes = _axes(judged, region)
        lattice = np.stack(np.meshgrid(*(axis.steps(PLACES) for axis in self.axes)), axis=-1).reshape(-1, 2)
        inside = region.contains(lattice)
        self.places = lattice[inside] if inside.any() else lattice
        self.phi, known = self._features(self.places), self._features(judged.known)
        self.prior = np.eye(self.phi.shape[1]) + known.T @ known
        targets = judged.noise_sd * np.sqrt(judged.shares)[:, None] * self._features(judged.targets)
        self.wanted = targets.T @ targets

    @staticmethod
    def can_be(judged: AverageVariance, region: Region) -> bool:
        """Return whether there are features of the field, and not too many."""
        if not isinstance(judged.kernel, SquaredExponential) or judged.kernel.relative_sd is not None:
            return False
        x, y = _axes(judged, region)
        return x.count * y.count <= MOST_FEATURES

    def value(self, xi: Floats) -> float:
        """Return J at `xi`, shape (p,)."""
        return float((self.wanted * self._left(xi)).sum())

    def slopes(self, xi: Floats) -> Floats:
        """Return s at the places, shape (p,)."""
        left = self._left(xi)
        slopes = np.einsum("ij,ij->i", self.phi @ (left @ self.wanted @ left), self.phi)
        return np.maximum(slopes, TINY)  # rounding can make it negative

    def greatest(self, xi: Floats, depots: Floats, radii: Floats) -> Floats:
        """Return an upper bound of s within each of `radii` (r,) [m] of each of `depots`, shape (m, r)."""
        points, ceilings, half = self._ceilings(xi)
        inside = self.region.signed_distance(points) >= -half
        points, ceilings, found = points[inside], ceilings[inside], []
        for depot in depots:
            away = np.hypot(*(points - depot).T)
            order = np.argsort(away)
            last = np.searchsorted(away[order], np.maximum(radii, away.min()) + half, side="right") - 1
            found.append(np.maximum.accumulate(ceilings[order])[last])
        return np.array(found)

    def _ceilings(self, xi: Floats) -> tuple[Floats, Floats, float]:
        """Return the middles of cells (q, 2) [m], an upper bound of s in each (q,), and half a cell's diagonal [m]."""
        left = self._left(xi)
        root = cholesky(left, lower=True, check_finite=False)
        largest = eigvalsh(root.T @ self.wanted @ root, subset_by_index=[len(root) - 1] * 2, check_finite=False)[0]
        x, y = self.axes
        sides = [axis.steps(max(CELLS, axis.length / MOST_CELLS)) for axis in self.axes]
        (fx, dx), (fy, dy) = ((axis.at(side), axis.slope(side)) for axis, side in zip(self.axes, sides, strict=True))
        weights = self.ratio**2 * (left @ self.wanted @ left).reshape(x.count, y.count, x.count, y.count)
        s, sx, sy = (_form(weights, *each) for each in ((fx, fy, fx, fy), (dx, fy, fx, fy), (fx, dy, fx, fy)))
        steep = _form(weights, dx, fy, dx, fy) + _form(weights, fx, dy, fx, dy)
        steps = np.array([side[1] - side[0] for side in sides])
        rho = 0.5 * float(np.hypot(*(steps / [axis.scale for axis in self.axes])))
        bend = np.sqrt(3.0 * largest) * self.ratio
        slope = np.sqrt(np.maximum(steep, 0.0)) + rho * bend
        norm = np.sqrt(np.maximum(s, 0.0)) + rho * slope
        ceilings = s + rho * 2.0 * np.hypot(sx, sy) + rho**2 * (slope**2 + norm * bend)
        points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 2)
        return points, ceilings.ravel(), 0.5 * float(np.hypot(*steps))

    def _left(self, xi: Floats) -> Floats:
        return np.asarray(inv(self.prior + (self.phi.T * xi) @ self.phi, check_finite=False))

    def _features(self, points: Floats) -> Floats:
        """Return φ/σ at `points` (k, 2) [m], shape (k, features)."""
        parts = [axis.at(points[:, i]) for i, axis in enumerate(self.axes)]
        return self.ratio * np.einsum("ka,kb->kab", *parts).reshape(
            len(points), self.axes[0].count * self.axes[1].count
        )


def _axes(judged: AverageVariance, region: Region) -> tuple[_Axis, _Axis]:
    x0, y0, x1, y1 = region.bounds
    across, along = judged.kernel.length_scales
    return _Axis(x0, x1, across), _Axis(y0, y1, along)


def _form(weights: Floats, a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Return Σ weights_ijkl a_xi b_yj c_xk d_yl, shape (x, y): the features are products, so that it is cheap."""
    along_x = np.einsum("xi,xk->xik", a, c).reshape(len(a), -1)
    along_y = np.einsum("yj,yl->yjl", b, d).reshape(len(b), -1)
    square = weights.transpose(0, 2, 1, 3).reshape(along_x.shape[1], along_y.shape[1])
    return np.asarray(along_x @ square @ along_y.T)


class _Axis:
    """Features of exp(−(u − v)²/2) along one axis, u = x/scale: of its projection on a lattice from `low` to `high`."""

    def __init__(self, low: float, high: float, scale: float) -> None:
        self.scale, self.low, self.length = scale, low, (high - low) / scale
        self._nodes = self.steps(LATTICE) / scale
        values, vectors = eigh(self._correlation(self._nodes))
        kept = values > CUT * values[-1]
        self._mix = vectors[:, kept] / np.sqrt(values[kept])
        self.count = int(kept.sum())

    def steps(self, step: float) -> Floats:
        """Return places [m] from end to end, at most `step` length scales apart."""
        count = max(1, int(np.ceil(self.length / step - 1e-9)))
        return self.low + self.scale * np.linspace(0.0, self.length, count + 1)

    def at(self, x: Floats) -> Floats:
        """Return the features at `x` (k,) [m], shape (k, count)."""
        return np.asarray(self._correlation(x / self.scale) @ self._mix)

    def slope(self, x: Floats) -> Floats:
        """Return their slopes by u at `x` (k,) [m], shape (k, count)."""
        u = x / self.scale
        return np.asarray((-np.subtract.outer(u, self._nodes) * self._correlation(u)) @ self._mix)

    def _correlation(self, u: Floats) -> Floats:
        return np.asarray(np.exp(-0.5 * np.subtract.outer(u, self._nodes) ** 2))
