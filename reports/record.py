"""The record: one run as it is stored, each of its columns described once (name, unit, meaning).

`workbench` writes runs, `reports` reads them; the CSV, the frame, the help of a page and the documentation take the
names, units and meanings from here. A run of any problem (routing, placement, moving cost, survey) has the columns
RUN, and beside them its problem's own ones, OWN. Files of older versions lack some; what is missing is None, empty or
"".
"""

# ruff: noqa: RUF009 - _kept makes dataclass fields

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from operator import itemgetter
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import msgspec

from instances import disk
from instances.code import code_digest
from instances.declared.reading import read_declared
from instances.declared.types import about
from instances.errors import InputError, one_line, shown
from reports.kinds import KINDS

SCHEMA = 1


class Column(NamedTuple):
    """One column: `kind` says what its values are (`reports.kinds`), `required` that a run without it is refused."""

    name: str
    kind: str
    unit: str
    meaning: str
    required: bool = False

    def __str__(self) -> str:
        return f"{self.name} [{self.unit}]: {self.meaning}" if self.unit else f"{self.name}: {self.meaning}"


OWN: dict[str, tuple[Column, ...]] = {
    "routing": (
        Column("routes", "routes", "", "tasks of each UAV in flying order, in depot order"),
        Column("tour_costs", "numbers", "s", "C_k of each UAV, re-computed"),
    ),
    "placement": (
        Column("points", "points", "m", "task locations, shape (n, 2)"),
        Column("mutual_information", "number", "nats", "information (b) of the points, re-computed"),
        Column("certificate", "finite", "nats", "upper bound of what is maximised, in the region", True),
        Column("ratio", "number", "", "what is maximised, information (b) unless the study says, / certificate"),
        Column(
            "information", "figures", "nats", "information of the points under each convention, under j its worth, too"
        ),
    ),
    "moving-cost": (
        Column("cost", "matrix", "s", "moving cost of every ordered pair of nodes, shape (N, N)"),
        Column("paths", "paths", "m", "the path behind each cost, re-flown by the workbench"),
    ),
    "survey": (
        Column("tours", "polylines", "m", "where each UAV flew from its depot and back, in depot order"),
        Column("samples", "polylines", "m", "where each UAV measured, in the order of time"),
        Column(
            "read", "readings", "", "what the plan looked at in flight: UAV, number of the reading from 1, x, y [m]"
        ),
        Column("rmse", "number", "", "root mean square error of the map in the field's unit, re-computed"),
        Column("nlpd", "number", "nats", "mean negative log predictive density of a new measurement"),
        Column("coverage", "number", "", "share of the map whose true value lies in the 95 % interval"),
        Column("model", "text", "", "what the judge's map believes, chosen by likelihood"),
        Column("promised_sd", "number", "", "√J: root mean square sd that the plan leaves under what it believed"),
        Column("information", "number", "nats", "information gain of the readings under what was believed"),
        Column("length", "number", "m", "flown by all UAVs"),
        Column("longest", "number", "m", "flown by the UAV that flew most"),
        Column("readings", "number", "", "measurements of all UAVs"),
        Column("endurance", "number", "s", "longest flight allowed"),
        Column("unit", "line", "", "of the field"),
    ),
}
"""What is stored beside RUN, by problem."""

SPREAD = {"least": "least C_max", "mean": "mean C_max", "cvar": "mean of the worst fifth of C_max",
          "worst": "greatest C_max"}  # fmt: skip
