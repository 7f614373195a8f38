"""Judging: a row of others becomes a foreign run, believed as far as it can be verified here.

Routes are checked and costed as those of every solver are; a claim they do not bear out makes the run an ERROR that
names both numbers. Without routes nothing is verified: the claimed value is kept as claimed and is no solution. A bound
stays a claim, as all bounds do; it takes part in contradictions, lowered by what its last digit may have been rounded.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import UTC, datetime
from decimal import Decimal
from pathlib import Path
from typing import Any

from instances import InputError, Instance, Routes, as_routes, makespan
from instances.code import code_digest, revision
from instances.disk import read_text
from instances.errors import naming, shown
from instances.formats.sol import parse_solution
from reports.foreign import MARK
from reports.record import Run
from reports.tolerances import RELATIVE_ROUNDING, WIDEST_TOLERANCE
from workbench.importing.rows import Row, Stated, stated
from workbench.jobs.machine import environment_digest
from workbench.problems.routing import ROUTING, refute_cost, refute_routes


@dataclass(frozen=True)
class Verdict:
    """What is believed of a row: status, objective and bound [s], the tolerance of a proof [s], a sentence."""

    status: str
    message: str
    routes: Routes | None = None
    objective: float | None = None
    bound: float | None = None
    tolerance: float = 0.0
    claimed: float | None = None


def foreign_run(row: Row, instance: Instance, base: Path, first_task: int = 0) -> Run:
    """Return the run of `row` on `instance`.

    base : folder that names of ``.sol`` files are relative to. first_task : number of the first task in lists of tasks;
    a ``.sol`` says itself how it numbers them (`instances.formats.sol`). InputError where the routes cannot be read;
    that they are wrong is the run's ERROR.
    """
    with naming(row.where):
        routes, cost = _routes(row.routes, instance, base, first_task)
    claimed = row.objective or (stated(Decimal(repr(cost).removesuffix(".0"))) if cost is not None else None)
    verdict = _verdict(instance, routes, claimed, row.bound)
    solver = row.solver.removesuffix(MARK) + MARK
    found = verdict.objective is not None or verdict.bound is not None
    return Run(
        problem=ROUTING.name,
        instance=ROUTING.describe(instance),
        solver=solver,
        options={},
        label=solver,
        seed=row.seed,
        time_limit=row.time_limit,
        threads=row.threads,
        iterations=None,
        proves=row.bound is not None,
        status=verdict.status,
        objective=verdict.objective,
        bound=verdict.bound,
        elapsed=row.elapsed,
        stopped_by={"ERROR": "error", "OPTIMAL": "proof"}.get(verdict.status, ""),
        message=verdict.message,
        tolerance=verdict.tolerance,
        claimed_objective=verdict.claimed,
        prepare_elapsed=None,
        wall_elapsed=None,
        cpu_seconds=None,
        peak_memory=None,
        environment=environment_digest(machine_of(row)),
        code=code_digest(),
        revision=revision(),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        trace=[(row.elapsed, verdict.objective, verdict.bound)] if found and verdict.status != "ERROR" else [],
        foreign=True,
        own=ROUTING.own_columns(instance, verdict.routes),
    )


def machine_of(row: Row) -> dict[str, Any]:
    """Return what is stated about where a foreign run was made, in the form of an environment."""
    return {"machine": {"stated": row.machine}, "versions": {}}


def _routes(given: Any, instance: Instance, base: Path, first_task: int) -> tuple[Routes | None, float | None]:
    """Return the routes and the cost [s] stated with them, each None where there is none."""
    if given is None:
        return None, None
    text = given.strip() if isinstance(given, str) else None
    if text is not None and text.lower().endswith(".sol") and "\n" not in text:
        file = base / text
        with naming(file):
            return parse_solution(read_text(file), instance)
    if text is not None and not text.startswith("["):
        if "route" not in text.lower():
            raise InputError(f"routes must be [[tasks], …], the text of a .sol or the name of one, got {shown(given)}")
        return parse_solution(text, instance)
    try:
        tables = given if text is None else json.loads(text)
        if not isinstance(tables, list) or not all(isinstance(route, list) for route in tables):
            raise TypeError
        return tuple(tuple(task - first_task for task in route) for route in as_routes(tables)), None
    except (TypeError, ValueError, RecursionError):
        raise InputError(f"routes must be a list of lists of task numbers, got {shown(given)}") from None


def _verdict(instance: Instance, routes: Routes | None, claimed: Stated | None, bound: Stated | None) -> Verdict:
    """Return what can be believed of routes, claimed objective and claimed bound."""
    said = claimed.value if claimed else None
    lowered = bound.value - bound.rounding if bound else None
    if routes is None:
        told = f"claims a longest tour of {said!r} s without routes: kept, not ranked" if claimed else ""
        return Verdict("NO_SOLUTION", told or "a bound alone", bound=lowered, claimed=said)
    if wrong := refute_routes(instance, routes):
        return Verdict("ERROR", wrong, claimed=said)
    cost = makespan(instance, routes)
    if claimed and abs(claimed.value - cost) > claimed.rounding + RELATIVE_ROUNDING * cost:
        return Verdict("ERROR", refute_cost(said, cost), routes, cost, claimed=said)
    if bound is None or lowered is None:
        return Verdict("FEASIBLE", "", routes, cost, claimed=cost if claimed else None)
    if lowered > cost * (1 + RELATIVE_ROUNDING):
        told = f"claimed a lower bound of {bound.value!r} s, but its routes cost {cost!r} s"
        return Verdict("ERROR", told, routes, cost, claimed=said)
    tolerance = min(2 * bound.rounding, WIDEST_TOLERANCE * cost)
    proved = cost - lowered <= tolerance + RELATIVE_ROUNDING * cost
    status = "OPTIMAL" if proved else "FEASIBLE"
    kept = cost if claimed else None
    return Verdict(status, "", routes, cost, min(lowered, cost), tolerance if proved else 0.0, kept)
