"""The moving-cost problem: paths and costs between all nodes of a scenario in wind (sub-problem 2 of the paper).

The objective of a run is the mean moving cost [s] over all ordered pairs of nodes. Its paths are flown again in the
parent: length, wind, collisions.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from formulations.limits import Limits
from formulations.moving_cost.costing import all_pairs, query_of
from formulations.moving_cost.method import MovingCostMethod, Query
from formulations.moving_cost.registry import METHODS
from instances.arrays import Floats
from instances.disk import write_aside
from instances.errors import InputError
from instances.families import make_scenario
from instances.moving_cost import CostKind
from instances.paths import Paths, check_paths
from instances.scenario import Scenario, read_scenario
from instances.scenario_folder import keep_scenario, kept_scenario
from reports.damage import reading
from reports.record import ITEM_FILES, Run, read_json, study_title
from workbench.jobs.check import check_runs
from workbench.jobs.problem import Claim, Listener, Outputs, Problem, Published, Source
from workbench.jobs.study_table import listed
from workbench.making import make_elsewhere
from workbench.problems.publishing import published, without
from workbench.problems.routing import family_grid
from workbench.problems.tables import MovingCostTable
from workbench.sources import plugin_family
from workbench.summary import Summary

if TYPE_CHECKING:
    import pandas as pd

    from reports.columns import Column
    from reports.pages.moving_cost import Case

SAMPLED = 65
"""Points a side at which the wind enters a scenario's digest."""
PATHS = ("offsets", "points")
"""What is stored of `instances.paths.Paths`."""


@dataclass(frozen=True, eq=False)
class MovingCostItem:
    """A scenario with its tasks placed; `starts` : only its first so many nodes, or None for all."""

    scenario: Scenario
    starts: int | None = None

    def __reduce__(self) -> tuple[type[MovingCostItem], tuple[Any, ...]]:
        """Pickle without what is cached."""
        return MovingCostItem, (self.scenario, self.starts)

    @property
    def name(self) -> str:
        """The scenario's name, and the number of starts where not all."""
        return self.scenario.name if self.starts is None else f"{self.scenario.name}-first{self.starts}"

    @cached_property
    def query(self) -> Query:
        """What a method is given."""
        whole = query_of(self.scenario)
        return whole if self.starts is None else replace(whole, terminals=whole.terminals[: self.starts])

    @cached_property
    def digest(self) -> str:
        """First 12 hexadecimal digits of the SHA-256 of what a method is given; the wind as sampled on a lattice."""
        query = self.query
        x0, y0, x1, y1 = query.region.bounds
        lattice = np.meshgrid(np.linspace(x0, x1, SAMPLED), np.linspace(y0, y1, SAMPLED))
        wind = query.wind(np.stack(lattice, axis=-1).reshape(-1, 2))
        h = hashlib.sha256(query.region.polygon.normalize().wkb)
        for array in (query.terminals, wind, np.array([query.v0])):
            h.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
        if query.kind is not CostKind.ENERGY:
            h.update(query.kind.encode())
        return h.hexdigest()[:12]

    def load(self) -> MovingCostItem:
        """Return itself: nothing is left to make."""
        return self


@dataclass(frozen=True)
class FamilyScenario:
    """One scenario of a generator family: name, n, m, seed, parameters."""

    made_by: tuple[str, int, int, int, dict[str, Any]]
    starts: int | None

    @property
    def plugin(self) -> str:
        """The family, where it is not built in, else ""."""
        return plugin_family(self.made_by[0])

    def load(self) -> MovingCostItem:
        """Make the scenario."""
        if self.plugin:
            return MovingCostItem(make_elsewhere(*self.made_by)[0], self.starts)
        family, n_tasks, n_depots, seed, parameters = self.made_by
        return MovingCostItem(make_scenario(family, n_tasks, n_depots, seed, **parameters), self.starts)


