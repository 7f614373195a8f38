"""What the last map believes of its field, and by how much that was likelier than what else was offered."""

from __future__ import annotations

from typing import Any

import pandas as pd

from reports.columns import EVIDENCE
from reports.pages.blocks import Block, table_of

KERNELS = {
    "se": "the squared exponential",
    "matern52": "Matérn 5/2",
    "matern32": "Matérn 3/2",
    "matern12": "Matérn 1/2",
}
"""Kernel → its name in a sentence."""
MEANS = {"constant": "a constant level", "path-loss": "path loss", "propagation": "the predicted signal"}
"""Mean → its name in a sentence."""


def map_model(said: dict[str, Any] | None, unit: str) -> list[Block]:
    """Return a sentence about the model, and the table of likelihoods where several were compared."""
    if said is None:
        return []
    evidence = pd.DataFrame(said["evidence"], columns=["kernel", "mean", "log_likelihood"])
    if evidence.empty:
        return [f"{_sentence(said, unit)} It is what was believed at take-off."]
    if len(evidence) == 1:
        return [f"{_sentence(said, unit)} It was fitted by restricted likelihood."]
    ranked = evidence.sort_values("log_likelihood", ascending=False, kind="stable")
    ranked["behind"] = ranked["log_likelihood"].max() - ranked["log_likelihood"]
    told = (
        f"{_sentence(said, unit)} It was chosen by restricted likelihood, {_ahead(said, ranked)}. "
        "Task locations were planned under the squared exponential all the same: its derivatives and bounds are those "
        "of a smooth field."
    )
    return [told, table_of(ranked, EVIDENCE, key="evidence")]


def _ahead(said: dict[str, Any], ranked: pd.DataFrame) -> str:
    """Return how far what was chosen was ahead of the next, or behind the likeliest and why it was taken."""
    own = ranked[(ranked["kernel"] == said["kernel"]) & (ranked["mean"] == said["mean"])]
    if own.empty or own.iloc[0]["behind"] == 0.0:
        second = ranked.iloc[1]
        return f"{second['behind']:.1f} nats ahead of {_named(second)}"
    behind = f"{own.iloc[0]['behind']:.1f} nats behind {_named(ranked.iloc[0])}"
    if said["kernel"] != "matern12":
        return f"which counts length scales of each kernel in two directions; with one it is {behind}"
    return f"{behind}, as rough ground asks for it where it is nearly as likely"


def _named(row: Any) -> str:
    return f"{KERNELS.get(row['kernel'], row['kernel'])} about {MEANS.get(row['mean'], row['mean'])}"


def _sentence(said: dict[str, Any], unit: str) -> str:
    (lx, ly), signal = said["length_scales"], said["signal_sd"]
    ways = ("along x", "along y")
    if direction := said.get("direction", 0.0):
        ways = (f"along {direction:.0f}° (counter-clockwise from the x axis)", "across")
    if said["kernel"] == "matern12":  # the data tells no more of it
        slopes = [f"{signal**2 / scale * 1e3:.3g} {unit}² a kilometre" for scale in (lx, ly)]
        scales = f"σ_f²/l = {_both(slopes, ways)}"
    else:
        scales = f"σ_f = {signal:.1f} {unit}, l = {_both([f'{scale / 1e3:.1f} km' for scale in (lx, ly)], ways)}"
    nugget = f", a nugget of {said['nugget_sd']:.2g} {unit}" if said["nugget_sd"] >= 0.01 else ""
    factor = f" times {said['coefficients'][1]:.2f}" if len(said["coefficients"]) > 1 else ""
    return f"The last map is {_named(said)}{factor}: {scales}{nugget}.{_shadows(said, unit)}{_drift(said)}"


def _both(told: list[str], ways: tuple[str, str]) -> str:
    """Return one number where both are told alike, else each with its way."""
    return told[0] if told[0] == told[1] else f"{told[0]} {ways[0]} and {told[1]} {ways[1]}"


def _shadows(said: dict[str, Any], unit: str) -> str:
    """Return how the field varies with what the mean predicts; "" where it does not."""
    if (contrast := said.get("contrast")) is None:
        return ""
    if (in_sight := said.get("in_sight")) is None:  # a map made before losses were told from the signal
        return (
            f" Where the predicted signal differs by {contrast:.1f} {unit}, readings tell 1/e as much of one another."
        )
    return (
        f" Where the predicted loss behind obstacles differs by {contrast:.1f} dB, readings tell 1/e as much of one "
        f"another; in sight the signal is off its prediction by {in_sight:.2f} times as much as deep in shadow."
    )


def _drift(said: dict[str, Any]) -> str:
    """Return how fast the field is believed to drift, and by how much that was likelier; "" where nobody asked."""
    tau, ahead = said.get("tau"), said.get("drift")
    why = "" if ahead is None else f"; a field that drifts was {abs(ahead):.1f} nats "
    why += "" if ahead is None else "likelier than one that stays" if ahead > 0 else "less likely than one that stays"
    if tau is not None:
        return f" The field drifts: what a reading tells falls to 1/e in τ = {tau:.3g} s{why}."
    return "" if ahead is None else f" The field is taken to stay{why}, and τ is a parameter more."
