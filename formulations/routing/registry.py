"""The registry of solvers: name → "module:Class", imported only when asked for.

Third parties add solvers through the entry-point group ``mmmdmtsp_workbench.solvers``, or name the target itself,
``"module:Class"``, wherever a solver's name is asked for.
"""

from __future__ import annotations

import dataclasses
import importlib
from importlib.metadata import entry_points
from typing import Any

from formulations.routing.solver import Solver
from instances.errors import InputError, suggestion

ENTRY_POINT_GROUP = "mmmdmtsp_workbench.solvers"

SOLVERS: dict[str, tuple[str, str]] = {
    "milp": ("formulations.routing.milp:Milp", "the paper's MILP on CP-SAT, subtour cuts added lazily"),
    "circuit": ("formulations.routing.circuit:Circuit", "CP-SAT circuit constraints, one giant circuit"),
    "exact": ("formulations.routing.exact:Exact", "the portfolio to try first: columns, cuts, subsets, side by side"),
    "subset-dp": ("formulations.routing.subset_dp:SubsetDp", "Held–Karp over all subsets, then a min-max partition"),
    "branch-and-cut": (
        "formulations.routing.branch_and_cut:BranchAndCut",
        "the paper's MILP on SCIP, subtour cuts inside the tree",
    ),
    "branch-and-price": (
        "formulations.routing.branch_and_price:BranchAndPrice",
        "set partitioning by columns, ng-route pricing; strongest where tours are short",
    ),
    "ga": ("formulations.routing.ga:GeneticAlgorithm", "the paper's genetic algorithm (Ombuki-Berman & Hanshar 2009)"),
    "routing-library": (
        "formulations.routing.routing_library:RoutingLibrary",
        "OR-Tools routing, the off-the-shelf choice",
    ),
    "memetic": ("formulations.routing.search.memetic:Memetic", "state-of-the-art min-max search, for the best routes"),
    "ruin-recreate": (
        "formulations.routing.search.ruin_recreate:RuinRecreate",
        "annealed ruin-and-recreate with p-norm insertion, one trajectory",
    ),
    "greedy": ("formulations.routing.greedy:Greedy", "greedy construction in four variants, the floor"),
}
"""Built-in solvers: name → (``"module:Class"``, one line on what it is)."""


def solver_targets() -> dict[str, tuple[str, str]]:
    """Return every registered solver, built in or third party: name → (target, one line)."""
    targets = dict(SOLVERS)
    for entry in entry_points(group=ENTRY_POINT_GROUP):
        targets.setdefault(entry.name, (entry.value, f"third party ({entry.value})"))
    return targets


def solver_class(name: str) -> type[Solver]:
    """Import and return the class registered as `name`.

    Raises InputError for an unknown name (with the near miss), ImportError where its package is not installed.
    """
    targets = solver_targets()
    if name not in targets and ":" not in name:
        raise InputError(f"unknown solver '{name}'{suggestion(name, targets)} (workbench solvers lists them)")
    target = targets[name][0] if name in targets else name
    module, _, attribute = target.partition(":")
    cls: type[Solver] | None = getattr(importlib.import_module(module), attribute, None)
    if cls is None:
        raise InputError(f"solver {name}: module {module} has no '{attribute}'")
    return cls


def make_solver(name: str, options: dict[str, Any] | None = None) -> Solver:
    """Return the solver registered as `name` with `options` (its dataclass fields).

    Raises InputError for an unknown solver, option or option value.
    """
    cls = solver_class(name)
    options = options or {}
    defaults = option_defaults(cls)
    known = list(defaults)
    for key, value in options.items():
        if key not in known:
            raise InputError(
                f"solver {name} has no option '{key}'{suggestion(key, known)} (it has: {', '.join(known) or 'none'})"
            )
        kind = type(defaults[key])
        fits = kind not in (bool, int, float, str) or type(value) is kind or (kind is float and type(value) is int)
        if not fits:
            raise InputError(f"solver {name}: option {key} must be of type {kind.__name__}, got {value!r}")
    return cls(**options)


def option_defaults(cls: type[Solver]) -> dict[str, Any]:
    """Return the options of a solver and their defaults: its dataclass fields."""
    if not dataclasses.is_dataclass(cls):
        return {}
    made = {
        f.name: f.default_factory() for f in dataclasses.fields(cls) if f.default_factory is not dataclasses.MISSING
    }
    return {f.name: made.get(f.name, f.default) for f in dataclasses.fields(cls)}


def why_unavailable(name: str) -> str | None:
    """Return why the solver cannot be imported here, in a sentence, or None where it can."""
    try:
        solver_class(name)
    except ImportError as error:
        return f"not installed: {error}"
    return None
