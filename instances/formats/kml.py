"""A tour as KML (OGC 07-147r2 and later): a line and a place mark for the depot and each task.

Heights above the ground are in ``altitudeMode`` relativeToGround, all others above mean sea level in absolute.

Written by hand: simplekml (1.3) gives every element an id, and points an order of elements, that the schema of KML does
not allow, and fastkml refuses its files.
"""

from __future__ import annotations

from xml.sax.saxutils import escape

from instances.arrays import Floats
from instances.formats.tour import Tour


def kml(tour: Tour, positions: Floats, frame: str) -> str:
    """Return the document of `tour`, whose `positions` (k, 2) are latitudes and longitudes [degrees]."""
    above_ground = frame == "above-ground"
    heights = tour.heights_in("above-ground" if above_ground else "amsl")
    mode = f"<altitudeMode>{'relativeToGround' if above_ground else 'absolute'}</altitudeMode>"
    written = [
        f"{lon:.8f},{lat:.8f},{height:.2f}"
        for (lat, lon), height in zip(positions.tolist(), heights.tolist(), strict=True)
    ]
    places = "".join(
        f"<Placemark><name>{escape('depot' if k == 0 else f'task {task}')}</name>"
        f"<Point>{mode}<coordinates>{written[k]}</coordinates></Point></Placemark>\n"
        for k, task in enumerate(tour.tasks)
        if k == 0 or task is not None
    )
    line = " ".join([*written, written[0]])
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2"><Document>\n'
        f"<name>{escape(tour.name)}</name>\n<description>{escape(tour.said_of_heights(frame))}</description>\n"
        f"<Placemark><name>{escape(tour.name)}</name>"
        f"<LineString>{mode}<coordinates>{line}</coordinates></LineString></Placemark>\n{places}</Document></kml>\n"
    )
