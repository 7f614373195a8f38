"""`workbench check`: verify routes, every run of a store, or a mission's products, independently."""

from __future__ import annotations

from pathlib import Path

import click

from instances.errors import InputError
from workbench.options import JSON
from workbench.terminal import print_json, say


@click.command("check")
@click.argument("target", metavar="INSTANCE|RUNS-DIR|NAME.paths.json.gz", type=click.Path(path_type=Path))
@click.argument(
    "routes_file",
    metavar="[ROUTES.sol|SELECTION.json|CERTIFICATE|SCENARIO.toml]",
    required=False,
    type=click.Path(path_type=Path),
)
@JSON
@click.pass_context
def command(context: click.Context, target: Path, routes_file: Path | None, as_json: bool) -> None:
    """Verify the routes of INSTANCE, or every run stored in RUNS-DIR. Exit code 1 where a problem is found.

    The folder of a mission may stand for RUNS-DIR: its products are to be as its stages wrote them, each made from the
    ones that are there, and its routes to cost what they say.

    A ROUTES file that does not visit every task once is unusable input: one sentence, exit code 2.

    A SELECTION (workbench select --out) is made out from scratch: tasks, classes, endurance, prizes or information.

    A CERTIFICATE (workbench certify) is gone through case by case: tours are listed and bounds computed anew.

    Planned paths (NAME.paths.json.gz) are flown again in their scenario: length, wind, collisions.

    \b
    Examples:
      workbench check a.json a.sol
      workbench check runs/quick
      workbench check runs/mission
      workbench check a.json a-selection.json --json
      workbench check a.json a.certificate.json.gz
    """
    if target.is_dir():
        if routes_file is not None:
            raise InputError(f"{target}: is a folder of runs; routes are checked against an instance file")
        looked_at, problems = _check_folder(target)
    elif target.name.endswith(".paths.json.gz"):
        from workbench.planning import check_plan

        looked_at, problems = check_plan(target, routes_file)
    else:
        if routes_file is None:
            raise InputError(f"{target}: give the routes to check as well (ROUTES.sol), or a folder of runs")
        kinds = {".json": _check_selection, ".gz": _check_certificate}
        check_file = kinds.get(routes_file.suffix, _check_routes)
        looked_at, problems = check_file(target, routes_file)
    if as_json:
        print_json({"target": target, "looked_at": looked_at, "problems": problems})
    else:
        for problem in problems:
            say(problem)
        say(f"{looked_at}: " + (f"{len(problems)} problem(s) found" if problems else "all right"))
    context.exit(1 if problems else 0)


def _check_routes(instance_file: Path, routes_file: Path) -> tuple[str, list[str]]:
    from instances import makespan
    from instances.files import read_claim, read_instance
    from workbench.problems.routing import refute_cost

    instance = read_instance(instance_file)
    routes, claimed = read_claim(routes_file, instance)
    actual = makespan(instance, routes)
    wrong = "" if claimed is None else refute_cost(claimed, actual)
    return f"feasible, longest tour {actual!r} s", [f"{routes_file}: {wrong}"] if wrong else []


def _check_selection(instance_file: Path, selection_file: Path) -> tuple[str, list[str]]:
    from formulations.selection.selection_files import check_selection
    from instances.files import read_instance

    return check_selection(selection_file, read_instance(instance_file))


def _check_certificate(instance_file: Path, certificate_file: Path) -> tuple[str, list[str]]:
    from instances.certificate import read_certificate, verify
    from instances.errors import naming
    from instances.files import read_instance

    instance, certificate = read_instance(instance_file), read_certificate(certificate_file)
    with naming(certificate_file):
        verdict = verify(instance, certificate)
    looked_at = f"no longest tour of at most {certificate.bound!r} s: {verdict.closed} cases closed"
    return looked_at, [f"{certificate_file}: {problem}" for problem in verdict.problems]


def _check_folder(folder: Path) -> tuple[str, list[str]]:
    from workbench.mission.check import check_products, is_mission

    return check_products(folder) if is_mission(folder) else _check_store(folder)


def _check_store(folder: Path) -> tuple[str, list[str]]:
    """Judge every stored run of every problem again; how many are stale is said, and is no problem."""
    from reports.stores import problems_in
    from workbench.jobs.census import census
    from workbench.problems import PROBLEMS

    found = [PROBLEMS.load(name).check(folder) for name in problems_in(folder) or ["routing"]]
    counts = census(folder)
    told = {"stale: made by other code": counts.stale, "foreign: imported, their times as claimed": counts.foreign}
    looked_at = [words for words, _ in found] + [f"{count} of them {what}" for what, count in told.items() if count]
    return ", ".join(looked_at), [sentence for _, problems in found for sentence in problems]
