"""What a Newton step of a path is made of, whatever the cost: derivatives by sideways moves of a polyline's nodes."""

from __future__ import annotations

import math
from typing import NamedTuple

from instances.arrays import Floats

GAUSS_1, GAUSS_2 = 0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)
"""Gauss's two points in (0, 1), each of weight ½."""


class Terms(NamedTuple):
    """Derivatives of speed × cost [m] by the moves y_k [m] of the nodes along their normals, each (n,).

    g : the gradient. The Hessian is tridiagonal: `diagonal` + `bend` in it, `off` + `off_bend` right of it, where
    `diagonal` and `off` are the part that is never negative, that of a wind which does not change from place to place.
    """

    g: Floats
    diagonal: Floats
    bend: Floats
    off: Floats
    off_bend: Floats