"""What is said of the makespans over the members of an ensemble (`instances.wind_ensemble.Spread`)."""
ENSEMBLE = tuple(f"ensemble_{name}" for name in SPREAD)
DERIVED = (
    Column("instance", "text", "", "name of the instance (with digits of the digest where two share a name)"),
    Column("digest", "text", "", "digest of the instance"),
    Column("family", "text", "", "generator family or set"),
    Column("n_tasks", "number", "", "number of tasks n"),
    Column("n_depots", "number", "", "number of depots and UAVs m"),
    Column("asymmetry", "number", "", "mean |c_ij − c_ji| / (c_ij + c_ji)"),
    Column("restricted", "flag", "", "whether there may be no routes: legs a UAV cannot fly, or limited endurance"),
    Column("spacing", "number", "", "spacing ratio ρ = √(area / n) / turning radius, where a family was given it"),
    Column("best_known", "number", "s", "best known value stored with the instance"),
    Column("method", "text", "", "name in tables: the label, cut short where long, and the limit where it has several"),
    Column("gap", "number", "", "(objective − bound) / objective"),
    Column("value", "number", "s", "C_max re-computed from the routes; nothing where there are none or it is wrong"),
    Column("proved", "flag", "", "whether the run proved its routes optimal, as far as the stored figures can tell"),
    Column("utilisation", "number", "", "mean of C_k / C_max over the UAVs: 1 where all fly equally long"),
    Column("endurance_margin", "number", "", "least of 1 − C_k / L_k over the UAVs; nothing where none is limited"),
    Column("recomputed", "number", "s", "C_max of the stored routes, right or wrong"),
    Column("promised", "number", "s", "C_max of the routes if costs stayed those of take-off, where they change"),
    Column("turned", "number", "s", "C_max with each tour flown the way round that is home first, where costs change"),
    *(
        Column(f"ensemble_{name}", "number", "s", f"{words} of the routes over the members of an ensemble")
        for name, words in SPREAD.items()
    ),
    Column("fault", "text", "", "what is wrong with the stored routes"),
    Column("stale", "flag", "", "whether other code of ours than today's made it"),
    Column("path", "text", "", "the file"),
    Column("best_found", "number", "s", "least value of any run of the report on the instance"),
    Column("best_bound", "number", "s", "greatest bound of any run of the report on the instance, if none refutes it"),
    Column("bound_by", "line", "", "method that claims best_bound"),
    Column("gap_known", "number", "", "value against best_known"),
    Column("gap_found", "number", "", "value against the best found"),
    Column("gap_bound", "number", "", "value against best_bound"),
)
"""What frames and tables hold beside what is stored."""

ITEM_FILES = {
    "routing": ("instance.json", "instance.json.gz"),
    "placement": ("problem.json",),
    "moving-cost": ("moving-cost.json",),
    "survey": ("survey.json",),
}
"""Problem → the file beside its runs that keeps what was solved, by its possible names."""
_SCENARIO = ("scenario-region.json", "scenario-no-fly.json")
PART_FILES = {"routing": _SCENARIO, "moving-cost": _SCENARIO, "survey": ("scenario-region.json",)}
"""Problem → files beside its runs that are part of what was solved, and no runs though they end alike."""

ENSEMBLE_FILE = "instance.paths.json.gz"
"""Says, beside an instance, that an ensemble of forecasts is kept there as well (`instances.kept_ensemble`)."""


def described(*names: str, problem: str = "routing") -> dict[str, Column]:
    """Return the columns of these names in this order, as frames of `problem` hold them."""
    known = {column.name: column for column in (*RUN, *OWN[problem], *DERIVED)}
    return {name: known[name] for name in names}


STATUSES = {"routing": ("OPTIMAL", "FEASIBLE", "INFEASIBLE", "NO_SOLUTION", "KILLED", "ERROR")}
"""Statuses a stored run may have, where a problem closes the list."""


def _kept(kind: str, unit: str, meaning: str, required: bool = False, **default: Any) -> Any:
    """Return a dataclass field that is stored as a column."""
    return field(**default, metadata={"kind": kind, "unit": unit, "meaning": meaning, "required": required})


