"""In the terminal: a table of a study that is drawn again as it runs."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import click
from rich import box
from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from instances.errors import LONGEST_VALUE, one_line
from workbench.jobs.watching import Look, Watch

EVERY = 2.0
"""Seconds between two looks."""


def watch_in_terminal(folder: Path, as_json: bool) -> int:
    """Show how far the study in `folder` has got until it is complete; return the exit code, 1 for damaged files.

    as_json : one JSON object a line instead, wherever something has changed. InputError where `folder` is no store.
    """
    watch = Watch(folder)
    look, told = watch.look(), ""
    with Live(console=Console(), auto_refresh=False) as live:
        while True:
            if as_json and (line := json.dumps(as_dict(look))) != told:
                told = line
                click.echo(line)
            if not as_json:
                live.update(_drawn(look), refresh=True)
            if look.complete:
                break
            time.sleep(EVERY)
            look = watch.look()
    for sentence in look.census.damaged:
        click.echo(sentence, err=True)
    return 1 if look.census.damaged else 0


def as_dict(look: Look) -> dict[str, Any]:
    """Return a look as JSON values: the keys of ``status --json`` and more."""
    counts = look.census
    return {
        "planned": counts.planned,
        "stored": counts.stored,
        "missing": counts.missing,
        "stale": counts.stale,
        "foreign": counts.foreign,
        "failed": counts.failed,
        "running": list(look.running),
        "left": None if look.left is None else round(look.left, 1),
        "complete": look.complete,
        "by_solver": counts.by_solver,
        "damaged": list(counts.damaged),
    }


def _drawn(look: Look) -> Group:
    statuses = sorted({status for counts in look.census.by_solver.values() for status in counts})
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("Solver", overflow="fold")
    for status in (*statuses, "stored"):
        table.add_column(Text(one_line(status, LONGEST_VALUE)), justify="right")
    for label, counts in sorted(look.census.by_solver.items()):
        cells = [*(str(counts[status]) if counts[status] else "" for status in statuses), str(sum(counts.values()))]
        table.add_row(Text(one_line(label, LONGEST_VALUE)), *cells)
    parts: list[Table | Text] = [table] if look.census.by_solver else []
    latest = [f"{run.instance} {run.label} seed {run.seed}: {run.status}" for run in look.latest[:3]]
    return Group(*parts, *(Text(one_line(line, LONGEST_VALUE)) for line in latest), Text(look.sentence))
