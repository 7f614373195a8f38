"""A field that drifts: its shadowing forgets itself, as an Ornstein–Uhlenbeck process in time.

    S(t + d) = ρ S(t) + √(1 − ρ²) W,   ρ = exp(−d/τ)

is its exact transition (G. E. Uhlenbeck & L. S. Ornstein, Physical Review 36, 1930), every W drawn like S itself: at
any time the shadowing has the same covariance over the plane, and over time its correlation is exp(−|t − t′|/τ).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from instances.arrays import Floats
from instances.environment.radio import RadioMap
from instances.errors import InputError

EARLY = 1e-9
"""A time so little before a frame, in steps, is that frame's."""


class DriftingField:
    """A field in frames, one a step; between two frames it is the earlier one.

    still : what does not drift. drawn : frame's number → W, shape of the values of `still`; of frame 0 it is S itself.
    tau, step [s] : positive. The same draws make the same frames, whatever is asked in which order. Frames are made
    where they are asked for, and only the last one is kept.
    """

    def __init__(self, still: RadioMap, drawn: Callable[[int], Floats], tau: float, step: float) -> None:
        if not (tau > 0 and step > 0):
            raise InputError(f"a field that drifts needs tau and step positive, got {tau} s and {step} s")
        self.still, self.drawn, self.step = still, drawn, step
        self.kept = math.exp(-step / tau)
        self.number, self.shadowing = 0, drawn(0)

    @property
    def unit(self) -> str:
        """Unit of the field."""
        return self.still.unit

    def at(self, time: float) -> RadioMap:
        """Return the field at `time` ≥ 0 [s]."""
        number = int(time / self.step + EARLY)
        if number < self.number:
            self.number, self.shadowing = 0, self.drawn(0)
        while self.number < number:
            self.number += 1
            fresh = math.sqrt(1.0 - self.kept**2)
            self.shadowing = self.kept * self.shadowing + fresh * self.drawn(self.number)
        return replace(self.still, values=self.still.values + self.shadowing)
