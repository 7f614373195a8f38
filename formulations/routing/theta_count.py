"""How many θ_ijk the paper's formulation of an instance has: n (n + 1) m, one for each arc of each UAV."""

from __future__ import annotations

from instances import Instance


def why_too_large(instance: Instance, most: int) -> str | None:
    """Return why a solver that takes at `most` so many θ does not take `instance`, or None where it does."""
    size = instance.n_tasks * (instance.n_tasks + 1) * instance.n_depots
    return f"the paper's form would need {size} variables; it takes {most}" if size > most else None
