"""MAVLink's plain-text mission, ``.waypoints``: a line an item, fields apart by tabs.

The format is MAVLink's Mission Plain-Text File Format (https://mavlink.io/en/file_formats/), version 110: index,
current, frame, command, param1 to param4, latitude, longitude, height, autocontinue. Line 0 is home, as ArduPilot keeps
it and as QGroundControl reads it for PX4 too. It holds neither fence nor rally point.
"""

from __future__ import annotations

from collections.abc import Sequence

from instances.arrays import Floats
from instances.formats.mavlink_items import AMSL, WAYPOINT, Item, Vehicle
from instances.formats.tour import Tour


def waypoints(tour: Tour, home: Floats, items: Sequence[Item], vehicle: Vehicle) -> str:
    """Return the file of `tour` from `home` (latitude, longitude).

    What the autopilot may choose is NaN for PX4; ArduPilot and Mission Planner write 0.
    """
    lat, lon = home.tolist()
    own = "nan" if vehicle.firmware == "px4" else "0"
    lines = [
        _line(number, item, own)
        for number, item in enumerate([Item(WAYPOINT, AMSL, (0.0, 0.0, 0.0, 0.0), (lat, lon), tour.home), *items])
    ]
    return "".join(f"{line}\n" for line in ("QGC WPL 110", *lines))


def _line(number: int, item: Item, own: str) -> str:
    params = [own if value is None else f"{value:g}" for value in item.params]
    lat, lon = (0.0, 0.0) if item.place is None else item.place
    current = int(number == 0)
    fields = [number, current, item.frame, item.command, *params, f"{lat:.8f}", f"{lon:.8f}", f"{item.height:.3f}", 1]
    return "\t".join(map(str, fields))
