"""Contradictions: claims in the store that cannot all be true. A report shows them on top; `workbench check` exits 1.

Each is decided from the routes' re-computed costs and the stored bounds alone:

* *wrong cost*: the stored or the claimed cost is not that of the stored routes;
* *routes not feasible*: a task left out, visited twice, or unknown;
* *no routes*: OPTIMAL or FEASIBLE without routes;
* *bound above routes*: a lower bound above the cost of any run's right routes on the same instance;
* *bound above best known*: a lower bound above the best known value of the literature;
* *OPTIMAL with a gap*: a proof claimed although cost and bound differ by more than the stated tolerance, or
  although that tolerance is itself more than `proofs.WIDEST_TOLERANCE` of the cost;
* *INFEASIBLE refuted*: an instance called infeasible for which another run has routes.

The idea of letting solvers contradict each other comes from PAVER (GAMS World).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pandas as pd

from reports.metrics.gaps import references
from reports.proofs import RELATIVE_ROUNDING, gap_left

KNOWN_ROUNDING = 1e-6
"""Best known values of the literature are rounded; a bound above one by less than this share says nothing."""

COLUMNS = ["kind", "instance", "digest", "method", "seed", "sentence", "path"]


def contradictions(runs: pd.DataFrame) -> pd.DataFrame:
    """Return every contradiction in `runs`, a row each: kind, instance, digest, method, seed, sentence, path."""
    if runs.empty:
        return pd.DataFrame(columns=COLUMNS)
    known = runs.drop(columns="best_known").merge(references(runs), left_on="digest", right_index=True, how="left")
    # any feasible routes refute a bound, also those of a run whose claim was wrong
    costs = runs.assign(_cost=runs["recomputed"].fillna(runs["value"])).dropna(subset=["_cost"])
    best = costs.sort_values("_cost", kind="stable").drop_duplicates("digest").set_index("digest")
    known["best_routes"] = known["digest"].map(best["_cost"])
    known["best_by"] = known["digest"].map(best["method"] + ", seed " + best["seed"].astype(str))
    rows = [row for kind, test in _TESTS.items() for row in _found(kind, test, known)]
    return pd.DataFrame(rows, columns=COLUMNS).sort_values(
        ["instance", "method", "seed"], kind="stable", ignore_index=True
    )


def _found(kind: str, test: Callable[[pd.DataFrame], tuple[pd.Series, Any]], runs: pd.DataFrame) -> Iterator[Any]:
    which, sentence = test(runs)
    for run in runs[which].itertuples():
        yield kind, run.instance, run.digest, run.method, run.seed, sentence(run), run.path


def _differ(a: pd.Series, b: pd.Series) -> pd.Series:
    """Whether two costs differ by more than rounding (or exactly one of them is missing)."""
    return (a - b).abs() > RELATIVE_ROUNDING * pd.concat([a.abs(), b.abs()], axis=1).max(axis=1)


def _wrong_cost(runs: pd.DataFrame) -> tuple[pd.Series, Any]:
    stored = _differ(runs["objective"], runs["recomputed"])
    claimed = (runs["claimed_objective"] - runs["recomputed"]).abs() > KNOWN_ROUNDING * runs["recomputed"].abs()

    def sentence(run: Any) -> str:
        said = run.objective if abs(run.objective - run.recomputed) > 0 else run.claimed_objective
        return f"It claims a longest tour of {said:.9g} s, but its routes cost {run.recomputed:.9g} s."

    return stored | claimed, sentence


def _not_feasible(runs: pd.DataFrame) -> tuple[pd.Series, Any]:
    return runs["fault"] != "", lambda run: f"Its routes are not feasible: {run.fault}"


def _no_routes(runs: pd.DataFrame) -> tuple[pd.Series, Any]:
    nothing = runs["recomputed"].isna() & runs["value"].isna() & (runs["fault"] == "")
    claims = runs["status"].isin(["OPTIMAL", "FEASIBLE"]) & nothing
    return claims, lambda run: f"It is {run.status}, but holds no routes."


def _bound_above_routes(runs: pd.DataFrame) -> tuple[pd.Series, Any]:
    above = runs["bound"] > runs["best_routes"] * (1 + RELATIVE_ROUNDING)

    def sentence(run: Any) -> str:
        return (
            f"Its lower bound of {run.bound:.9g} s is above the routes of {run.best_by}, "
            f"which cost {run.best_routes:.9g} s."
        )

    return above, sentence


def _bound_above_known(runs: pd.DataFrame) -> tuple[pd.Series, Any]:
    above = runs["bound"] > runs["best_known"] * (1 + KNOWN_ROUNDING)
    return (
        above,
        lambda run: f"Its lower bound of {run.bound:.9g} s is above the best known value, {run.best_known:.9g} s.",
    )


def _optimal_with_gap(runs: pd.DataFrame) -> tuple[pd.Series, Any]:
    cost = runs["recomputed"].fillna(runs["objective"])

    def sentence(run: Any) -> str:
        cost = run.recomputed if run.recomputed == run.recomputed else run.objective
        if run.bound != run.bound:
            return f"It is OPTIMAL with routes of {cost:.9g} s, but holds no bound."
        return (
            f"It is OPTIMAL, but its routes cost {cost:.9g} s and its bound is {run.bound:.9g} s, a gap of "
            f"{(cost - run.bound) / cost:.2%} (stated tolerance {run.tolerance:.3g} s)."
        )

    return (runs["status"] == "OPTIMAL") & cost.notna() & gap_left(runs, cost), sentence


def _infeasible_refuted(runs: pd.DataFrame) -> tuple[pd.Series, Any]:
    refuted = (runs["status"] == "INFEASIBLE") & runs["best_routes"].notna()
    return (
        refuted,
        lambda run: f"It calls the instance infeasible, but {run.best_by} has routes of {run.best_routes:.9g} s.",
    )


_TESTS: dict[str, Callable[[pd.DataFrame], tuple[pd.Series, Any]]] = {
    "wrong cost": _wrong_cost,
    "routes not feasible": _not_feasible,
    "no routes": _no_routes,
    "bound above routes": _bound_above_routes,
    "bound above best known": _bound_above_known,
    "OPTIMAL with a gap": _optimal_with_gap,
    "INFEASIBLE refuted": _infeasible_refuted,
}
