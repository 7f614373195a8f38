"""Publish: what is told and written about stored runs: for each problem in the stores a summary, a page and a CSV."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from instances.errors import InputError
from reports.stores import problems_in
from workbench.jobs.problem import Outputs, Published
from workbench.problems import PROBLEMS
from workbench.summary import print_summaries
from workbench.terminal import refuse_unknown_columns, say


def publish(folders: Sequence[Path], outputs: Outputs) -> Published:
    """Summarise every run below `folders` and write what is asked for about them; nothing is run.

    Where the stores hold runs of several problems, the first has the names asked for, and ``-<problem>`` is added to
    those of the others. InputError for an output that no problem there has, and where a folder does not exist.
    """
    found = problems_in(*folders) or list(PROBLEMS.built_in)[:1]
    problems = [PROBLEMS.load(name) for name in found]
    for flag in outputs.extra:
        if not any(flag in problem.outputs for problem in problems):
            raise InputError(
                f"--{flag}: a store of {' and '.join(found)} runs alone has only --out, --csv and --figures"
            )
    published = [
        problem.publish(list(folders), outputs.of(problem.outputs, "" if problem is problems[0] else problem.name))
        for problem in problems
    ]
    return Published(
        [path for each in published for path in each.written],
        [sentence for each in published for sentence in each.problems],
        sum(each.damaged for each in published),
        any(each.regressed for each in published),
        all(each.comparable for each in published),
        [summary for each in published for summary in each.summaries],
        [sentence for each in published for sentence in each.notes],
    )


def told(published: Published) -> dict[str, Any]:
    """Return what was published as JSON values: tables by name, files written, notes and problems."""
    return {
        "tables": {summary.name: summary.rows() for summary in published.summaries},
        "written": [str(path) for path in published.written],
        "notes": published.notes,
        "problems": published.problems,
    }


def tell(published: Published, names: Sequence[str] = ()) -> None:
    """Print what was published for people, with the columns `names` where any are asked for."""
    print_summaries(published.summaries, names)
    for sentence in published.notes:
        say(sentence)


def refuse_columns(problems: Sequence[str], names: Sequence[str]) -> None:
    """Raise InputError for the first of `names` that no summary of these problems has, before any work."""
    if names:
        found = [PROBLEMS.load(name).columns() for name in problems]
        refuse_unknown_columns(names, list(dict.fromkeys(column.key for each in found for column in each)))
