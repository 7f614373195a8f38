"""Contradictions: claims in the store that cannot all be true. A report shows them on top; `workbench check` exits 1.

Each is decided from the routes' re-computed costs and the stored bounds alone:

* *wrong cost*: the stored or the claimed cost is not that of the stored routes;
* *routes not feasible*: a task left out, visited twice, or unknown;
* *no routes*: OPTIMAL or FEASIBLE without routes;
* *bound above routes*: a lower bound, at the end or streamed on the way, above the cost of any run's right routes on
  the same instance;
* *bound without a proof*: a bound that is bit for bit the cost of the run's own routes, of a method that cannot prove
  anything and does not say OPTIMAL: the mark of a false bound that was cut off there;
* *trace below routes*: a trace that claims better routes than those stored;
* *bound above best known*: a lower bound above the best known value of the literature;
* *OPTIMAL with a gap*: a proof claimed although cost and bound differ by more than the stated tolerance, or
  although that tolerance is itself more than `tolerances.WIDEST_TOLERANCE` of the cost;
* *INFEASIBLE refuted*: an instance called infeasible for which some run has routes, or where each UAV can fly every
  leg and as long as it takes, so that there always are routes;
* *routes denied*: NO_SOLUTION beside routes.

The idea of letting solvers contradict each other comes from PAVER (GAMS World).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pandas as pd

from reports.metrics.gaps import references
from reports.order import naturally
from reports.proofs import cut_off, gap_left, refuted_bounds, streamed_bounds
from reports.tolerances import RELATIVE_ROUNDING

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
    known["streamed"] = streamed_bounds(known)
    known["best_by"] = known["digest"].map(best["method"] + ", seed " + best["seed"].astype(str))
    rows = [
        (kind, run.instance, run.digest, run.method, run.seed, sentence(run), run.path)
        for kind, which, sentence in _tests(known)
        if which.any()  # hardly ever, and choosing no rows takes pandas as long as choosing some
        for run in known[which].itertuples()
    ]
    found = pd.DataFrame(rows, columns=COLUMNS)
    return found.sort_values(["instance", "method", "seed"], kind="stable", ignore_index=True, key=naturally)


def _tests(runs: pd.DataFrame) -> Iterator[tuple[str, pd.Series, Callable[[Any], str]]]:
    """Yield each kind of contradiction, which of `runs` show it, and what says so in a sentence."""
    costs, bounds = runs["recomputed"], runs["bound"]
    stored = _differ(runs["objective"], costs, RELATIVE_ROUNDING)
    claimed = _differ(runs["claimed_objective"], costs, KNOWN_ROUNDING)
    yield "wrong cost", stored | claimed, _wrong_cost
    yield "routes not feasible", runs["fault"] != "", lambda run: f"Its routes are not feasible: {run.fault}"
    nothing = costs.isna() & runs["value"].isna() & (runs["fault"] == "")
    claims = runs["status"].isin(["OPTIMAL", "FEASIBLE"])
    yield "no routes", claims & nothing, lambda run: f"It is {run.status}, but holds no routes."
    yield "bound above routes", refuted_bounds(runs), _bound_above_routes
    yield "bound without a proof", cut_off(runs) & ~runs["proves"].astype(bool), _bound_without_proof
    yield "trace below routes", _below(runs, costs), _trace_below_routes
    yield (
        "bound above best known",
        bounds > runs["best_known"] * (1 + KNOWN_ROUNDING),
        lambda run: f"Its lower bound of {run.bound:.9g} s is above the best known value, {run.best_known:.9g} s.",
    )
    cost = costs.fillna(runs["objective"])
    proof = (runs["status"] == "OPTIMAL") & cost.notna() & gap_left(runs, cost)
    yield "OPTIMAL with a gap", proof, _optimal_with_gap
    never = ~runs["restricted"].astype(bool) | runs["best_routes"].notna()
    yield "INFEASIBLE refuted", (runs["status"] == "INFEASIBLE") & never, _infeasible
    denied = (runs["status"] == "NO_SOLUTION") & costs.notna()
    yield "routes denied", denied, lambda run: f"It is NO_SOLUTION, but holds routes of {run.recomputed:.9g} s."


def _differ(a: pd.Series, b: pd.Series, rounding: float) -> pd.Series:
    """Whether two known costs differ by more than the share `rounding`; an infinite one equals none but itself."""
    return a.notna() & b.notna() & ~np.isclose(a.astype(float), b.astype(float), rtol=rounding, atol=0)


def _below(runs: pd.DataFrame, costs: pd.Series) -> pd.Series:
    """Whether a run's trace claims an objective below its routes' cost."""
    least = pd.Series([np.fmin.reduce(trace[:, 1], initial=np.nan) for trace in runs["trace"]], runs.index, dtype=float)
    return least < costs * (1 - RELATIVE_ROUNDING)


def _bound_above_routes(run: Any) -> str:
    told = f"{run.best_by}, which cost {run.best_routes:.9g} s."
    if run.bound > run.best_routes * (1 + RELATIVE_ROUNDING):
        return f"Its lower bound of {run.bound:.9g} s is above the routes of {told}"
    return f"A lower bound of {run.streamed:.9g} s in its trace is above the routes of {told}"


def _bound_without_proof(run: Any) -> str:
    return (
        f"Its lower bound is to the last digit what its routes cost, {run.objective:.9g} s, but it is {run.status} and "
        "its method proves nothing."
    )


def _trace_below_routes(run: Any) -> str:
    least = np.nanmin(run.trace[:, 1])
    return f"Its trace claims routes of {least:.9g} s, but those it holds cost {run.recomputed:.9g} s."


def _infeasible(run: Any) -> str:
    if run.recomputed == run.recomputed:
        return f"It calls the instance infeasible, but holds routes of {run.recomputed:.9g} s."
    if run.best_routes == run.best_routes:
        return f"It calls the instance infeasible, but {run.best_by} has routes of {run.best_routes:.9g} s."
    return "It calls the instance infeasible, but each UAV can fly all legs and as long as it takes: there are routes."


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
