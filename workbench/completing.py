"""Completing: what the shell offers for values of options and arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib import import_module

import click
from click.shell_completion import CompletionItem

Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def names(registry: str, *, listed: bool = False) -> Complete:
    """Return a completion by the names of a registry, ``module:NAME``; `listed` where several stand between commas."""

    def complete(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
        module, _, name = registry.partition(":")
        known: Iterable[str] = getattr(import_module(module), name).targets()
        return _offered(known, incomplete, listed=listed)

    return complete


def _offered(known: Iterable[str], incomplete: str, *, listed: bool) -> list[CompletionItem]:
    before, comma, last = incomplete.rpartition(",") if listed else ("", "", incomplete)
    return [CompletionItem(f"{before}{comma}{each}") for each in known if each.startswith(last)]


SOLVER = names("formulations.routing.registry:SOLVERS")
SOLVERS = names("formulations.routing.registry:SOLVERS", listed=True)
FAMILY = names("instances.families:FAMILIES")
PLACEMENT_METHOD = names("formulations.task_location.registry:METHODS")
SELECTION_METHOD = names("formulations.selection.registry:METHODS")
COST_METHOD = names("formulations.moving_cost.registry:METHODS")
SURVEY_PLANNER = names("formulations.surveying.registry:PLANNERS")


def _methods(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    kinds = (PLACEMENT_METHOD, COST_METHOD, SELECTION_METHOD, SURVEY_PLANNER)
    return [item for complete in kinds for item in complete(context, parameter, incomplete)]


METHODS: Complete = _methods


def _warm(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    from workbench.warming import FAMILIES

    groups = [CompletionItem(name) for name in ("costs", "select", "map", *FAMILIES) if name.startswith(incomplete)]
    return SOLVER(context, parameter, incomplete) + COST_METHOD(context, parameter, incomplete) + groups


WARM: Complete = _warm


def study_or_file(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Offer the shipped studies, and files, where none fits: bash forgets what stands before a file."""
    from workbench.jobs.study import shipped_studies

    studies = [CompletionItem(name) for name in shipped_studies() if name.startswith(incomplete)]
    return [CompletionItem(incomplete, type="file"), *studies]


def _stages(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    from workbench.mission.pipeline import NAMES

    return [CompletionItem(name) for name in NAMES if name.startswith(incomplete)]


STAGE: Complete = _stages


def columns(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Offer the columns of the table that the command prints, or of any problem's where it may print several."""
    from workbench.commands.place_how_many import COLUMNS
    from workbench.problems import PROBLEMS
    from workbench.terminal import ALL

    found = [problem.columns() for problem in map(PROBLEMS.load, PROBLEMS.targets())]
    summarised = dict.fromkeys(column.key for each in found for column in each)
    known = COLUMNS if context.info_name == "place" else summarised
    return _offered([*known, ALL], incomplete, listed=True)
