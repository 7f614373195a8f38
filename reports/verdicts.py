"""Verdicts: whether one way to fly maps better than others, from a paired comparison over fields and noise.

Every way to fly is measured and mapped over the same fields with the same noise seeds; the one wins where the
whole 95 % interval of the difference of RMSE lies on its side, loses where it lies on the other, and else it is a draw.
A way nobody may fly does not count.
"""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from reports import numbers
from reports.statistics.paired import Paired, paired

MISSION = "mission"
MEANS = ("count", "length", "longest", "outside", "samples", "information",
         "rmse", "nlpd", "coverage", "mean_sd", "max_sd")  # fmt: skip
"""Columns of which a plan's row has the mean over its draws."""


@dataclass(frozen=True)
class Verdict:
    """The mission, or another plan `by`, against one baseline: mean RMSE and length of both, RMSE and NLPD minus its.

    refused : why nobody may fly the baseline, or ""; dropped : how many of its draws are left out for that.
    """

    name: str
    own: pd.Series
    other: pd.Series
    rmse: Paired
    nlpd: Paired
    refused: str
    dropped: int
    by: str = MISSION

    @property
    def turned(self) -> Paired:
        """The difference of RMSE the other way round: the baseline's less the mission's."""
        own = self.rmse
        return Paired(-own.mean, -own.high, -own.low, own.pairs, own.pairs - own.negative)

    @property
    def outcome(self) -> str:
        """Whether the mission "wins", "loses" or "draws"; "not flyable" and "one draw" where nothing can be said."""
        if self.refused:
            return "not flyable"
        if self.rmse.pairs < 2:
            return "one draw"
        return {-1: "wins", 0: "draws", 1: "loses"}[self.rmse.sign]


def verdicts(draws: pd.DataFrame, by: str = MISSION) -> list[Verdict]:
    """Return a verdict a baseline, on the plan `by`.

    draws : a row a plan and draw, `refused` "" where it may be flown.
    """
    own = draws[draws["name"] == by].set_index("draw")
    found = []
    for name, rows in draws[draws["name"] != by].groupby("name", sort=False):
        other = rows.set_index("draw")
        flyable = other["refused"] == ""
        counted = other[flyable] if flyable.any() else other
        mine = own.loc[counted.index]
        columns = ["rmse", "nlpd", "length"]
        found.append(
            Verdict(
                str(name),
                mine[columns].mean(),
                counted[columns].mean(),
                paired(mine["rmse"] - counted["rmse"]),
                paired(mine["nlpd"] - counted["nlpd"]),
                "" if flyable.any() else str(other["refused"].iloc[0]),
                int((~flyable).sum()) if flyable.any() else 0,
                by,
            )
        )
    return found


def plans(draws: pd.DataFrame) -> pd.DataFrame:
    """Return a row a plan: the means over its draws (those that may be flown where any may), the verdict on it."""
    rows = []
    judged = {verdict.name: verdict for verdict in verdicts(draws)}
    for name, own in draws.groupby("name", sort=False):
        flyable = own[own["refused"] == ""]
        row = {"name": name, "draws": len(own), **(flyable if len(flyable) else own)[list(MEANS)].mean()}
        verdict = judged.get(str(name))
        if verdict is not None:
            row |= {"more_rmse": verdict.turned.mean, "low": verdict.turned.low, "high": verdict.turned.high}
        said = {"verdict": verdict.outcome, "refused": verdict.refused} if verdict else {"verdict": "", "refused": ""}
        rows.append(row | said)
    return pd.DataFrame(rows)


BEGINNINGS = {"wins": "{} wins against", "loses": "{} loses to", "draws": "A draw of {} with"}


def sentence(verdict: Verdict, unit: str, over: str) -> str:
    """Return what is found, in plain words. over : of what the draws are, such as "8 noise seeds"."""
    own, other, name = verdict.own, verdict.other, named(verdict.name)
    means = f"{' against '.join(numbers.apart(own['rmse'], other['rmse']))}{_of(unit)}"
    longer = other["length"] / own["length"] - 1
    length = f"{name} {'take' if name.endswith('s') else 'takes'} {abs(longer):.0%} "
    length += "more flying" if longer >= 0 else "less flying"
    if verdict.outcome == "not flyable":
        return (
            f"Nobody may fly {name}, so it does not count: {verdict.refused}; the RMSE would be {means}, and {length}."
        )
    if verdict.outcome == "one draw":
        return f"No winner is named against {name}, as nothing was drawn again: RMSE {means}; {length}."
    left_out = f", {verdict.dropped} more of which nobody may fly" if verdict.dropped else ""
    error, density = _differs(verdict.rmse, unit), _differs(verdict.nlpd, "nats")
    said = f"{_beginning(verdict)} {name} over {over}{left_out}"
    return f"{said}: its RMSE {error}, {means}; its NLPD {density}; {length}."


def _beginning(verdict: Verdict) -> str:
    if verdict.by == MISSION and verdict.outcome == "draws":
        return "A draw with"
    return BEGINNINGS[verdict.outcome].format("The mission" if verdict.by == MISSION else verdict.by)


def named(plan: str) -> str:
    """Return a plan's name as it stands in a sentence."""
    return {"lawnmower": "the lawnmower", "random": "random tours", "greedy": "greedy placement"}.get(plan, plan)


def _of(unit: str) -> str:
    return f" {unit}" if unit else ""


def difference(found: Paired) -> tuple[str, str, str]:
    """Return mean, low and high with their signs, in digits that show how the interval lies to 0."""
    ends = (found.mean, found.low, found.high)
    least = min(map(abs, ends)) if found.sign else found.high - found.low
    mean, low, high = numbers.signed(ends, least)
    return mean, low, high


def _differs(found: Paired, unit: str) -> str:
    mean, low, high = difference(found)
    if found.sign == 0:
        return f"differs by {mean}{_of(unit)}, which may be chance (95 % interval {low} to {high})"
    ends = sorted((low.lstrip("−+"), high.lstrip("−+")), key=float)
    side = "higher" if found.sign > 0 else "lower"
    same = f"{found.negative if found.sign < 0 else found.pairs - found.negative} of {found.pairs}"
    return f"is {mean.lstrip('−+')}{_of(unit)} {side} (95 % interval {ends[0]} to {ends[1]}; {side} in {same})"
