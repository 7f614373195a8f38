"""sgptools: waypoints as inducing points of a sparse Gaussian process, by the library of that name.

With P the waypoints of all UAVs and Z(P) places along the legs, `rate` on each, the library maximises

    ELBO of the process with inducing points Z(P) and zeros as data at the targets − PENALTY Σ_k max(0, L_k(P) − L)

(K. Jakkala, S. Akella, Multi-Robot Informative Path Planning from Regression with Sparse Gaussian Processes, 2024). Its
paths end anywhere; here its transform is given the depot before the first and after the last waypoint. It begins, as in
its examples, with k-means centres of the targets, routed by OR-Tools for SECONDS, so that plans vary with the machine.
Waypoints outside the region go to its border, and a tour that is longer than it may be is shrunk about its depot.
"""

from __future__ import annotations

import contextlib
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
import shapely

from formulations.limits import Limits
from formulations.surveying.problem import Sensor, SurveyPlanner, SurveyProblem, Tours, length_of
from instances.arrays import Floats

PENALTY = 100.0
"""Nats for every quarter of a length scale that a tour is too long."""
SECONDS = 5
"""Of routing, by the clock."""
MARGIN = 1e-9
"""Share of the length that shrinking leaves for rounding."""


@dataclass(frozen=True)
class SparseGp(SurveyPlanner):
    """ContinuousSGP and IPPTransform of sgptools 2.

    waypoints : of each UAV, between its depot and its depot (at least 1).
    rate : places on each leg at which the process is told of it, ends included (at least 2).
    steps : of L-BFGS-B (at least 1).
    """

    waypoints: int = 14
    rate: int = 4
    steps: int = 300

    def accepts(self, problem: SurveyProblem) -> str | None:
        """Decline where the library is missing, and regions in which a straight leg may leave the region."""
        if missing := [name for name in ("sgptools", "gpflow", "tensorflow") if find_spec(name) is None]:
            return f"{missing[0]} is not installed (docs/methods/surveys.md says how)"
        if problem.measure is not None:
            return "sgptools knows no wind"
        return None if problem.is_convex else "legs are straight, so the region must be convex"

    def prepare(self, problem: SurveyProblem) -> None:
        """Import, which takes seconds."""
        _library()

    def plan(self, problem: SurveyProblem, sensor: Sensor, *, limits: Limits, seed: int) -> Tours:
        """Return the library's plan, made to fit."""
        unit = 0.25 * min(problem.kernel.length_scales)
        with contextlib.redirect_stdout(sys.stderr):  # what it prints is not ours to say
            found = unit * self._planned(problem, unit, seed)
        return [fitted(problem, path) for path in found]

    def _planned(self, problem: SurveyProblem, unit: float, seed: int) -> Floats:
        """Return closed paths, shape (m, waypoints + 2, 2) [unit]."""
        library, targets, depots = _library(), problem.targets / unit, problem.depots / unit
        count, length = max(1, self.waypoints), problem.length / unit
        begin, _ = library.run_tsp(
            library.get_inducing_pts(targets, count * len(depots), seed=seed),
            num_vehicles=len(depots),
            max_dist=length,
            start_nodes=depots,
            end_nodes=depots,
            resample=count + 2,
            time_limit=SECONDS,
        )
        if begin is None:
            raise RuntimeError("sgptools found no tours to begin with")
        transform = closed_at(library.IPPTransform, depots)(
            sampling_rate=max(2, self.rate), distance_budget=length, num_robots=len(depots), constraint_weight=PENALTY
        )
        kernel = library.RBF(problem.kernel.signal_sd**2, np.asarray(problem.kernel.length_scales) / unit)
        method = library.ContinuousSGP(
            count,
            targets,
            kernel,
            problem.noise_sd**2,
            transform=transform,
            num_robots=len(depots),
            X_init=np.asarray(begin)[:, 1:-1].reshape(-1, 2),
        )
        return np.asarray(method.optimize(max_steps=max(1, self.steps), optimizer="scipy.L-BFGS-B"))


@dataclass(frozen=True)
class _Library:
    """What is used of it."""

    ContinuousSGP: Any
    IPPTransform: Any
    RBF: Any
    get_inducing_pts: Any
    run_tsp: Any


def _library() -> _Library:
    from gpflow.kernels import RBF
    from sgptools.core.transformations import IPPTransform
    from sgptools.methods import ContinuousSGP
    from sgptools.utils.misc import get_inducing_pts
    from sgptools.utils.tsp import run_tsp

    return _Library(ContinuousSGP, IPPTransform, RBF, get_inducing_pts, run_tsp)


def closed_at(transform: type[Any], depots: Floats) -> type[Any]:
    """Return `transform` (IPPTransform) with every path from and back to its row of `depots` (m, 2)."""

    class Closed(transform):  # type: ignore[misc]
        """Adds the ends, which stay, before the library samples and measures paths."""

        def expand(self, Xu: Any, expand_sensor_model: bool = True, **rest: Any) -> Any:
            import tensorflow as tf

            ends, inner = tf.constant(depots[:, None]), tf.reshape(Xu, (len(depots), -1, 2))
            paths = tf.concat([ends, inner, ends], axis=1)
            return super().expand(tf.reshape(paths, (-1, 2)), expand_sensor_model, **rest)

    return Closed


def fitted(problem: SurveyProblem, tour: Floats) -> Floats:
    """Return `tour` (k, 2) [m] with its vertices in the convex region and no longer than it may be."""
    area = problem.region.polygon
    inside = shapely.get_coordinates(shapely.shortest_line(area, shapely.points(tour)))[::2]
    inside[[0, -1]] = tour[0]
    share = min(1.0, problem.length * (1.0 - MARGIN) / max(length_of(inside), MARGIN))
    return np.asarray(tour[0] + share * (inside - tour[0]))