class MovingCostStudy(Problem[MovingCostItem]):
    """Scenarios, and the paths between their nodes."""

    name = "moving-cost"
    methods = METHODS
    item = "scenario"
    entries = "methods"
    study = MovingCostTable
    default_limit = 60.0
    product = dict[str, list[Any]]
    found = "paths"
    statuses = ("FEASIBLE",)
    outputs = ("figures",)

    def sources(self, study: MovingCostTable, base: Path) -> Iterable[Source[MovingCostItem]]:
        """Return every scenario with every number of starts."""
        starts: list[int | None] = [*listed(study.starts)] or [None]
        for name, count in itertools.product(listed(study.scenarios), starts):
            yield MovingCostItem(read_scenario(base / name), count)
        for number, table in enumerate(study.families, 1):
            for made, count in itertools.product(family_grid(table, f"[[families]] {number}"), starts):
                yield FamilyScenario(made, count)

    def size(self, item: MovingCostItem) -> int:
        """Return the number of nodes."""
        return len(item.query.terminals)

    def write(self, item: MovingCostItem, folder: Path) -> None:
        """Keep the scenario."""
        path = folder / ITEM_FILES[self.name][0]
        if not path.exists():
            keep_scenario(item.scenario, folder)
            write_aside(path, json.dumps({"schema": 1, "problem": self.name, "starts": item.starts}))

    def read(self, folder: Path) -> MovingCostItem:
        """Return the scenario kept in `folder`."""
        path = folder / ITEM_FILES[self.name][0]
        with reading(path, "a scenario"):
            data = read_json(path)
            item = MovingCostItem(kept_scenario(folder), data["starts"])
            digest = item.digest
        if not folder.name.endswith(digest):
            raise InputError(f"{path}: is not the scenario of its folder (its digest is {digest})")
        return item

    def describe(self, item: MovingCostItem) -> dict[str, Any]:
        """Return name, digest and sizes."""
        depots = item.scenario.n_depots if item.starts is None else 0
        family = str(item.scenario.provenance.get("family", "file"))
        about = {"name": item.name, "digest": item.digest, "n_tasks": self.size(item)}
        return about | {"n_depots": depots, "family": family}

    def prepare(self, method: MovingCostMethod, item: MovingCostItem) -> None:
        """Compile the method's kernels on two nodes."""
        method.solve(replace(item.query, terminals=item.query.terminals[:2]))

    def solve(
        self, method: MovingCostMethod, item: MovingCostItem, limits: Limits, seed: int, tell: Listener, start: Any
    ) -> Claim:
        """Plan all paths; `seed` numbers repetitions, as the methods' samples are an option of theirs."""
        found = all_pairs(item.query, method)
        paths = {key: getattr(found.paths, key).tolist() for key in PATHS}
        product = {"cost": found.cost.tolist(), **paths}
        return Claim(product, mean_cost(found.cost), status="FEASIBLE", stopped_by="finished",
                     statistics=found.statistics)  # fmt: skip

    def judge(self, item: MovingCostItem, product: Any, claimed: float | None) -> tuple[float | None, str]:
        """Return the mean cost [s] of paths that can be flown, and what is wrong with them."""
        try:
            cost, paths = costs_of(product)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            return None, f"sent costs and paths that cannot be read ({error})"
        query = item.query
        faults = check_paths(paths, cost, query.terminals, query.region, query.wind, query.v0, kind=query.kind)
        return (None, " ".join(faults)) if faults else (mean_cost(cost), "")

    def refute_ending(self, item: MovingCostItem, claim: Claim, objective: float | None) -> str:
        """Return that there are no paths where there are none."""
        return "" if claim.product is not None else "ended without costs and paths"

    def own_columns(self, item: MovingCostItem, product: Any) -> dict[str, Any]:
        """Return the costs and the paths behind them."""
        if product is None:
            return {"cost": None, "paths": {}}
        return {"cost": product["cost"], "paths": {key: product[key] for key in PATHS}}

    def spell(self, run: Run) -> str:
        """Return the mean cost in seconds."""
        return "no paths" if run.objective is None else f"mean {run.objective:.6g} s"

    def check(self, folder: Path) -> tuple[str, list[str]]:
        """Fly every stored path again."""
        runs, items, problems = check_runs(self, folder, lambda item: [], _false_claims)
        return f"{runs} moving-cost runs on {items} scenarios", problems

    def columns(self) -> Sequence[Column]:
        """Return the columns of the summary."""
        from reports.columns import MOVING_COSTS

        return MOVING_COSTS

    def publish(self, folders: list[Path], outputs: Outputs) -> Published:
        """Put the methods side by side on each scenario."""
        from reports.moving_costs import moving_cost_frame, moving_cost_summary
        from reports.pages.moving_cost import write_moving_cost_page
        from reports.stores import read_runs

        runs, damaged = read_runs(*folders, problem=self.name)
        items = _items(runs, damaged)
        frame, title = moving_cost_frame(runs), f"Moving costs: {study_title(folders)}"
        return published(
            outputs,
            frame,
            frame["code"],
            lambda: [Summary(self.name, self.columns(), moving_cost_summary(frame), 2)],
            without("paths", frame["mean_cost"].isna()),
            damaged,
            lambda page, to: write_moving_cost_page(_cases(items, runs, frame), frame, runs, page, title, to),
        )


