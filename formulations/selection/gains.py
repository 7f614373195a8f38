"""Gains: what each task would add to the tasks chosen, kept up to date by Schur complements.

With A = C − C_S (C_SS)⁻¹ C_Sᵀ the prior's complement on the chosen set S, adding i to S adds ½ log A_ii to
½ log det C[S]; choosing i then turns A into A − a aᵀ / A_ii, a its column. Likewise for the posterior D.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.selection.tours import Data
from instances.arrays import Floats, Ints
from instances.kernels import njit


class Gains(NamedTuple):
    """Complements of `prior` and `posterior` (n, n) on what is chosen, or (0, 0), and the chosen set's `worth` (1,)."""

    prior: Floats
    posterior: Floats
    worth: Floats

    @classmethod
    def of(cls, data: Data) -> Gains:
        """Return the gains over no task."""
        return cls(data.prior.copy(), data.posterior.copy(), np.zeros(1))


@njit(cache=True)
def gain(data: Data, gains: Gains, task: int) -> float:
    """Return what a task that is not chosen would add."""
    more = data.prizes[task]
    if gains.prior.size:
        more += 0.5 * np.log(gains.prior[task, task])
    if gains.posterior.size:
        more -= 0.5 * np.log(gains.posterior[task, task])
    return more


@njit(cache=True)
def choose(data: Data, gains: Gains, task: int) -> None:
    """Add a task to those chosen."""
    gains.worth[0] += gain(data, gains, task)
    if gains.prior.size:
        _complement(gains.prior, task)
    if gains.posterior.size:
        _complement(gains.posterior, task)


@njit(cache=True)
def restart(data: Data, gains: Gains, tour: Ints) -> None:
    """Choose the tasks that have a tour, and no others."""
    gains.prior[:] = data.prior
    gains.posterior[:] = data.posterior
    gains.worth[0] = 0.0
    for task in range(tour.size):
        if tour[task] >= 0:
            choose(data, gains, task)


@njit(cache=True)
def _complement(matrix: Floats, task: int) -> None:
    n = matrix.shape[0]
    column = matrix[:, task].copy()
    pivot = column[task]
    for i in range(n):
        share = column[i] / pivot
        if i != task:
            for j in range(n):
                matrix[i, j] -= share * column[j]
    # the chosen task's own row and column are never read again
