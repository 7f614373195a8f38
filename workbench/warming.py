"""Warming: what is to be done so that a solver, or a command, compiles nothing later."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from formulations.routing.registry import SOLVERS, make_solver
from instances.errors import InputError, suggestion

SIZES = (6, 20)
"""Tasks of what solvers are warmed on: `exact` solves few and many tasks by different methods."""
FAMILIES = {"fleets": "mixed-fleet", "clocks": "wind-turning", "states": "dense-survey"}
"""What instances with more than one matrix are called here → a family of such."""


def warmers(names: tuple[str, ...]) -> dict[str, Callable[[], None]]:
    """Return what warms each of `names`, of all that is there where none is named; InputError for an unknown name.

    Names are those of solvers and of moving-cost methods, and ``select`` and ``map``; ``costs`` is all moving-cost
    methods. ``fleets``, ``clocks`` and ``states`` are the kernels of all solvers for such instances, which few need:
    they are warmed where they are named. Placement compiles nothing.
    """
    from formulations.moving_cost.registry import METHODS as COSTS

    known: dict[str, Callable[[], None]] = {
        name: lambda name=name: _solver(name)  # type: ignore[misc]
        for name in SOLVERS.built_in
        if SOLVERS.why_unavailable(name) is None or name in names
    }
    costs = {name: lambda name=name: _moving_cost(name) for name in COSTS.built_in}
    known |= costs | {"select": _selection, "map": _mapping}
    usual = tuple(known)
    known |= {name: lambda family=family: _axis(family) for name, family in FAMILIES.items()}  # type: ignore[misc]
    wanted: dict[str, Callable[[], None]] = {}
    for name in names or usual:
        if name == "costs":
            wanted |= costs
        elif name in known:
            wanted[name] = known[name]
        elif ":" in name:
            wanted[name] = lambda name=name: _solver(name)  # type: ignore[misc]
        else:
            near, groups = suggestion(name, (*known, "costs")), ", ".join(("costs", "select", "map", *FAMILIES))
            raise InputError(f"warmup: '{name}' is no solver, no moving-cost method and none of {groups}{near}")
    return wanted


def _solver(name: str) -> None:
    from formulations.moving_cost.families import generate
    from formulations.routing.solver import refusal

    solver = make_solver(name)
    for n_tasks in SIZES:
        instance = generate("uniform", n_tasks, 2, 0)
        if refusal(solver, instance) is None:
            solver.prepare(instance)


def _axis(family: str) -> None:
    from formulations.moving_cost.families import generate
    from formulations.routing.solver import refusal

    instance = generate(family, SIZES[0], 2, 0)
    for name in SOLVERS.built_in:
        if SOLVERS.why_unavailable(name) is None and refusal(solver := make_solver(name), instance) is None:
            solver.prepare(instance)


def _moving_cost(name: str) -> None:
    from formulations.moving_cost.costing import query_of
    from formulations.moving_cost.registry import make_method
    from instances.families import make_scenario

    method = make_method(name)
    family = "square-wind" if name == "closed-form" else "wind-vortices"
    method.solve(query_of(make_scenario(family, 1, 1, 0)))


def _selection() -> None:
    from formulations.moving_cost.families import generate
    from formulations.selection.registry import METHODS, make_method
    from formulations.selection.selection import SelectionProblem
    from formulations.selection.worth import Worth

    instance = generate("mixed-fleet", 6, 2, 0, endurance=0.5)
    problem = SelectionProblem(instance, Worth.of_prizes(np.ones(6)))
    for name in METHODS.built_in:
        make_method(name).prepare(problem)


def _mapping() -> None:
    from shapely.geometry import Point

    from formulations.mapping.headings import choose_headings

    corners = 1000.0 * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    headings = np.tile(np.linspace(0.0, 2 * np.pi, 4, endpoint=False), (3, 1))
    choose_headings(corners, headings, 50.0, Point(0.0, 0.0).buffer(600.0))