MOVING_COST = MovingCostStudy()


def costs_of(product: Mapping[str, Any]) -> tuple[Floats, Paths]:
    """Return the costs [s], shape (N, N), and the paths of a product; ValueError and the like where it is none."""
    cost = np.array(product["cost"], dtype=np.float64)
    points = np.array(product["points"], dtype=np.float64).reshape(-1, 2)
    if not np.isfinite(cost).all() or not np.isfinite(points).all():
        raise ValueError("values are not finite")
    offsets = np.array(product["offsets"], dtype=np.int64)
    if (np.diff(offsets) < 0).any():
        raise ValueError("paths overlap")
    return cost, Paths(len(cost), points, offsets)


def mean_cost(cost: Floats) -> float:
    """Return the mean of a cost matrix [s] over ordered pairs of different nodes; 0 for a single node."""
    n = len(cost)
    return float(cost.sum() / (n * (n - 1))) if n > 1 else 0.0


def _items(runs: Iterable[Path], damaged: list[str]) -> list[MovingCostItem]:
    """Return the scenarios beside `runs`; what cannot be read is added to `damaged`."""
    items = []
    for folder in dict.fromkeys(path.parent for path in runs):
        try:
            items.append(MOVING_COST.read(folder))
        except InputError as error:
            damaged.append(f"{error}; left alone.")
    return items


def _cases(items: list[MovingCostItem], runs: Mapping[Path, Run], frame: pd.DataFrame) -> list[Case]:
    """Return for each scenario the best run's paths that can be flown, and its tables.

    Scenarios of few starts add to the whole's CPU.
    """
    from formulations.moving_cost.effect import wind_effect
    from reports.moving_costs import methods_table, scaling_table
    from reports.pages.moving_cost import Case

    largest: dict[str, MovingCostItem] = {}
    for item in items:
        of = largest.setdefault(item.scenario.name, item)
        if MOVING_COST.size(item) > MOVING_COST.size(of):
            largest[item.scenario.name] = item
    cases = []
    for name, item in largest.items():
        on = [run for run in runs.values() if run.instance["digest"] == item.digest]
        ranked = sorted((run for run in on if run.objective is not None), key=lambda run: run.objective or 0.0)
        best = next((run for run in ranked if not _false_claims(item, run)), None)
        if best is None:
            continue
        cost, paths = costs_of({"cost": best.own["cost"], **best.own["paths"]})
        parts = [each.name for each in items if each.scenario.name == name]
        scaling = scaling_table(frame[frame["instance"].isin(parts)])
        methods = methods_table(frame[frame["digest"] == item.digest])
        cases.append(
            Case(item.scenario, paths, methods, scaling, wind_effect(item.query, cost).summary(item.query.kind))
        )
    return cases


def _false_claims(item: MovingCostItem, run: Run) -> list[str]:
    if run.own["cost"] is None:
        return [] if run.objective is None else ["states a cost, but has no paths"]
    objective, fault = MOVING_COST.judge(item, {"cost": run.own["cost"], **run.own["paths"]}, run.objective)
    if objective is None:
        return [fault]
    if run.objective is None or abs(run.objective - objective) > 1e-9 * abs(objective):
        return [f"states a mean cost of {run.objective!r} s, but its costs have {objective!r} s"]
    return []
