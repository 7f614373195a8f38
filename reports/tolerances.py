"""Tolerances: how far two figures may be apart and still agree, for who verifies a claim and who reports it."""

from __future__ import annotations

RELATIVE_ROUNDING = 1e-9
"""Two costs that differ by less than this share differ by floating-point rounding only."""
WIDEST_TOLERANCE = 1e-3
"""A proof to within more than this share of the cost is not called one."""
