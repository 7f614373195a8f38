"""Where a UAV measures along its path: every period, legs being flown evenly, and how that moves with the waypoints.

Sample i is taken at time i·p after the start, on the leg k that begins at T_k = Σ_{j<k} τ_j and lasts τ_k:

    x_i = Q_k + f_i (Q_{k+1} − Q_k),   f_i = (i p − T_k)/τ_k,   df_i = −(dT_k + f_i dτ_k)/τ_k

so that stretching a leg moves the samples of all that is flown after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats, Ints


def count_of(duration: float, period: float) -> int:
    """Return how many samples a flight of `duration` [s] takes, one every `period` [s] after its start."""
    return int(duration / period + 1e-9)


def times_of(counts: Sequence[int], period: float) -> Floats:
    """Return when the samples of several flights are taken, so many of each, one flight after the other [s]."""
    return np.concatenate([np.empty(0), *(period * np.arange(1.0, count + 1.0) for count in counts)])


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of one path: of each the leg it is taken on, (n,), the share f of it flown by then, and its place [m]."""

    path: Floats
    durations: Floats
    leg: Ints
    share: Floats

    @classmethod
    def along(cls, path: Floats, durations: Floats, period: float, count: int) -> Samples:
        """Return `count` samples along `path` (w + 1, 2) [m] whose legs last `durations` (w,) [s].

        Those after landing are taken at its end.
        """
        times = period * np.arange(1, count + 1)
        ends = np.cumsum(durations)
        leg = np.minimum(np.searchsorted(ends, times), len(durations) - 1)
        share = (times - (ends - durations)[leg]) / np.maximum(durations[leg], 1e-300)
        return cls(path, durations, leg, np.minimum(share, 1.0))

    @property
    def places(self) -> Floats:
        """Where the samples are taken, shape (n, 2) [m]."""
        a, b = self.path[self.leg], self.path[self.leg + 1]
        return np.asarray(a + self.share[:, None] * (b - a))

    def pulled(self, slopes: Floats, duration_slopes: Floats) -> Floats:
        """Return the slopes by the places of the path, (w + 1, 2), of what has `slopes` (n, 2) by the samples' places.

        duration_slopes : ∂τ/∂ start and end of each leg [s/m], (w, 2, 2).
        """
        pulled = np.zeros_like(self.path)
        np.add.at(pulled, self.leg, (1.0 - self.share)[:, None] * slopes)
        np.add.at(pulled, self.leg + 1, self.share[:, None] * slopes)
        legs = np.diff(self.path, axis=0)[self.leg]
        flying = self.share < 1.0
        by_begin = np.where(flying, -(slopes * legs).sum(axis=1) / np.maximum(self.durations[self.leg], 1e-300), 0.0)
        count = len(self.durations)
        begins = np.bincount(self.leg, by_begin, minlength=count)
        by_duration = np.bincount(self.leg, by_begin * self.share, minlength=count)
        by_duration += np.cumsum(begins[::-1])[::-1] - begins  # T_k is the sum of the durations before
        pulled[:-1] += by_duration[:, None] * duration_slopes[:, 0]
        pulled[1:] += by_duration[:, None] * duration_slopes[:, 1]
        return pulled
