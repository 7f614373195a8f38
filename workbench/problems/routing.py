"""The routing problem: the min-max multi-depot multiple TSP (sub-problem 3 of the paper), routes of an instance.

No solver grades itself. A claim is believed only where the routes are feasible, their recomputed cost is the claimed
one, and the claimed bound does not contradict them; stored claims are looked at again by
`reports.metrics.contradictions`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from formulations.limits import Limits
from formulations.routing.registry import SOLVERS
from formulations.routing.solver import Event, Result, Solver, Status, refusal
from instances import InputError, Instance, as_routes, check_routes, makespan, tour_costs
from instances.best_known import best_known
from instances.files import read_instance, write_instance
from reports.numbers import counted
from reports.record import ITEM_FILES, Run
from reports.tolerances import RELATIVE_ROUNDING, WIDEST_TOLERANCE
from workbench.jobs.problem import Claim, Listener, Outputs, Problem, Published, Source
from workbench.jobs.study_table import FamilyTable, listed, seeds_of
from workbench.jobs.tables import combined, grid
from workbench.problems.publishing import published
from workbench.problems.tables import RoutingTable
from workbench.sources import FamilySource, FileSource, instance_files
from workbench.summary import Summary

if TYPE_CHECKING:
    import pandas as pd

    from reports.columns import Column
    from reports.compare import Comparison

FIRST = ("failed", "solved", "proved", "gap_known", "gap_found", "time", "certified", "gap_bound", "proof_time")
"""Columns of the summary that are left out last."""
LARGE = 500
"""Nodes from which the kept copy of an instance is compressed."""


class Routing(Problem[Instance]):
    """Instances and routes."""

    name = "routing"
    methods = SOLVERS
    item = "instance"
    entries = "solvers"
    study = RoutingTable
    limits = ("threads", "iterations")
    outputs = ("latex", "markdown", "parquet", "against", "figures")
    product = list[list[int]]
    found = "routes"
    statuses = tuple(status.value for status in Status)

    def sources(self, study: RoutingTable, base: Path) -> Iterable[Source[Instance]]:
        """Return the files and families a study names."""
        yield from self.from_files(base / item for item in listed(study.files))
        for number, table in enumerate(study.families, 1):
            yield from (FamilySource(*made) for made in family_grid(table, f"[[families]] {number}"))

    def from_files(self, paths: Iterable[Path]) -> Iterable[Source[Instance]]:
        """Return the instance files meant by files, folders and patterns."""
        return [FileSource(path) for given in paths for path in instance_files(given)]

    def size(self, item: Instance) -> int:
        """Return n."""
        return int(item.n_tasks)

    def write(self, item: Instance, folder: Path) -> None:
        """Keep a copy of the instance, compressed where large."""
        if _kept(folder) is None:
            plain, compressed = ITEM_FILES[self.name]
            write_instance(item, folder / (compressed if item.n_nodes > LARGE else plain))

    def keep_beside(self, source: Source[Instance], folder: Path) -> None:
        """Keep the ensemble of forecasts beside an instance file, where there is one."""
        if isinstance(source, FileSource) and source.has_paths:
            from workbench.tours import keep_ensemble_beside  # here: every run imports this file

            try:
                instance = self.read(folder)
            except InputError:
                return  # the damaged copy is made again, and this asked again, when a run needs it
            keep_ensemble_beside(source.path, instance, folder)

    def read(self, folder: Path) -> Instance:
        """Return the instance kept in `folder`."""
        path = _kept(folder)
        if path is None:
            raise InputError(f"{folder}: the copy of the instance is missing")
        instance = read_instance(path)
        if not folder.name.endswith(instance.digest):
            raise InputError(f"{path}: is not the instance of its folder (its digest is {instance.digest})")
        return instance

    def describe(self, item: Instance) -> dict[str, Any]:
        """Return name, digest, sizes, family, asymmetry, and the best known value [s] where there is one."""
        about = {"name": item.name, "digest": item.digest, "n_tasks": int(item.n_tasks), "n_depots": int(item.n_depots)}
        about |= {"family": str(item.provenance.get("family", "file")), "asymmetry": item.asymmetry}
        known = best_known(item.digest)
        return about | ({"best_known": known.best_known} if known else {})

    def accepts(self, method: Solver, item: Instance) -> str | None:
        """Ask the solver."""
        return refusal(method, item)

    def prepare(self, method: Solver, item: Instance) -> None:
        """Let the solver import and compile."""
        method.prepare(item)

    def solve(self, method: Solver, item: Instance, limits: Limits, seed: int, tell: Listener, start: Any) -> Claim:
        """Run the solver."""

        def observe(event: Event) -> None:
            routes = None if event.routes is None else as_routes(event.routes)
            tell(Claim(routes, event.objective, event.bound))

        begin = None if start is None else as_routes(start)
        result = method.solve(item, limits=limits, seed=seed, observe=observe, start=begin)
        if not isinstance(result, Result):
            raise TypeError(f"solve returned {type(result).__name__} {str(result)[:80]!r}, not a Result")
        return claim_of(result)

    def judge(self, item: Instance, product: Any, claimed: float | None) -> tuple[float | None, str]:
        """Return C_max [s] of the routes and what is wrong with the claim."""
        routes = as_routes(product)
        if wrong := refute_routes(item, routes):
            return None, wrong
        cost = makespan(item, routes)
        return cost, refute_cost(claimed, cost)

    def refute_ending(self, item: Instance, claim: Claim, objective: float | None) -> str:
        """Return what is wrong with status and tolerance."""
        status = Status(claim.status)
        if claim.product is None and (claim.objective is not None or status is Status.FEASIBLE):
            return f"claimed {status} with a longest tour of {claim.objective!r} s, but gave no routes"
        if status is Status.INFEASIBLE:
            return refute_infeasible(item, objective)
        return refute_proof(status, claim.bound, objective, claim.tolerance)

    def own_columns(self, item: Instance, product: Any) -> dict[str, Any]:
        """Return the routes and the cost of each tour."""
        if product is None:
            return {"routes": None, "tour_costs": []}
        return {"routes": [list(route) for route in product], "tour_costs": tour_costs(item, product).tolist()}

    def spell(self, run: Run) -> str:
        """Return the longest tour in seconds."""
        return "no routes" if run.objective is None else f"{run.objective:.6g} s"

    def check(self, folder: Path) -> tuple[str, list[str]]:
        """Return every damaged file, every contradiction and every run that ended in ERROR."""
        from reports.metrics import contradictions  # here: pandas takes its time
        from reports.stores import read_stores

        stores = read_stores(folder)
        runs, found = stores.runs, contradictions(stores.runs)
        failed = runs[(runs["status"] == "ERROR") & ~runs["path"].isin(found["path"])]
        problems = [*stores.warnings]
        problems += [f"{path}: {sentence}" for path, sentence in zip(found["path"], found["sentence"], strict=True)]
        problems += [f"{path}: ERROR: {words}" for path, words in zip(failed["path"], failed["message"], strict=True)]
        return f"{len(runs)} runs on {runs['digest'].nunique()} instances{_bounds_of(runs)}", problems

    def columns(self) -> Sequence[Column]:
        """Return the columns of the summary."""
        from reports.columns import AGAINST, SUMMARY

        return [*SUMMARY, *AGAINST]

    def publish(self, folders: list[Path], outputs: Outputs) -> Published:
        """Summarise the runs per solver, and against an older store where asked."""
        from reports import tables  # here: pandas and matplotlib take their time
        from reports.compare import compare_stores
        from reports.foreign import foreign_notes
        from reports.metrics import contradictions
        from reports.pages.study import write_report
        from reports.stores import read_stores

        against, figures = outputs.extra.get("against"), outputs.extra.get("figures")
        if outputs.page or figures:
            report = write_report(folders, outputs.page, against=[against] if against else (), figures=figures)
            stores, comparison = report.stores, report.comparison
        else:
            stores = read_stores(*folders)
            comparison = compare_stores(stores.runs, read_stores(against).runs) if against else None
        runs = stores.runs
        writers = {"latex": tables.write_latex, "markdown": tables.write_markdown, "parquet": tables.write_parquet}
        for flag, write in writers.items():
            if flag in outputs.extra:
                write(runs, outputs.extra[flag])
        false = contradictions(runs)[["instance", "method", "seed", "sentence"]].itertuples(index=False)
        problems = [*stores.remarks, *(f"{item} {method} seed {seed}: {told}" for item, method, seed, told in false)]
        notes = foreign_notes(runs, stores.claims)
        if comparison:
            (notes if comparison.pairs else problems).extend([*comparison.regressions, *comparison.remarks])
        table, codes = tables.run_table(runs), runs.loc[~runs["foreign"], "code"]
        told = published(
            outputs, table, codes, lambda: _summaries(runs, comparison), problems, stores.damaged, notes=notes
        )
        compared = comparison is None or comparison.pairs > 0
        return replace(told, regressed=bool(comparison and comparison.regressed), comparable=compared)


ROUTING = Routing()


def claim_of(result: Result) -> Claim:
    """Return what a solver's result claims."""
    return Claim(
        None if result.routes is None else as_routes(result.routes),
        result.objective,
        result.bound,
        Status(result.status),
        result.stopped_by,
        result.message,
        result.tolerance,
        result.statistics,
    )


