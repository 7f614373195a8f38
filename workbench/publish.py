"""Publish: what is written about stored runs: for each problem found in the stores a summary, a page and a CSV."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from instances.errors import InputError
from reports.stores import problems_in
from workbench.jobs.problem import Outputs, Published
from workbench.problems import PROBLEMS


def publish(folders: Sequence[Path], outputs: Outputs) -> Published:
    """Print and write what is asked for about every run below `folders`; nothing is run.

    Where the stores hold runs of several problems, the first has the names asked for, and ``-<problem>`` is added to
    those of the others. InputError for an output that no problem there has, and where a folder does not exist.
    """
    found = problems_in(*folders) or list(PROBLEMS.built_in)[:1]
    problems = [PROBLEMS.load(name) for name in found]
    for flag in outputs.extra:
        if not any(flag in problem.outputs for problem in problems):
            raise InputError(f"--{flag}: a store of {' and '.join(found)} runs alone has only --out and --csv")
    published = [
        problem.publish(list(folders), outputs.of(problem.outputs, "" if problem is problems[0] else problem.name))
        for problem in problems
    ]
    return Published(
        [path for each in published for path in each.written],
        [sentence for each in published for sentence in each.problems],
        sum(each.damaged for each in published),
        any(each.regressed for each in published),
    )
