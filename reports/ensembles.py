"""What stored routes take over the members of the ensemble kept beside their instance, computed again."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from instances import InputError, Instance, Routes, as_routes
from instances.errors import naming
from instances.kept_ensemble import kept_ensemble
from instances.wind_ensemble import Spread
from reports.record import SPREAD


def add_spreads(rows: list[dict[str, Any]], folder: Path, instance: Instance, damaged: list[str]) -> None:
    """Put into each of `rows` that has right routes of `instance` its columns ENSEMBLE [s].

    What of the ensemble in `folder` cannot be read, or flown at its speed, is added to `damaged`, one sentence.
    """
    try:
        ensemble = kept_ensemble(folder, instance)
        if ensemble is None:
            return
        known: dict[Routes, Spread] = {}  # methods often end with the same routes
        for row in rows:
            if row["digest"] == instance.digest and not math.isnan(row["recomputed"]):
                routes = as_routes(row["routes"])
                if routes not in known:
                    with naming(folder):
                        known[routes] = ensemble.flown(instance, routes)
                row |= {f"ensemble_{name}": getattr(known[routes], name) for name in SPREAD}
    except InputError as error:
        damaged.append(f"{error}; what routes take over the members of the ensemble is not known.")
