"""Worth: what a set S of tasks is worth, modular prizes or information.

    f(S) = Σ_{i∈S} p_i + ½ log det C[S] − ½ log det D[S],      f(∅) = 0

* Prizes: C and D absent. Team orienteering.
* Information gain (criterion "ig"): p = 0, C = I + K/σ². Monotone and submodular.
* Criteria "b" and "a" (formulations/task_location/criterion.py): C as before, D = I + K_{T|o}/σ², the covariance of the
  field once the test points are known. Monotone, but *not* submodular: what a task adds may grow with what is there.
  Both halves are submodular on their own, which is what bounds rest on (`overestimates.py`).

C ⪰ D ⪰ I, so no determinant is small and Schur complements lose nothing that matters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from formulations.kernel import SquaredExponential
from formulations.task_location.criterion import Convention, Criterion, convention
from instances.arrays import Bools, Floats
from instances.environment.value_map import ValueMap
from instances.errors import InputError, shown

LARGEST_PRIZE = 1e15
"""Sums of whole prizes stay exact in float64 up to about here."""
_STACKED = 20_000
"""Matrices whose determinants are taken at once."""


@dataclass(frozen=True, eq=False)
class Worth:
    """What sets of n tasks are worth.

    prizes : p ≥ 0, shape (n,).
    prior : C, shape (n, n), or None.
    posterior : D, shape (n, n), or None; only beside `prior`.
    about : how it was made, JSON values: ``prizes``, or the criterion's parameters; `worth_of` makes it again.
    """

    prizes: Floats
    prior: Floats | None
    posterior: Floats | None
    about: Mapping[str, Any]

    @classmethod
    def of_prizes(cls, prizes: ArrayLike) -> Worth:
        """Return the worth of modular prizes; InputError names one that is negative or no number."""
        try:
            p = np.array(prizes, dtype=float)
        except (TypeError, ValueError, OverflowError):
            p = np.empty((0, 0))
        if p.ndim != 1:
            raise InputError(f"prizes must be a list of numbers, got {shown(prizes)}")
        for i in np.flatnonzero(~((p >= 0) & (p <= LARGEST_PRIZE))).tolist():
            raise InputError(f"prizes[{i}] must be from 0 to {LARGEST_PRIZE:g}, got {p[i]}")
        return cls(p, None, None, {"prizes": p.tolist()})

    @classmethod
    def of_information(cls, criterion: Criterion, tasks: Floats) -> Worth:
        """Return the information [nats] of reading at `tasks` (n, 2) [m] under a criterion."""
        covariance = criterion.kernel(tasks, tasks)
        prior = np.eye(len(tasks)) + covariance / criterion.noise
        posterior = None
        if criterion.convention is not Convention.INFORMATION_GAIN:
            phi = criterion.features(tasks)
            left = criterion.posterior(covariance, phi, phi)
            posterior = np.eye(len(tasks)) + 0.5 * (left + left.T) / criterion.noise
        return cls(np.zeros(len(tasks)), prior, posterior, _about(criterion))

    @property
    def n_tasks(self) -> int:
        """Number of tasks, n."""
        return self.prizes.size

    @property
    def modular(self) -> bool:
        """Whether the worth is a sum over the tasks."""
        return self.prior is None

    @property
    def subadditive(self) -> bool:
        """Whether the worth of a set is at most the sum of the worths of its parts, and not simply that sum."""
        return self.prior is not None and self.posterior is None

    @property
    def unit(self) -> str:
        """What it is measured in."""
        return "prize" if self.modular else "nats"

    @cached_property
    def step(self) -> float:
        """The largest number that every worth is a multiple of; 0 where there is none: prizes not whole, or nats."""
        if not self.modular or (self.prizes % 1).any() or self.prizes.sum() > LARGEST_PRIZE:
            return 0.0
        return float(math.gcd(*map(int, self.prizes.tolist())))

    @property
    def rounding(self) -> float:
        """More than what computing f(S) in floating point can be off by: summation, and log det with C ⪰ I."""
        total = float(self.prizes.sum())
        if self.prior is None:
            return self.n_tasks * 2.0**-52 * total
        largest = float(np.trace(self.prior))
        return self.n_tasks * 2.0**-52 * (total + self.n_tasks * largest)

    def value(self, tasks: Sequence[int]) -> float:
        """Return f of some tasks."""
        chosen = sorted(tasks)
        worth = float(self.prizes[chosen].sum())
        for sign, matrix in ((0.5, self.prior), (-0.5, self.posterior)):
            if matrix is not None and chosen:
                worth += sign * float(np.linalg.slogdet(matrix[np.ix_(chosen, chosen)])[1])
        return worth

    def of_sets(self, holds: Bools) -> Floats:
        """Return f of sets given as rows, `holds` (p, n), shape (p,): those of one size at a time."""
        worth, sizes = holds @ self.prizes, holds.sum(axis=1)
        for size in np.unique(sizes[sizes > 0]):
            rows = np.flatnonzero(sizes == size)
            for part in np.array_split(rows, len(rows) // _STACKED + 1):
                chosen = np.nonzero(holds[part])[1].reshape(len(part), size)
                for sign, matrix in ((0.5, self.prior), (-0.5, self.posterior)):
                    if matrix is not None:
                        stacked = matrix[chosen[:, :, None], chosen[:, None, :]]
                        worth[part] += sign * np.linalg.slogdet(stacked)[1]
        return np.asarray(worth, dtype=float)

    def of_all_sets(self) -> Floats:
        """Return f(S) for every set S (bit i is task i), shape (2ⁿ,); memory grows like 2ⁿ."""
        worth = np.zeros(1)
        for prize in self.prizes:
            worth = np.concatenate([worth, worth + prize])
        for sign, matrix in ((0.5, self.prior), (-0.5, self.posterior)):
            if matrix is not None:
                worth = worth + sign * _log_det_of_all_sets(matrix)
        return worth

    def bound(self, value: float) -> float:
        """Return a bound on f(S) rounded down to what f can be; `value` is one already."""
        return math.floor(value / self.step) * self.step if self.step > 0 and math.isfinite(value) else value


def worth_of(about: Mapping[str, Any], n_tasks: int, coordinates: Floats | None) -> Worth:
    """Return the worth that `Worth.about` describes, of the first `n_tasks` of `coordinates` (n+m, 2) [m].

    Raises InputError where a parameter is missing or unfit, or information is asked of tasks without coordinates.
    """
    if "prizes" in about:
        worth = Worth.of_prizes(about["prizes"])
    else:
        if coordinates is None:
            raise InputError("the instance has no coordinates, so information cannot be told: give prizes")
        worth = Worth.of_information(_criterion(about, coordinates[:n_tasks]), coordinates[:n_tasks])
    if worth.n_tasks != n_tasks:
        raise InputError(f"there are {worth.n_tasks} prizes for {n_tasks} tasks")
    return worth


def _about(criterion: Criterion) -> dict[str, Any]:
    about: dict[str, Any] = {
        "criterion": str(criterion.convention),
        "signal_sd": criterion.kernel.signal_sd,
        "length_scales": list(criterion.kernel.length_scales),
        "noise_sd": criterion.noise_sd,
    }
    if (mapped := criterion.kernel.relative_sd) is not None:
        about["relative_sd"] = {name: getattr(mapped, name).tolist() for name in ("x", "y", "values")}
    if criterion.convention is not Convention.INFORMATION_GAIN:
        assert criterion.weights is not None
        about["test_noise_sd"] = criterion.test_noise_sd
        about["tests"], about["weights"] = criterion.tests.tolist(), criterion.weights.tolist()
    return about


def _criterion(about: Mapping[str, Any], tasks: Floats) -> Criterion:
    try:
        scales = [float(scale) for scale in about["length_scales"]]
        mapped = about.get("relative_sd")
        relative_sd = None if mapped is None else ValueMap(mapped["x"], mapped["y"], mapped["values"])
        kernel = SquaredExponential(float(about["signal_sd"]), (scales[0], scales[-1]), relative_sd)
        tests, weights = about.get("tests", tasks), about.get("weights")
        noise = about.get("test_noise_sd")
        chosen = convention(str(about["criterion"]))
        return Criterion(kernel, tests, weights, float(about["noise_sd"]), noise, chosen)
    except KeyError as error:
        raise InputError(f"the worth lacks {error.args[0]!r}") from None
    except (TypeError, ValueError, IndexError) as error:
        raise InputError(f"the worth cannot be told ({error})") from None


def _log_det_of_all_sets(matrix: Floats) -> Floats:
    """Return log det of every principal submatrix, (2ⁿ,): task by task, with and without it (Schur complement)."""
    n = len(matrix)
    log_det, rest = np.zeros(1), matrix[None]
    for i in reversed(range(n)):  # the last task first: it is the highest bit
        pivot, column = rest[:, i, i], rest[:, :i, i]
        within = rest[:, :i, :i] - column[:, :, None] * column[:, None, :] / pivot[:, None, None]
        log_det = np.stack([log_det, log_det + np.log(pivot)], axis=1).reshape(-1)
        rest = np.stack([rest[:, :i, :i], within], axis=1).reshape(len(log_det), i, i)
    return log_det
