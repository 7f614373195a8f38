"""Flights of planned headings: through the stops of a tour with the headings that its plan chose, leg by leg.

Where the plan was made in a steady wind, headings are those of the air, each leg is flown at constant airspeed by the
turns and lines that the plan priced (`moving_cost.turns.wind`), and drifts.
"""

from __future__ import annotations

import numpy as np

from formulations.mapping.flight import Flight
from formulations.moving_cost.turns.tracks import FINE, flown_legs, tracks
from formulations.moving_cost.turns.travel import Turns
from instances.arrays import Floats


def planned_flight(places: Floats, headings: Floats, turns: Turns) -> tuple[Flight, list[Floats]]:
    """Return the flight through `places` (w, 2) [m] with `headings` (w,) [rad], and its track leg by leg [m].

    The first place is the depot and the last one, too; fewer than two are a UAV that stays home.
    """
    wind = None if turns.calm else turns.wind
    if len(places) < 2:
        none = np.empty((0, 3))
        return Flight(none, np.empty(0, dtype=np.int64), none, turns.radius, turns.speed, wind=wind), []
    poses = np.column_stack([places, headings])
    words, segments = flown_legs(poses[:-1], poses[1:], turns)
    flight = Flight(poses[:-1], words, segments, turns.radius, turns.speed, wind=wind)
    lines = tracks(poses[:-1], words, segments, turns, FINE)
    return flight, [np.array(line.coords) for line in lines]
