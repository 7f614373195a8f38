"""Run: one result of one solver on one instance with one seed and limit, as stored (one JSON file a run)."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from typing import Any

from formulations.routing.solver import Status
from instances import Instance, Routes, as_routes
from instances.best_known import best_known

SCHEMA = 1


@dataclass(frozen=True)
class Run:
    """One run, every number in it checked by the runner, in the order in which it is written.

    problem : "routing".
    instance : name, digest, n_tasks, n_depots, family, asymmetry, and best_known [s] where a value is known.
    label : solver name plus options that differ from the default.
    proves : whether the method can end OPTIMAL.
    objective, tour_costs [s] : recomputed from `routes`, never the solver's own; claimed_objective [s] is the solver's.
    trace : [elapsed [s], objective [s] or None, bound [s] or None], objectives recomputed from the streamed routes.
    elapsed [s] : wall clock of the solve alone; prepare_elapsed [s] : start of the process, imports and compilation;
        wall_elapsed [s] : from start to end of the process; cpu_seconds [s] : CPU time of the solve, all threads.
    peak_memory : bytes, of the whole process.
    log : the end of what the process printed.
    environment : digest of machine and versions, stated once in ``environments/<digest>.json``.
    created : ISO time, UTC.
    """

    instance: dict[str, Any]
    solver: str
    options: dict[str, Any]
    label: str
    seed: int
    time_limit: float
    threads: int
    iterations: int | None
    proves: bool
    status: Status
    objective: float | None
    bound: float | None
    elapsed: float
    routes: Routes | None
    stopped_by: str
    message: str
    tolerance: float
    claimed_objective: float | None
    tour_costs: list[float]
    prepare_elapsed: float
    wall_elapsed: float
    cpu_seconds: float
    peak_memory: int
    environment: str
    created: str
    trace: list[tuple[float, float | None, float | None]] = field(default_factory=list)
    statistics: dict[str, Any] = field(default_factory=dict)
    log: str = ""
    problem: str = "routing"

    @property
    def gap(self) -> float | None:
        """(objective − bound) / objective, dimensionless; None where one is unknown."""
        if self.objective is None or self.bound is None:
            return None
        return (self.objective - self.bound) / self.objective if self.objective > 0 else 0.0

    def to_json(self) -> str:
        """Return the run as one JSON object."""
        fields = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return json.dumps({"schema": SCHEMA, **fields, "gap": self.gap}, allow_nan=False, ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str | bytes) -> Run:
        """Return the run written as `text`; ValueError says what is wrong with a foreign or damaged one."""
        data = json.loads(text)
        if not isinstance(data, dict) or "solver" not in data or "status" not in data:
            raise ValueError("it is not a run")
        if data.get("schema") != SCHEMA:
            raise ValueError(f"schema must be {SCHEMA}, got {data.get('schema')!r}")
        names = {f.name for f in dataclasses.fields(cls)}
        missing = names - data.keys()
        if missing:
            raise ValueError(f"'{min(missing)}' is missing")
        fields = {name: data[name] for name in names}
        fields["status"] = Status(fields["status"])
        fields["trace"] = [tuple(point) for point in fields["trace"]]
        fields["routes"] = None if fields["routes"] is None else as_routes(fields["routes"])
        return cls(**fields)


def describe(instance: Instance) -> dict[str, Any]:
    """Return what a run says about its instance."""
    described = {
        "name": instance.name,
        "digest": instance.digest,
        "n_tasks": int(instance.n_tasks),
        "n_depots": int(instance.n_depots),
        "family": str(instance.provenance.get("family", "file")),
        "asymmetry": instance.asymmetry,
    }
    known = best_known(instance.digest)
    return described | ({"best_known": known.best_known} if known else {})
