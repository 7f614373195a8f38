"""The registry of placement methods: name → "module:Class", imported only when asked for."""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

from formulations.task_location.placement import PlacementMethod
from instances.errors import InputError, suggestion

METHODS: dict[str, tuple[str, str]] = {
    "nlp": ("formulations.task_location.nlp:Nlp", "casadi and IPOPT, closed-form gradient and Hessian, multi-start"),
    "l-bfgs-b": ("formulations.task_location.l_bfgs_b:LBfgsB", "bounded quasi-Newton, closed-form gradient"),
    "slsqp": ("formulations.task_location.slsqp:Slsqp", "sequential quadratic programming, closed-form gradient"),
    "greedy-swap": ("formulations.task_location.greedy_swap:GreedySwap", "greedy, then best exchanges"),
    "greedy": ("formulations.task_location.greedy:Greedy", "largest gain first, over candidate sites"),
    "nelder-mead": ("formulations.task_location.nelder_mead:NelderMead", "the paper's fminsearch, in two forms"),
    "grid": ("formulations.task_location.grid:Grid", "a regular lattice"),
    "random": ("formulations.task_location.random_points:Random", "uniform random points"),
}
"""Method → (``"module:Class"``, one line on what it is)."""


def method_class(name: str) -> type[PlacementMethod]:
    """Import and return the class registered as `name`; InputError, with the near miss, where there is none."""
    if name not in METHODS:
        raise InputError(f"unknown placement method '{name}'{suggestion(name, METHODS)} (known: {', '.join(METHODS)})")
    module, _, attribute = METHODS[name][0].partition(":")
    cls: type[PlacementMethod] = getattr(importlib.import_module(module), attribute)
    return cls


def make_method(name: str, options: dict[str, Any] | None = None) -> PlacementMethod:
    """Return the method registered as `name` with `options` (its dataclass fields).

    Raises InputError for an unknown method, option or option value.
    """
    cls = method_class(name)
    options = options or {}
    defaults = option_defaults(cls)
    for key, value in options.items():
        if key not in defaults:
            has = ", ".join(defaults) or "none"
            raise InputError(
                f"placement method {name} has no option '{key}'{suggestion(key, defaults)} (it has: {has})"
            )
        kind = type(defaults[key])
        allowed = (int, float) if kind is float else kind
        if not isinstance(value, allowed) or isinstance(value, bool) is not (kind is bool):
            wanted = {str: "a text", int: "a whole number", float: "a number"}.get(kind, kind.__name__)
            raise InputError(f"placement method {name}: {key} must be {wanted}, got {value!r}")
        if kind in (int, float) and not value >= 0:
            raise InputError(f"placement method {name}: {key} must not be negative, got {value}")
    return cls(**options)


def option_defaults(cls: type[PlacementMethod]) -> dict[str, Any]:
    """Return the options of a method and their defaults, by name."""
    return {f.name: f.default for f in dataclasses.fields(cls)} if dataclasses.is_dataclass(cls) else {}
