"""Heights of a flown tour: level, or following the ground within the rates of climb and descent.

A track that is to stay at least `altitude` above the ground, rises at most `climb` and sinks at most `descent` metres a
metre flown is lowest at

    h(s) = max over s' of  ground(s') + altitude − climb · (s' − s)    for s' ≥ s (it has to climb in time)
                           ground(s') + altitude − descent · (s − s')  for s' ≤ s (it cannot sink faster)

which is a running maximum from either end. Distances are those over ground: a slope lengthens no track here. Take-off
and landing are at the depot, between its ground and the height of the tour's ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from formulations.mapping.flight import Flight
from instances.arrays import Floats
from instances.environment.terrain import Terrain

STEP = 1.0
"""Distance between heights of a track [m]; between two of them the ground rises by at most half its slope."""


class Frame(StrEnum):
    """What an altitude is above: mean sea level, the ground below the UAV, or the ground at its depot."""

    AMSL = "amsl"
    ABOVE_GROUND = "above-ground"
    ABOVE_HOME = "above-home"

    @property
    def words(self) -> str:
        """For people."""
        return {"amsl": "above mean sea level", "above-ground": "above the ground", "above-home": "above its depot"}[
            self
        ]


@dataclass(frozen=True, eq=False)
class Heights:
    """Track and ground, both [m above mean sea level], after `travelled` [m] of a tour: three arrays (k,)."""

    travelled: Floats
    track: Floats
    ground: Floats

    @property
    def nearest(self) -> int:
        """Where the track is nearest to the ground, or deepest below it: an index."""
        return int(np.argmin(self.track - self.ground))

    @property
    def clearance(self) -> float:
        """Least height of the track above the ground [m], negative below it."""
        return float(self.track[self.nearest] - self.ground[self.nearest])

    def at(self, travelled: ArrayLike) -> Floats:
        """Return the height of the track [m above mean sea level] after `travelled` metres, shape (k,)."""
        return np.interp(np.asarray(travelled, dtype=float), self.travelled, self.track)


@dataclass(frozen=True)
class Altitude:
    """How high to fly: `above` [m] in a frame, and the steepest climb and descent [m a metre flown]."""

    above: float
    frame: Frame
    climb: float
    descent: float


def heights_of(flight: Flight, wanted: Altitude, terrain: Terrain | None, step: float = STEP) -> Heights:
    """Return the heights of `flight` (not of length 0) over `terrain`, which is flat at 0 m where None."""
    s = np.append(np.arange(0.0, flight.length, step), flight.length)
    ground = np.zeros(len(s)) if terrain is None else terrain(flight.poses(s)[:, :2])
    if wanted.frame is Frame.ABOVE_GROUND:
        return Heights(s, following(s, ground + wanted.above, wanted.climb, wanted.descent), ground)
    base = ground[0] if wanted.frame is Frame.ABOVE_HOME else 0.0
    return Heights(s, np.full(len(s), base + wanted.above), ground)


def following(travelled: Floats, floor: Floats, climb: float, descent: float) -> Floats:
    """Return the least heights (k,) at or above `floor` (k,) [m] of slopes from −`descent` to `climb`."""
    sinking = np.maximum.accumulate(floor + descent * travelled) - descent * travelled
    rising = np.maximum.accumulate((floor - climb * travelled)[::-1])[::-1] + climb * travelled
    return np.maximum(np.maximum(sinking, rising), floor)
