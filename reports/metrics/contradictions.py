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
    rows = [
        (kind, run.instance, run.digest, run.method, run.seed, sentence(run), run.path)
        for kind, which, sentence in _tests(known)
        for run in known[which].itertuples()
    ]
    found = pd.DataFrame(rows, columns=COLUMNS)
    return found.sort_values(["instance", "method", "seed"], kind="stable", ignore_index=True)


def _tests(runs: pd.DataFrame) -> Iterator[tuple[str, pd.Series, Callable[[Any], str]]]:
    """Yield each kind of contradiction, which of `runs` show it, and what says so in a sentence."""
    costs, bounds = runs["recomputed"], runs["bound"]
    stored = _differ(runs["objective"], costs)
    claimed = (runs["claimed_objective"] - costs).abs() > KNOWN_ROUNDING * costs.abs()
    yield "wrong cost", stored | claimed, _wrong_cost
    yield "routes not feasible", runs["fault"] != "", lambda run: f"Its routes are not feasible: {run.fault}"
    nothing = costs.isna() & runs["value"].isna() & (runs["fault"] == "")
    claims = runs["status"].isin(["OPTIMAL", "FEASIBLE"])
    yield "no routes", claims & nothing, lambda run: f"It is {run.status}, but holds no routes."
    yield (
        "bound above routes",
        bounds > runs["best_routes"] * (1 + RELATIVE_ROUNDING),
        lambda run: (
            f"Its lower bound of {run.bound:.9g} s is above the routes of {run.best_by}, which cost "
            f"{run.best_routes:.9g} s."
        ),
    )
    yield (
        "bound above best known",
        bounds > runs["best_known"] * (1 + KNOWN_ROUNDING),
        lambda run: f"Its lower bound of {run.bound:.9g} s is above the best known value, {run.best_known:.9g} s.",
    )
    cost = costs.fillna(runs["objective"])
    proof = (runs["status"] == "OPTIMAL") & cost.notna() & gap_left(runs, cost)
    yield "OPTIMAL with a gap", proof, _optimal_with_gap
    refuted = (runs["status"] == "INFEASIBLE") & runs["best_routes"].notna()
    yield (
        "INFEASIBLE refuted",
        refuted,
        lambda run: f"It calls the instance infeasible, but {run.best_by} has routes of {run.best_routes:.9g} s.",
    )


def _differ(a: pd.Series, b: pd.Series) -> pd.Series:
    """Whether two costs differ by more than rounding (or exactly one of them is missing)."""
    return (a - b).abs() > RELATIVE_ROUNDING * pd.concat([a.abs(), b.abs()], axis=1).max(axis=1)


def _wrong_cost(run: Any) -> str:
    said = run.objective if abs(run.objective - run.recomputed) > 0 else run.claimed_objective
    return f"It claims a longest tour of {said:.9g} s, but its routes cost {run.recomputed:.9g} s."


def _optimal_with_gap(run: Any) -> str:
    cost = run.recomputed if run.recomputed == run.recomputed else run.objective
    if run.bound != run.bound:
        return f"It is OPTIMAL with routes of {cost:.9g} s, but holds no bound."
    return (
        f"It is OPTIMAL, but its routes cost {cost:.9g} s and its bound is {run.bound:.9g} s, a gap of "
        f"{(cost - run.bound) / cost:.2%} (stated tolerance {run.tolerance:.3g} s)."
    )
