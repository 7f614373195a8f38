"""What is wrong with what a solver claims: no solver grades itself.

A claim is believed only where the routes are feasible, their recomputed cost is the claimed one, and the claimed
bound does not contradict them. The parent process applies this to every run; what is stored is looked at again by
`reports.metrics.contradictions`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from formulations.routing.solver import Status
from instances import Instance, check_routes

ROUNDING = 1e-9
"""Relative difference between a claimed and the recomputed cost that floating point may explain."""
WIDEST_TOLERANCE = 1e-3
"""A proof to within more than this share of the cost is not called one."""


def refute_routes(instance: Instance, routes: Sequence[Sequence[int]]) -> str | None:
    """Return why `routes` [nodes] are not feasible, in a sentence, or None where they are."""
    faults = check_routes(instance, routes)
    if not faults:
        return None
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    return f"the routes are not feasible: {faults[0]}{more}"


def refute_cost(claimed: float | None, actual: float) -> str | None:
    """Return that the claimed longest tour [s] is not the recomputed one, with both numbers, or None where it is."""
    if claimed is not None and abs(claimed - actual) <= ROUNDING * max(abs(claimed), actual):
        return None
    return f"claimed a longest tour of {claimed!r} s, but its routes cost {actual!r} s"


def refute_bound(bound: float | None, objective: float | None, tolerance: float) -> str | None:
    """Return why `bound` [s] cannot be one, given the verified `objective` [s] of some routes, or None."""
    if bound is None:
        return None
    if not math.isfinite(bound):
        return f"claimed a bound of {bound!r} s, which is not a number"
    if objective is not None and bound > objective + max(tolerance, ROUNDING * objective):
        return f"claimed that no routes are shorter than {bound!r} s, but its own routes cost {objective!r} s"
    return None


def refute_proof(status: Status, bound: float | None, objective: float | None, tolerance: float) -> str | None:
    """Return why a claim of OPTIMAL does not hold: no routes, no bound, or a gap above the tolerance [s]; or None."""
    if status is not Status.OPTIMAL:
        return None
    if objective is None or bound is None:
        return f"claimed OPTIMAL without {'routes' if objective is None else 'a bound'}"
    if not 0 <= tolerance <= WIDEST_TOLERANCE * objective:
        return f"claimed OPTIMAL with a tolerance of {tolerance!r} s, while its routes cost {objective!r} s"
    if objective - bound > tolerance + ROUNDING * objective:
        return (
            f"claimed OPTIMAL, but its routes cost {objective!r} s and its bound is {bound!r} s, "
            f"further apart than its tolerance of {tolerance!r} s"
        )
    return None
