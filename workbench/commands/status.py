"""`workbench status`: say how far a study has got."""

from __future__ import annotations

import json
from pathlib import Path

import click

from workbench.options import JSON
from workbench.terminal import say


@click.command("status")
@click.argument("folder", metavar="RUNS-DIR", type=click.Path(path_type=Path))
@click.option("--watch", is_flag=True, help="Look again every 2 s, until the study is complete or Ctrl-C.")
@JSON
@click.pass_context
def command(context: click.Context, folder: Path, watch: bool, as_json: bool) -> None:
    """Count what is stored in RUNS-DIR, by solver and status, and what is missing. Exit code 1 for damaged files.

    \b
    Examples:
      workbench status runs/quick
      workbench status runs/quick --json
      workbench status runs/quick --watch
    """
    if watch:
        from workbench.watching.terminal import watch_in_terminal

        context.exit(watch_in_terminal(folder, as_json))
    from instances.errors import LONGEST_VALUE, one_line
    from instances.natural import natural
    from reports.record import STATUSES
    from workbench.jobs.census import census

    found = census(folder)
    if as_json:
        counts = {
            "planned": found.planned,
            "stored": found.stored,
            "missing": found.missing,
            "stale": found.stale,
            "foreign": found.foreign,
        }
        click.echo(json.dumps(counts | {"by_solver": found.by_solver, "damaged": found.damaged}))
    else:
        ended = {status for counts in found.by_solver.values() for status in counts}
        known = STATUSES["routing"]
        seen = [*(name for name in known if name in ended), *sorted(ended.difference(known))]
        width = max([len(one_line(label, LONGEST_VALUE)) for label in found.by_solver], default=0)
        for label, counts in sorted(found.by_solver.items(), key=lambda item: natural(item[0])):
            told = ", ".join(f"{counts[status]} {one_line(status, LONGEST_VALUE)}" for status in seen if counts[status])
            say(f"{one_line(label, LONGEST_VALUE):{width}}  {sum(counts.values()):6d} stored: {told}")
        stale = f", {found.stale} of them stale (made by other code)" if found.stale else ""
        foreign = f"; {found.foreign} foreign (imported)" if found.foreign else ""
        damaged = f", {len(found.damaged)} damaged" if found.damaged else ""
        say(f"{found.stored} of {found.planned} runs stored{stale}{damaged}, {found.missing} missing{foreign}")
        for sentence in found.damaged:
            say(sentence, err=True)
    context.exit(1 if found.damaged else 0)