def refute(item: Instance, result: Result) -> str:
    """Return what is wrong with a solver's result on `item`, in a sentence, or ""."""
    claim, objective = claim_of(result), None
    if claim.product is not None:
        objective, wrong = ROUTING.judge(item, claim.product, claim.objective)
        if wrong:
            return wrong
        if objective is not None and claim.bound is not None and claim.bound > objective * (1 + RELATIVE_ROUNDING):
            return f"claimed a lower bound of {claim.bound!r} s, but its routes cost {objective!r} s"
    return ROUTING.refute_ending(item, claim, objective)


def _bounds_of(runs: pd.DataFrame) -> str:
    """Return how many lower bounds were held against all routes, and whose claims they are."""
    stated = runs[runs["bound"].notna()]
    if stated.empty:
        return ""
    return f", {counted(len(stated), 'lower bound')} claimed by {', '.join(sorted(stated['solver'].unique()))}"


def _kept(folder: Path) -> Path | None:
    return next((folder / name for name in ITEM_FILES["routing"] if (folder / name).exists()), None)


def _summaries(runs: pd.DataFrame, comparison: Comparison | None) -> list[Summary]:
    """Return the table of solvers, and what became of each against the older store."""
    from reports.columns import AGAINST, SUMMARY, shown
    from reports.metrics import summary

    found = []
    if not runs.empty:
        table = summary(runs).reset_index()
        found.append(Summary(ROUTING.name, shown(SUMMARY, table), table, first=FIRST))
    if comparison and not comparison.methods.empty:
        found.append(Summary("against", AGAINST, comparison.methods, 2, ("verdict", "better", "worse", "unchanged")))
    return found


