"""What re-planning changed in flight: a sentence on where gain comes from, and a row a re-plan."""

from __future__ import annotations

from typing import Any

import pandas as pd

from reports import numbers
from reports.columns import replans as columns
from reports.pages.blocks import Block, Section, table_of

WHENCE = (
    "With hyperparameters known, what is left unknown does not depend on what was measured, and the best plan in "
    "flight is the rest of the plan at take-off: all gain of re-planning by measurements flows through the "
    "hyperparameters. What else changes plans is what happened."
)


def replanned(said: dict[str, Any] | None, unit: str) -> list[Section]:
    """Return the section about re-plans; none where the mission asks for none."""
    if said is None:
        return []
    rows = said["replans"]
    accepted = sum(row["accepted"] for row in rows)
    blocks: list[Block] = [f"{numbers.counted(len(rows), 're-plan')}, {accepted} accepted. {_budget(said)} {WHENCE}"]
    if said["late"]:
        blocks.append(f"After the last landing came: {', '.join(said['late'])}.")
    if rows:
        blocks.append(table_of(pd.DataFrame([_row(row) for row in rows]), columns(unit), key="replans"))
    blocks.append(
        "The map and the comparison are of the flights as they were flown in the end; the figures of the plan are "
        "those at take-off. Files for ground control there are of both. Events meet no plan but the mission's own."
    )
    return [Section("Plans changed in flight", blocks, "replans", "Re-plans")]


def _budget(said: dict[str, Any]) -> str:
    if said["endurance_given"]:
        return "No plan takes a UAV beyond its endurance, but for straight ways home where nothing else can be flown."
    return f"No endurance is given: no UAV is to spend more than {max(said['budgets']):.1f} s, the longest at take-off."


def _row(row: dict[str, Any]) -> dict[str, Any]:
    lx, ly = row["length_scales"]
    scales = f"{lx / 1e3:.2f}" if lx == ly else f"{lx / 1e3:.2f}, {ly / 1e3:.2f}"
    before, after = ("–" if row[key] is None else f"{row[key]:.3g}" for key in ("sd_before", "sd_after"))
    told = "accepted" if row["accepted"] else "not accepted"
    shown = {"time": row["time"], "reason": row["reason"], "samples": row["samples"], "length_scale": scales}
    return shown | {"before": before, "after": after, "decided": f"{told}: {row['why']}"}
