"""Compare: a new store against a baseline, method by method on the instances both hold: better, worse, unchanged.

Quality: the median over seeds of the cost, relative to the baseline's. Time: the median time to the proof for methods
that prove, a run without one counting twice its limit. Differences below `QUALITY_ROUNDING` and `TIME_ROUNDING` are
unchanged. Whether a difference over all instances is more than chance is decided as in `reports.statistics.pairwise`,
Holm's correction running over the methods.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from instances.arrays import Floats
from instances.natural import natural
from reports.metrics import contradictions, penalised, time_to_proof
from reports.numbers import counted
from reports.statistics import ALPHA, bootstrap_interval, holm, signed_rank
from reports.statistics.pairwise import enough

QUALITY_ROUNDING = 1e-6
"""Relative change of a cost that is none."""
TIME_ROUNDING = 0.10
"""Relative change of a time that is none: machines are not that steady."""


@dataclass(frozen=True)
class Comparison:
    """What became of each method and instance.

    pairs : runs of the new store that have a partner in the baseline. methods : a row a method and measure ("quality",
    "time to proof"): instances, better, worse, unchanged, mean relative `change` with its interval, p, p_holm, verdict.
    instances : a row an instance and method with both values [s]. regressions : a sentence for each significant
    worsening and for new contradictions. remarks : proofs won and lost, runs without a partner.
    """

    pairs: int
    methods: pd.DataFrame
    instances: pd.DataFrame
    regressions: list[str]
    remarks: list[str]

    @property
    def regressed(self) -> bool:
        """Whether anything got worse for certain."""
        return bool(self.regressions)


METHOD_COLUMNS = [
    "method", "measure", "instances", "better", "worse", "unchanged", "change", "low", "high", "p", "p_holm", "verdict",
]  # fmt: skip
INSTANCE_COLUMNS = ["instance", "method", "baseline", "new", "change", "verdict"]


def compare_stores(new: pd.DataFrame, baseline: pd.DataFrame) -> Comparison:
    """Compare the frame `new` with `baseline`; runs are paired by instance (digest), method, limit and seed."""
    keys = ["digest", "method", "time_limit", "seed"]
    common = set(map(tuple, new[keys].to_numpy())) & set(map(tuple, baseline[keys].to_numpy()))
    mine, theirs = (frame[[tuple(key) in common for key in frame[keys].to_numpy()]] for frame in (new, baseline))
    rows, each = [], []
    for method in sorted(mine["method"].unique(), key=natural):
        a, b = mine[mine["method"] == method], theirs[theirs["method"] == method]
        cost_a, cost_b = _medians(a, a["value"].fillna(np.inf)), _medians(b, b["value"].fillna(np.inf))
        rows.append((method, "quality", *_compared(cost_a, cost_b, QUALITY_ROUNDING)))
        names = a.groupby("digest")["instance"].first()
        for digest, (now, before) in pd.DataFrame({"now": cost_a, "before": cost_b}).iterrows():
            changed = _relative(np.array([now]), np.array([before]))[0]
            each.append((names[digest], method, before, now, changed, _word(changed, QUALITY_ROUNDING)))
        if a["proved"].any() or b["proved"].any():
            time_a, time_b = (_medians(f, penalised(time_to_proof(f), f["time_limit"])) for f in (a, b))
            rows.append((method, "time to proof", *_compared(time_a, time_b, TIME_ROUNDING)))
    methods = _judged(pd.DataFrame(rows, columns=METHOD_COLUMNS[:-2]))
    instances = pd.DataFrame(each, columns=INSTANCE_COLUMNS)
    lies = len(contradictions(new)) - len(contradictions(baseline))
    pairing = (
        f"{len(mine):,} runs have a partner in the baseline (same instance, method, limit and seed); "
        f"{len(new) - len(mine):,} are only in the new store and {len(baseline) - len(mine):,} only in the baseline."
    )
    remarks = [pairing, *_proofs(mine, theirs)] if len(mine) else [_apart(new, baseline)]
    return Comparison(len(mine), methods, instances, _regressions(methods, lies), remarks)


def _apart(new: pd.DataFrame, baseline: pd.DataFrame) -> str:
    """Return why no run of `new` has a partner in `baseline`: the first column in which they have nothing in common."""
    nouns = {"digest": "instance", "method": "method", "time_limit": "time limit [s]", "seed": "seed"}
    mine, theirs = new, baseline
    for key, noun in nouns.items():
        common = set(mine[key]) & set(theirs[key])
        if not common:
            shown = "instance" if key == "digest" else key
            here, there = (_some(frame[shown]) for frame in (mine, theirs))
            other = "; those of one name have other costs" if set(mine[shown]) & set(theirs[shown]) else ""
            return f"Nothing to compare: the stores have no {noun} in common (here: {here}; there: {there}{other})."
        mine, theirs = (frame[frame[key].isin(common)] for frame in (mine, theirs))
    return "Nothing to compare: no run here has a partner there with the same instance, method, limit and seed."


def _some(values: pd.Series) -> str:
    """Return a few of the values, in their order."""
    found = sorted({f"{value:g}" if isinstance(value, float) else str(value) for value in values}, key=natural)
    return ", ".join(found[:3]) + (f" and {len(found) - 3} more" if len(found) > 3 else "") or "none"


def _medians(runs: pd.DataFrame, values: pd.Series) -> pd.Series:
    return values.groupby(runs["digest"]).median().sort_index()


def _relative(now: Floats, before: Floats) -> Floats:
    """Return (now − before) / before; infinite where only one is, 0 where both are or nothing changed."""
    finite = np.isfinite(now) & np.isfinite(before)
    change = np.where(now > before, np.inf, np.where(now < before, -np.inf, 0.0))
    np.subtract(now, before, out=change, where=finite)
    return np.divide(change, before, out=change, where=finite & (before > 0))


def _compared(a: pd.Series, b: pd.Series, rounding: float) -> tuple[int, int, int, int, float, float, float, float]:
    change = _relative(a.to_numpy(float), b.reindex(a.index).to_numpy(float))
    change = np.where(np.abs(change) <= rounding, 0.0, change)
    finite = change[np.isfinite(change)]
    largest = 2 * np.abs(finite).max(initial=1.0)
    p = signed_rank(np.clip(change, -largest, largest))[1] if change.size else 1.0
    counts = int((change < 0).sum()), int((change > 0).sum()), int((change == 0).sum())
    mean = float(finite.mean()) if finite.size else float("nan")
    return (len(change), *counts, mean, *bootstrap_interval(finite), p)


def _judged(methods: pd.DataFrame) -> pd.DataFrame:
    corrected = holm(methods["p"].to_numpy(float))
    verdicts = []
    for row, p in zip(methods.itertuples(), corrected, strict=True):
        better, worse = int(str(row.better)), int(str(row.worse))
        if better + worse == 0:
            verdicts.append("unchanged")
        elif not enough(better + worse, len(methods)):
            verdicts.append("too few instances to conclude")
        elif p >= ALPHA:
            verdicts.append("no significant change")
        else:
            verdicts.append("better" if better > worse else "worse")
    return methods.assign(p_holm=corrected, verdict=verdicts)[METHOD_COLUMNS]


def _word(change: float, rounding: float) -> str:
    return "unchanged" if abs(change) <= rounding else "better" if change < 0 else "worse"


def _regressions(methods: pd.DataFrame, lies: int) -> list[str]:
    said = [
        f"{row.method}: {row.measure} is significantly worse: worse on {row.worse}, better on {row.better} of "
        f"{row.instances} instances (p = {row.p_holm:.2g} after Holm's correction)."
        for row in methods.itertuples()
        if row.verdict == "worse"
    ]
    more = f"The new store holds {counted(lies, 'contradiction')} more than the baseline."
    return [*said, *([more] if lies > 0 else [])]


def _proofs(mine: pd.DataFrame, theirs: pd.DataFrame) -> list[str]:
    said = []
    for method in sorted(mine["method"].unique()):
        now, before = (set(f.loc[f["proved"] & (f["method"] == method), "instance"]) for f in (mine, theirs))
        if now != before:
            won, lost = sorted(now - before), sorted(before - now)
            said.append(f"{method}: {_named(won)} newly proved, {_named(lost)} no longer.")
    return said


def _named(instances: list[str]) -> str:
    some = ", ".join(instances[:3]) + (", …" if len(instances) > 3 else "")
    return f"{len(instances)} instances{f' ({some})' if instances else ''}"