def family_grid(table: FamilyTable, where: str) -> list[tuple[str, int, int, int, dict[str, Any]]]:
    """Return every combination a ``[[families]]`` table asks for: family, n, m, seed, parameters, all known."""
    from instances.families import check_family  # here: every run imports this file

    names = listed(table.family)
    combinations = grid(table.parameters, f"{where} parameters")
    for name, combination in combined([names, combinations], where):
        check_family(name, combination)
    return combined([names, listed(table.tasks), listed(table.depots), seeds_of(table.seeds), combinations], where)


def refute_routes(instance: Instance, routes: Sequence[Sequence[int]]) -> str:
    """Return why `routes` [nodes] are not feasible, in a sentence, or "" where they are."""
    faults = check_routes(instance, routes)
    if not faults:
        return ""
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    return f"the routes are not feasible: {faults[0]}{more}"


def refute_cost(claimed: float | None, actual: float) -> str:
    """Return that the claimed longest tour [s] is not the recomputed one, with both numbers, or "" where it is."""
    if claimed is not None and math.isclose(
        claimed, actual, rel_tol=RELATIVE_ROUNDING
    ):  # an infinite cost is close to none
        return ""
    return f"claimed a longest tour of {claimed!r} s, but its routes cost {actual!r} s"


def refute_infeasible(instance: Instance, objective: float | None) -> str:
    """Return why a claim that no routes exist does not hold: its own routes, or those on which one UAV flies all.

    Where each UAV can fly every leg, and as long as it takes, there always are routes.
    """
    if objective is not None:
        return f"claimed INFEASIBLE, but gave routes of {objective!r} s itself"
    if instance.restricted:
        return ""
    routes = [list(instance.tasks), *([] for _ in range(instance.n_depots - 1))]
    return f"claimed INFEASIBLE, but one UAV can fly all tasks in {makespan(instance, routes)!r} s"


def refute_proof(status: Status, bound: float | None, objective: float | None, tolerance: float) -> str:
    """Return why a claim of OPTIMAL does not hold: no routes, no bound, or a gap above the tolerance [s]; or ""."""
    if status is not Status.OPTIMAL:
        return ""
    if objective is None or bound is None:
        return f"claimed OPTIMAL without {'routes' if objective is None else 'a bound'}"
    if not 0 <= tolerance <= WIDEST_TOLERANCE * objective:
        return f"claimed OPTIMAL with a tolerance of {tolerance!r} s, while its routes cost {objective!r} s"
    if objective - bound > tolerance + RELATIVE_ROUNDING * objective:
        return (
            f"claimed OPTIMAL, but its routes cost {objective!r} s and its bound is {bound!r} s, "
            f"further apart than its tolerance of {tolerance!r} s"
        )
    return ""
