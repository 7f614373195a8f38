"""How the runs of a page were made: limits, machines and versions."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from instances import InputError
from instances.errors import one_line
from reports import numbers
from reports.kinds import is_number
from reports.pages.blocks import Block, Facts, Note, Section
from reports.record import code_note, read_json

MOST_FACTS = 60
"""Entries shown of a machine."""
LONGEST_FACT = 300
"""Characters of each."""


def limits_and_machines(runs: pd.DataFrame, environments: Mapping[str, Any]) -> Section:
    """Return the section about `runs`: method, time_limit, threads, created, code, revision, environment (a digest)."""
    named = zip(runs["code"], runs["revision"], strict=True)
    made = ", ".join(sorted({f"{code} ({of})" if of else str(code) for code, of in named} - {""}))
    threads = ", ".join(f"{count:g}" for count in sorted(runs["threads"].dropna().unique()))
    rows = [("Time limit of a run", _limits(runs)), ("Threads of a run", threads)]
    when = sorted({text[:16].replace("T", " ") for text in runs["created"] if isinstance(text, str) and text})
    if when:
        rows.append(("Made", f"{' to '.join(when[:: max(1, len(when) - 1)])} (UTC)"))
    if made:
        rows.append(("Code", made))
    several = runs["environment"].nunique() > 1
    machines = [
        machine(environments.get(str(digest)), f"Machine of {len(group):,} runs" if several else "", str(digest))
        for digest, group in runs.groupby("environment", sort=True)
    ]
    blocks = [Section("Limits", [Facts(rows)]), *machines]
    return Section("Limits, machine, versions", blocks, "limits", "Limits and machine")


def code_notes(codes: Iterable[str]) -> list[Block]:
    """Return what a reader must know about the code that made the runs, nothing where today's made all."""
    note = code_note(codes)
    return [Note(note)] if note else []


def environments_of(paths: Iterable[Path]) -> dict[str, Any]:
    """Return machine and versions by their digest, where the stores of the runs at `paths` state them."""
    found = {}
    for file in {file for path in paths for file in (path.parent.parent / "environments").glob("*.json")}:
        with contextlib.suppress(InputError):
            found[file.stem] = read_json(file)
    return found


def machine(about: Any, title: str = "", digest: str = "") -> Section:
    """Return what an environment, ``{"machine": {…}, "versions": {…}}``, says; or that it is not stated."""
    parts = [about.get(part) for part in ("machine", "versions")] if isinstance(about, dict) else []
    stated = [(str(k), _plain(v, str(k))) for part in parts if isinstance(part, dict) for k, v in part.items()]
    rows = stated[:MOST_FACTS]
    missing = [("Machine", f"not stated in the store ({digest or 'no digest'})")]
    return Section(title or "Machine and versions", [Facts(rows or missing)])


def _limits(runs: pd.DataFrame) -> str:
    """Return the time limits, with the methods of each where there are several."""
    groups = runs.groupby("time_limit")["method"].unique()
    return "; ".join(f"{t:g} s" + (f": {', '.join(sorted(m))}" if len(groups) > 1 else "") for t, m in groups.items())


def _plain(value: Any, key: str) -> str:
    return numbers.memory(value) if key == "memory" and is_number(value) else one_line(str(value), LONGEST_FACT)
