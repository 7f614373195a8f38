"""The family `corridor`: a non-convex region, a square crossed by walls, and legs that must keep inside.

Walls stand alternately on the lower and the upper side and leave an opening at their other end, so that the region is
one winding corridor.
"""

from __future__ import annotations

from shapely.geometry import Polygon

from instances.environment.region import Region
from instances.errors import InputError
from instances.families import depots, winds
from instances.families.family import Family, Legs
from instances.families.parameter import Parameter, Values
from instances.families.square import SIZE, uniform_tasks


def winding(values: Values) -> Region:
    """Return the square [0, size]² without its walls, one polygon."""
    size, walls, opening, thickness = (values[key] for key in ("size", "walls", "opening", "thickness"))
    if not opening < size:
        raise InputError(f"family corridor: opening must be below size = {size:g} m, got {opening:g} m")
    if not walls * thickness < size:
        raise InputError(f"family corridor: {walls} walls of thickness {thickness:g} m fill the size of {size:g} m")
    lane = (size - walls * thickness) / (walls + 1)
    left = [lane + wall * (lane + thickness) for wall in range(walls)]
    tip = size - opening
    ring = [(0.0, 0.0)]
    for x in left[0::2]:  # those that stand on the lower side, from left to right
        ring += [(x, 0.0), (x, tip), (x + thickness, tip), (x + thickness, 0.0)]
    ring += [(size, 0.0), (size, size)]
    for x in reversed(left[1::2]):  # those that hang from the upper side, from right to left
        ring += [(x + thickness, size), (x + thickness, opening), (x, opening), (x, size)]
    return Region(Polygon([*ring, (0.0, size)]))


CORRIDOR = Family(
    "corridor",
    (
        SIZE,
        Parameter("walls", 3, "", "number of walls", at_least=0),
        Parameter("opening", 4_000.0, "m", "gap between a wall's free end and the other side", at_least=1e-3),
        Parameter("thickness", 400.0, "m", "thickness of the walls", at_least=1e-3),
        *winds.PARAMETERS,
        *depots.PARAMETERS,
    ),
    winding,
    uniform_tasks,
    legs=Legs.INSIDE,
)
