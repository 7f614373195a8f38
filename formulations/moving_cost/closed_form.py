"""closed-form: winds whose vorticity is the same everywhere, over open country. The cheapest paths are arcs.

Minimise C(σ) = τ − (1/v0²) ∫ w(σ)·dσ (paper, eq. moving_cost) over all paths a → b of the plane. With ω = curl w
constant and κ = |ω|/v0, the minimum is an arc of curvature κ, to the left for ω > 0 (straight for ω = 0). With
d = |b − a|, φ = asin(κd/2) ≤ π/2 and R = 1/κ it costs, by Stokes' theorem between the arc and its chord,

    uniform    C = d/v0 − w·(b − a)/v0²
    rotation   C = 2φR/v0 − [Ω (a − c)×(b − c) + 2ΩA]/v0²,          ω = 2Ω
    shear      C = 2φR/v0 − [α (ȳ − y0) Δx + |α| A]/v0²,             ω = −α

where A = R²(φ − sin φ cos φ) is the area between the two. All three are one formula, which `instances.wind_metric`
states and computes: it is also what an instance file means by the metric `wind`, and files are read without this room.

Flight time at constant airspeed has a closed form in a uniform wind: the quickest paths are straight, and cost what
`instances.wind_triangle` says.

Arcs bulge beyond the convex hull of their ends by at most R(1 − cos φ). Generator families of open country take that as
it is (`open_country`); as a method, asked for a region, `ClosedForm` refuses where an arc leaves it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from formulations.moving_cost.method import MovingCostMethod, MovingCosts, Progress, Query, silent
from instances import Instance
from instances.arrays import Floats
from instances.environment.wind import Rotation, Uniform
from instances.errors import InputError
from instances.metric_costs import MATRIX_NODES
from instances.metrics import distances
from instances.moving_cost import CostKind, moving_cost
from instances.paths import Paths, paths_outside
from instances.scenario import Scenario
from instances.wind_metric import cost_matrix, vorticity, wind_metric
from instances.wind_triangle import zermelo_times

TURN = math.sqrt(24 * 2e-6)
"""Turn θ [rad] from piece to piece of an arc: a polyline costs θ²/24 more than its arc, here 2·10⁻⁶ of its time."""


@dataclass(frozen=True)
class ClosedForm(MovingCostMethod):
    """The formula at the top of this file, and arcs as paths."""

    def solve(self, query: Query, progress: Progress = silent) -> MovingCosts:
        """Return costs and paths between all terminals; InputError also where an arc leaves the region."""
        if query.kind is CostKind.TIME:
            cost, paths = _quickest(query), arcs(query.terminals, 0.0)
        else:
            cost = cost_matrix(query.terminals, query.v0, query.wind)
            paths = arcs(query.terminals, vorticity(query.wind) / query.v0)
        outside = paths_outside(paths, query.region)
        if len(outside):
            i, j = divmod(int(outside[0]), paths.n_nodes)
            raise InputError(
                f"closed-form: the cheapest path from node {i} to node {j} over open country leaves the region or "
                f"enters a no-fly zone ({len(outside)} paths do), and around walls there is no closed form: try refined"
            )
        progress(1.0, "arcs")
        return MovingCosts(cost, paths)


def _quickest(query: Query) -> Floats:
    """Return the flight times [s] between all terminals in a uniform wind; InputError in any other."""
    if not isinstance(query.wind, Uniform):
        raise InputError(
            f"closed-form: flight time has one in a uniform wind only, not in {type(query.wind).__name__}: try refined"
        )
    p, n = query.terminals, len(query.terminals)
    i, j = np.nonzero(~np.eye(n, dtype=bool))
    cost = np.zeros((n, n))
    cost[i, j] = zermelo_times(p[i], p[j] - p[i], query.wind, query.v0)
    return cost


def arcs(points: Floats, curvature: float) -> Paths:
    """Return arcs of one signed curvature [1/m], positive to the left, between all `points` (n, 2) [m]."""
    n = len(points)
    i, j = np.nonzero(~np.eye(n, dtype=bool))
    chord = points[j] - points[i]
    d = np.hypot(*chord.T)
    phi = np.arcsin(0.5 * curvature * d)
    pieces = max(1, math.ceil(2 * float(np.abs(phi).max(initial=0.0)) / TURN))
    t = np.linspace(-1.0, 1.0, pieces + 1)
    if curvature:
        theta = phi[:, None] * t
        along = np.sin(theta) / curvature + 0.5 * d[:, None]
        left = -2 * np.sin(0.5 * (phi[:, None] + theta)) * np.sin(0.5 * (phi[:, None] - theta)) / curvature
    else:
        along, left = 0.5 * d[:, None] * (1 + t), np.zeros((len(d), len(t)))
    tangent = chord / d[:, None]
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    line = points[i][:, None] + along[..., None] * tangent[:, None] + left[..., None] * normal[:, None]
    sizes = np.zeros(n * n, dtype=np.int64)
    sizes[i * n + j] = len(t)
    return Paths(n, line.reshape(-1, 2), np.concatenate([[0], np.cumsum(sizes)]))


def open_country(scenario: Scenario) -> Instance:
    """Return the instance whose legs may leave the region of `scenario`; InputError where there is no closed form."""
    points = scenario.points
    metric = wind_metric(scenario.speed, scenario.wind)
    provenance = {**scenario.provenance, "metric": metric}
    if len(points) > MATRIX_NODES:
        size = scenario.n_tasks, scenario.n_depots
        return Instance.of_metric(scenario.name, metric, points, *size, provenance=provenance)
    cost = cost_matrix(points, scenario.speed, scenario.wind)
    return Instance(scenario.name, cost, scenario.n_tasks, scenario.n_depots, points, provenance)


def straight_legs(scenario: Scenario) -> Instance:
    """Return the instance whose legs are straight, for a wind that is a rotation Ω.

    With Q = P − o, o the middle of the region,  C_ij = |Q_j − Q_i|/v0 − [w(o)·(Q_j − Q_i) + Ω Q_i × Q_j]/v0².
    """
    wind, v0 = scenario.wind, scenario.speed
    assert isinstance(wind, Rotation)
    x0, y0, x1, y1 = scenario.region.bounds
    middle = np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1)])
    u, v = wind([middle])[0]
    q = scenario.points - middle
    x, y = q.T
    along = u * np.subtract.outer(x, x).T + v * np.subtract.outer(y, y).T
    cross = np.outer(x, y) - np.outer(y, x)
    cost = moving_cost(moving_cost(distances(q) / v0, along, v0), wind.rate * cross, v0)
    np.fill_diagonal(cost, 0.0)
    return Instance(scenario.name, cost, scenario.n_tasks, scenario.n_depots, scenario.points, scenario.provenance)
