"""A tour as MAVLink mission items: take off, set the speed, fly the waypoints, come home.

Commands and frames are those of MAVLink's common message set (https://mavlink.io/en/messages/common.html): MAV_CMD 22
(take off), 178 (change speed), 16 (waypoint), 20 (return to launch), 21 (land); MAV_FRAME 0 (height above mean sea
level), 3 (above home), 10 (above the ground) and 2 (no place). Files hold degrees as numbers, hence no ``_INT`` frames.
"""

from __future__ import annotations

from dataclasses import dataclass

from instances.arrays import Floats
from instances.errors import InputError, shown
from instances.formats.tour import Tour

WAYPOINT, RETURN, LAND, TAKE_OFF, CHANGE_SPEED = 16, 20, 21, 22, 178
AMSL, MISSION, ABOVE_HOME, ABOVE_GROUND = 0, 2, 3, 10
FRAME = {"amsl": AMSL, "above-home": ABOVE_HOME, "above-ground": ABOVE_GROUND}

FIRMWARE = {"px4": 12, "ardupilot": 3}
"""Firmware → MAV_AUTOPILOT."""
KINDS = {"fixed-wing": 1, "multirotor": 2}
"""Kind of vehicle → MAV_TYPE; QGroundControl takes the quadrotor's for any multirotor."""

CLIMB_PITCH = 15.0
"""Least pitch of a fixed wing while it takes off [degrees]."""
AIRSPEED, GROUND_SPEED = 0.0, 1.0
"""SPEED_TYPE."""
UNCHANGED = -1.0


@dataclass(frozen=True)
class Vehicle:
    """What flies: firmware, one of FIRMWARE, and kind, one of KINDS; InputError for another."""

    firmware: str = "px4"
    kind: str = "fixed-wing"

    def __post_init__(self) -> None:
        for name, value, known in (("firmware", self.firmware, FIRMWARE), ("vehicle", self.kind, KINDS)):
            if value not in known:
                raise InputError(f"{name} must be one of {', '.join(known)}, got {shown(value)}")


@dataclass(frozen=True)
class Item:
    """A mission item: MAV_CMD, MAV_FRAME, param1 to param4 (None: the autopilot's own), place and height.

    place : latitude and longitude [degrees], None where the command has none. height [m] in `frame`. above_ground [m]:
    what a height above mean sea level was made from, None where it is one of its own.
    """

    command: int
    frame: int
    params: tuple[float | None, float | None, float | None, float | None]
    place: tuple[float, float] | None = None
    height: float = 0.0
    above_ground: float | None = None


def mission_items(tour: Tour, positions: Floats, frame: str, vehicle: Vehicle) -> list[Item]:
    """Return the items of `tour`, whose `positions` (k, 2) are latitudes and longitudes, heights in `frame`.

    A fixed wing takes off towards the next waypoint (PX4 climbs in the direction of the item's place), is told its
    airspeed and returns to launch; a multirotor takes off over home, is told its ground speed and lands at home.
    """
    home, *rest = [(lat, lon) for lat, lon in positions.tolist()]
    back, *waypoints = _waypoints(tour, [home, *rest], frame, vehicle)
    winged = vehicle.kind == "fixed-wing"
    speed = Item(CHANGE_SPEED, MISSION, (AIRSPEED if winged else GROUND_SPEED, tour.speed, UNCHANGED, 0.0))
    end = (
        Item(RETURN, MISSION, (0.0, 0.0, 0.0, 0.0))
        if winged
        else Item(LAND, ABOVE_HOME, (0.0, 0.0, 0.0, None), home, 0.0)
    )
    towards = rest[0] if winged and rest else home
    return [_take_off(tour, towards, frame, winged), speed, *waypoints, back, end]


def _take_off(tour: Tour, place: tuple[float, float], frame: str, winged: bool) -> Item:
    """Return the take-off to the tour's first height: above home, or above sea level where no more is known."""
    params = (CLIMB_PITCH if winged else 0.0, 0.0, 0.0, None)
    climb = tour.climb(frame)
    if climb is None:
        return Item(TAKE_OFF, AMSL, params, place, float(tour.heights[0]))
    return Item(TAKE_OFF, ABOVE_HOME, params, place, climb)


def _waypoints(tour: Tour, places: list[tuple[float, float]], frame: str, vehicle: Vehicle) -> list[Item]:
    """Return an item a point.

    PX4 takes no height above the ground (it refuses MAV_FRAME 10) and is given the same height above mean sea level.
    """
    heights = tour.heights_in(frame).tolist()
    params = (0.0, 0.0, 0.0, None)
    if frame == "above-ground" and vehicle.firmware == "px4":
        return [
            Item(WAYPOINT, AMSL, params, place, amsl, above)
            for place, amsl, above in zip(places, tour.heights.tolist(), heights, strict=True)
        ]
    return [Item(WAYPOINT, FRAME[frame], params, *at) for at in zip(places, heights, strict=True)]
