"""The spacing ratio ρ: how far tasks lie apart, in turning radii. It says whether turns are to be planned with.

    ρ = √(A/n) / r_min,   A the area, n the number of tasks: √(A/n) is the side of a task's share of the area

Routes that ignore turns, with the best headings put in afterwards, lose nothing that can be measured above ρ ≈ 10,
up to a few percent between 5 and 10, and 10 to 60 % below 4 (docs/methods/turns.md).
"""

from __future__ import annotations

import math

from instances.errors import InputError

COUPLE_BELOW = 5.0
"""Turns are to be planned with where ρ is below this."""
IGNORE_ABOVE = 10.0
"""They are not worth their time where ρ is above this."""


def spacing_ratio(area: float, n_tasks: int, radius: float) -> float:
    """Return ρ (dimensionless) of `n_tasks` tasks in `area` [m²] flown with turning radius `radius` [m]."""
    if not (area > 0 and n_tasks >= 1 and radius > 0):
        raise InputError(
            f"area, number of tasks and turning radius must be positive, got {area} m², {n_tasks} and {radius} m"
        )
    return math.sqrt(area / n_tasks) / radius


def advice(ratio: float) -> str:
    """Return what the spacing ratio means for a plan, in a few words."""
    if ratio < COUPLE_BELOW:
        return "turns count: plan routes and headings together"
    if ratio > IGNORE_ABOVE:
        return "turns hardly count: routes planned without them are as good"
    return "turns count a little: planning routes and headings together may gain a few percent"
