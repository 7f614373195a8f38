"""Best known values of public and generated instances, found by the digest of the instance.

The table ``data/best_known.csv`` states facts, each with its source: ``best_known`` [s, or the unit of the instance] is
the longest tour of the best routes known, ``bound`` a lower bound or empty, ``proven`` whether the two meet within one
part in a million; ``data/tours.json`` holds the routes of values found here. Where a source gives three decimals, so
does the table: see `BestKnown.reached`.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from types import MappingProxyType


@dataclass(frozen=True)
class BestKnown:
    """What is known of one instance."""

    instance: str
    digest: str
    n_tasks: int
    n_depots: int
    best_known: float
    proven: bool
    bound: float | None
    source: str

    @property
    def rounding(self) -> float:
        """By how much the value may have been rounded [s]: half a unit of the third decimal that sources give."""
        return 5e-4 + 1e-9 * abs(self.best_known)

    def reached(self, objective: float) -> bool:
        """Return whether `objective` is as good, within the rounding."""
        return objective <= self.best_known + self.rounding


def best_known(digest: str) -> BestKnown | None:
    """Return what is known of the instance with this digest, None where nothing is."""
    return table().get(digest)


@cache
def table() -> Mapping[str, BestKnown]:
    """Return the whole table by digest."""
    text = files("instances").joinpath("data/best_known.csv").read_text(encoding="utf-8")
    return MappingProxyType({row["digest"]: entry(row) for row in csv.DictReader(text.splitlines())})


def entry(row: Mapping[str, str]) -> BestKnown:
    """Return what a row of the table says; KeyError or ValueError where it says nothing."""
    return BestKnown(
        row["instance"],
        row["digest"],
        int(row["n_tasks"]),
        int(row["n_depots"]),
        float(row["best_known"]),
        row["proven"] == "true",
        float(row["bound"]) if row["bound"] else None,
        row["source"],
    )