@dataclass(frozen=True)
class Run:
    """One run, every number checked by the workbench: what is stored of all, in order, and its problem's columns."""

    problem: str = _kept("line", "", "routing, placement, moving-cost or survey")
    instance: dict[str, Any] = _kept(
        "item", "", "what was solved: name, digest, n_tasks, n_depots, and more by problem", required=True
    )
    solver: str = _kept("line", "", "registered name of the method, or module:Class", required=True)
    options: dict[str, Any] = _kept("table", "", "options that differ from the default")
    label: str = _kept("line", "", "solver and its options where not default")
    seed: int = _kept("whole", "", "seed of the random numbers", required=True)
    time_limit: float = _kept("limit", "s", "wall clock the solve was allowed", required=True)
    threads: int = _kept("amount", "", "threads the solve was allowed")
    iterations: int | None = _kept("amount", "", "limit on the method's own iterations, or none")
    proves: bool = _kept("flag", "", "whether the method can end with a proof of optimality")
    status: str = _kept("line", "", "what is known at the end", required=True)
    objective: float | None = _kept(
        "number",
        "s",
        "re-computed by the workbench: C_max [s]; of a placement −I [nats]; of a survey RMSE",
        required=True,
    )
    bound: float | None = _kept("number", "s", "lower bound on the objective, in its unit", required=True)
    elapsed: float = _kept("amount", "s", "wall clock of the solve alone")
    stopped_by: str = _kept(
        "line", "", "what ended the run: proof, time, iterations, memory, stuck, finished, killed, error"
    )
    message: str = _kept("line", "", "one sentence")
    tolerance: float | None = _kept("number", "s", "OPTIMAL means objective − bound ≤ tolerance")
    claimed_objective: float | None = _kept("number", "s", "what the method claimed")
    prepare_elapsed: float | None = _kept("amount", "s", "start of the process, imports and compilation")
    wall_elapsed: float | None = _kept("amount", "s", "wall clock of the whole process")
    cpu_seconds: float | None = _kept("amount", "s", "processor time of the solve, all threads")
    peak_memory: int | None = _kept("amount", "bytes", "most memory of the whole process")
    environment: str = _kept("line", "", "digest of machine and versions, stated in environments/<digest>.json")
    code: str = _kept("line", "", "digest of the workbench's sources that made it; other than today's is stale")
    revision: str = _kept("line", "", "revision of the checkout, where it was made in one")
    created: str = _kept("line", "", "ISO time, UTC")
    trace: list[tuple[float, float | None, float | None]] = _kept(
        "trace", "", "elapsed [s], objective, bound of each improvement", default_factory=list
    )
    statistics: dict[str, Any] = _kept("table", "", "the method's own figures", default_factory=dict)
    log: str = _kept("text", "", "the end of what the process printed", default="")
    foreign: bool = _kept(
        "flag", "", "whether it was imported: found by a program of others, elsewhere; only its routes are checked",
        default=False,
    )  # fmt: skip
    own: dict[str, Any] = field(default_factory=dict)

    @property
    def stale(self) -> bool:
        """Whether other code of ours than today's made it; what others made is never stale."""
        return not self.foreign and self.code != code_digest()

    @property
    def gap(self) -> float | None:
        """(objective − bound) / objective, dimensionless; None where one is unknown."""
        if self.objective is None or self.bound is None:
            return None
        return (self.objective - self.bound) / self.objective if self.objective > 0 else 0.0

    def flat(self) -> dict[str, Any]:
        """Return the run as JSON values, own columns after the common ones."""
        common = {column.name: getattr(self, column.name) for column in RUN}
        return {"schema": SCHEMA, **common, **self.own, "gap": self.gap}

    def to_json(self) -> str:
        """Return the run as one JSON object."""
        return json.dumps(self.flat(), allow_nan=False, ensure_ascii=False)


RUN = tuple(Column(each.name, **each.metadata) for each in fields(Run) if each.metadata)
"""What is stored of every run, in the order in which it is written."""


