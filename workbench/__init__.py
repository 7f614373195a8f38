"""Plan tours for several UAVs in wind, and compare the solvers that do it: ``import workbench as wb``.

    result = wb.solve(cost, depots=3)              # a matrix [s], points, a table, a graph, a file, an Instance
    result.status, result.objective, result.gap    # drawn, with a table, in a notebook
    runs = wb.compare([instance], ["exact", "ga"], time_limit=10, seeds=3)

Importing this costs next to nothing: what a function needs is imported when it is first asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from instances import Instance, Routes
    from workbench.facade import compare, costs, generate, instance, load, mission, plot, solve
    from workbench.informing import place, select
    from workbench.result import Result

__all__ = [
    "Instance",
    "Result",
    "Routes",
    "compare",
    "costs",
    "generate",
    "instance",
    "load",
    "mission",
    "place",
    "plot",
    "select",
    "solve",
]

_HOMES = {
    "Instance": "instances",
    "Routes": "instances",
    "Result": "workbench.result",
    "place": "workbench.informing",
    "select": "workbench.informing",
}


def __getattr__(name: str) -> Any:
    """Import what is asked for, from our own rooms whatever the working folder holds."""
    if name not in __all__:
        raise AttributeError(f"module 'workbench' has no attribute {name!r}")
    from importlib import import_module

    from workbench.rooms import claim

    claim()
    return getattr(import_module(_HOMES.get(name, "workbench.facade")), name)


def __dir__() -> list[str]:
    """Return what the façade offers."""
    return sorted(__all__)
