"""The registry of moving-cost methods: name → "module:Class", imported only when asked for."""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

from formulations.moving_cost.method import MovingCostMethod
from instances.errors import InputError, suggestion

METHODS: dict[str, tuple[str, str]] = {
    "refined": ("formulations.moving_cost.refined:Refined", "lattice search and Newton polish: the true optimum"),
    "fmt-star": ("formulations.moving_cost.fmt_star:FmtStar", "the paper's modified Fast Marching Tree"),
    "dijkstra": ("formulations.moving_cost.dijkstra:Dijkstra", "shortest paths on the graph of fmt-star"),
}
"""Name → (``"module:Class"``, one line on what it is)."""

DEFAULT = "refined"


def method_class(name: str) -> type[MovingCostMethod]:
    """Import and return the class registered as `name`; InputError for an unknown one (with the near miss)."""
    if name not in METHODS:
        raise InputError(f"unknown method '{name}'{suggestion(name, METHODS)} (known: {', '.join(METHODS)})")
    module, _, attribute = METHODS[name][0].partition(":")
    cls: type[MovingCostMethod] = getattr(importlib.import_module(module), attribute)
    return cls


def make_method(name: str = DEFAULT, options: dict[str, Any] | None = None) -> MovingCostMethod:
    """Return the method registered as `name` with `options` (its dataclass fields).

    Raises InputError for an unknown method, option or option value.
    """
    cls = method_class(name)
    defaults = {f.name: f.default for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    for key, value in (options or {}).items():
        if key not in defaults:
            raise InputError(
                f"method {name} has no option '{key}'{suggestion(key, defaults)} (it has: {', '.join(defaults)})"
            )
        kind = type(defaults[key])
        if type(value) is not kind and not (kind is float and type(value) is int):
            raise InputError(f"method {name}: option {key} must be of type {kind.__name__}, got {value!r}")
    return cls(**(options or {}))
