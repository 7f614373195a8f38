"""A UAV's tour as waypoints for ground-control software, with its heights in the frame that is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats
from instances.errors import InputError, shown

FRAMES = ("amsl", "above-home", "above-ground")
"""What a height is measured from: mean sea level, the ground at home, the ground below each waypoint."""


@dataclass(frozen=True, eq=False)
class Tour:
    """One UAV's tour as waypoints.

    name; points (k, 2) [m], the first the depot, to which it returns; tasks (k,), which of the points are tasks, as
    task numbers, None for others; heights (k,) [m above mean sea level]; speed [m/s]; ground (k,) [m above mean sea
    level] below each point, None where it is not known. InputError where a point is not above its ground.
    """

    name: str
    points: Floats
    tasks: Sequence[int | None]
    heights: Floats
    speed: float
    ground: Floats | None = None

    def __post_init__(self) -> None:
        if self.ground is None:
            return
        lowest = int(np.argmin(self.heights - self.ground))
        height, ground = float(self.heights[lowest]), float(self.ground[lowest])
        if height <= ground:
            raise InputError(
                f"{self.name}: waypoint {lowest} at {height:.0f} m is not above the ground, which is at {ground:.0f} m"
            )

    @property
    def home(self) -> float:
        """Height of the ground at the depot [m above mean sea level]; 0 where it is not known."""
        return 0.0 if self.ground is None else float(self.ground[0])

    def climb(self, frame: str) -> float | None:
        """Return the first height above home [m]; None where it is not known: above sea level, ground unknown."""
        if self.ground is None and frame == "amsl":
            return None
        return float(self.heights[0]) - self.home

    def heights_in(self, frame: str) -> Floats:
        """Return the heights (k,) [m] in one of FRAMES; InputError for another, or where they need unknown ground."""
        if frame not in FRAMES:
            raise InputError(f"frame must be one of {', '.join(FRAMES)}, got {shown(frame)}")
        if frame == "amsl":
            return self.heights
        if frame == "above-home":
            return self.heights - self.home
        if self.ground is None:
            raise InputError("frame = 'above-ground' needs the height of the ground below each waypoint")
        return self.heights - self.ground

    def said_of_heights(self, frame: str) -> str:
        """Return a sentence about what the heights in `frame` start from."""
        if self.ground is None:
            return (
                f"Heights {frame}; the height of the ground is not known, so home is put at 0 m: set it in the field."
            )
        return f"Heights {frame}; home is on the ground at {self.home:.1f} m above mean sea level."