def read_json(path: Path) -> Any:
    """Return the JSON value in `path`; InputError with a sentence, without the path, where there is none."""
    try:
        return disk.read_json(path)
    except InputError as error:
        raise InputError(str(error).removeprefix(f"{path}: ")) from None


def read_run(path: Path) -> Run:
    """Return the run stored in `path`; InputError with a sentence, without the path, where it is none."""
    return run_from(read_json(path))


def run_from(data: Any) -> Run:
    """Return the run written as `data`, every value of its kind; InputError with a sentence where it is none."""
    if not isinstance(data, dict) or "solver" not in data or "schema" not in data:
        raise InputError("is JSON, but not a run of this workbench")
    if data["schema"] != SCHEMA:
        raise InputError(f"has schema {shown(data['schema'])}; this version reads schema {SCHEMA}")
    problem = data.get("problem", "routing")
    if not isinstance(problem, str) or problem not in OWN:
        raise InputError(f"is a run of a problem unknown here, {shown(problem)} (known: {', '.join(OWN)})")
    read_declared(run_type(problem), data, toml=False)
    common, own = ({c.name: _kept_value(data, c) for c in columns} for columns in (RUN, OWN[problem]))
    common |= {"problem": problem, "label": common["label"] or common["solver"]}
    common["trace"] = sorted(map(tuple, common["trace"]), key=itemgetter(0))
    return Run(**common, own=own)


@cache
def run_type(problem: str) -> type[msgspec.Struct]:
    """Return what a stored run of `problem` is declared as: its columns, each of its kind; others are let be."""
    closed: dict[str, Any] = {"problem": Literal[problem]}
    if problem in STATUSES:
        closed["status"] = Literal[STATUSES[problem]]
    stated = [("schema", Annotated[Literal[SCHEMA], about("version of the format")])]
    stated += [_declared(c, closed.get(c.name, KINDS[c.kind].type)) for c in (*RUN, *OWN[problem]) if c.required]
    rest = [_declared(c, closed.get(c.name, KINDS[c.kind].type)) for c in (*RUN, *OWN[problem]) if not c.required]
    made = msgspec.defstruct(f"{problem}-run", [*stated, *((name, kind, None) for name, kind in rest)], kw_only=True)
    rules = {c.name: KINDS[c.kind].rule for c in OWN[problem] if KINDS[c.kind].rule}
    made.RULES = {"properties": rules}  # type: ignore[attr-defined]  # read by instances.declared.schema
    made.__doc__ = f"A run of {problem}, every number checked by the workbench. Other keys are let be."
    return made


def _declared(column: Column, kind: Any) -> tuple[str, Any]:
    return column.name, Annotated[kind if column.required else kind | None, about(column.meaning, column.unit)]


def _kept_value(data: Mapping[str, Any], column: Column) -> Any:
    value, kind = data.get(column.name), KINDS[column.kind]
    if value is None and not column.required:
        return kind.missing()
    if value is not None and (fault := kind.fault(value)):
        raise InputError(f"{column.name} {fault}")
    return kind.keep(value)


def code_note(codes: Iterable[str]) -> str:
    """Return what a reader must know about the code that made runs, a sentence, or "" where all is today's."""
    made = list(codes)
    stale = sum(code != code_digest() for code in made)
    if not stale:
        return ""
    versions = len(set(made))
    mixed = f", by {versions} different versions in all: their figures stand side by side" if versions > 1 else ""
    return f"{stale} of {len(made)} runs were made by other code than today's{mixed} (compare --retry stale)."


def study_title(folders: Sequence[Path]) -> str:
    """Return the name of the study, where one folder says it, else the folders' names."""
    names = [folder.resolve().name for folder in folders]
    if len(folders) == 1:
        with contextlib.suppress(InputError, KeyError, TypeError):
            names = [str(read_json(folders[0] / "study.json")["study"]["name"])]
    return one_line(", ".join(names), LONGEST_TITLE)


LONGEST_TITLE = 200
"""Characters of a page's title."""
