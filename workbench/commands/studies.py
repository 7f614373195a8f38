"""`workbench studies`: list the studies that come with the workbench."""

from __future__ import annotations

import json

import click

from workbench.options import JSON
from workbench.terminal import say


@click.command("studies")
@JSON
def command(as_json: bool) -> None:
    """List the shipped studies: what each compares, and how many runs that are at most.

    `workbench compare STUDY --dry-run` says how long they take.

    \b
    Examples:
      workbench studies
      workbench compare quick --out runs/quick
    """
    from workbench.jobs.study import load_tables, shipped_studies, study_from
    from workbench.problems import PROBLEMS

    found = {}
    for name, path in shipped_studies().items():
        tables = load_tables(path)
        problem = PROBLEMS.load(tables.get("problem", "routing"))
        study = study_from(tables, problem, name=name, base=path.parent)
        found[name] = {
            "problem": problem.name,
            "about": tables.get("description", ""),
            "methods": list(dict.fromkeys(entry.method for entry in study.entries)),
            "runs": len(study.sources) * sum(len(e.seeds) * len(e.time_limits) for e in study.entries),
        }
    if as_json:
        click.echo(json.dumps(found, indent=1))
        return
    for name, study_ in found.items():
        say(f"{name} ({study_['problem']}): {study_['about']}")
        say(f"    {', '.join(study_['methods'])}")
        if study_["runs"]:
            say(f"    at most {study_['runs']} runs")
