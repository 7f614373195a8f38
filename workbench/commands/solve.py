"""`workbench solve`: solve one instance in a killable process of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.completing import SOLVER
from workbench.options import ITERATIONS, JSON, SECONDS, SEED, THREADS
from workbench.terminal import say, say_lines

if TYPE_CHECKING:
    from instances import Instance, Routes
    from workbench.jobs.job import Job


@click.command("solve")
@click.argument("instance_file", metavar="INSTANCE", type=click.Path(path_type=Path))
@click.option(
    "--solver", default="exact", show_default=True, shell_complete=SOLVER, help="Name (workbench solvers lists them)."
)
@click.option("--time-limit", type=SECONDS, default=60.0, show_default=True, help="Seconds of wall clock.")
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.option("--threads", type=THREADS, default=1, show_default=True, help="Worker threads of the solver.")
@click.option("--iterations", type=ITERATIONS, help="Limit on the method's own iterations.")
@click.option("--option", "options", multiple=True, metavar="KEY=VALUE", help="An option of the solver; repeatable.")
@click.option("--start", type=click.Path(path_type=Path), help="Routes (.sol, .tour) to begin from.")
@click.option("--fewest", is_flag=True, help="How many UAVs does a makespan of --limit take? With proof.")
@click.option("--limit", type=SECONDS, help="The makespan [s] for --fewest.")
@click.option("--what-if", is_flag=True, help="Also solve with one more UAV or battery: what is each worth?")
@click.option(
    "--risk",
    type=click.Choice(["mean", "cvar", "worst"]),
    help="Search on from the best of five seeds for routes that are best over the members of an ensemble of forecasts.",
)
@JSON
@click.option("--out", type=click.Path(path_type=Path), help="Write the routes (.sol, .tour).")
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    help="Draw the routes (.svg): along the paths behind its costs, over wind and no-fly zones, where these are known.",
)
@click.pass_context
def command(
    context: click.Context,
    instance_file: Path,
    solver: str,
    time_limit: float,
    seed: int,
    threads: int,
    iterations: int | None,
    options: tuple[str, ...],
    start: Path | None,
    fewest: bool,
    limit: float | None,
    what_if: bool,
    risk: str | None,
    as_json: bool,
    out: Path | None,
    plot: Path | None,
) -> None:
    """Solve INSTANCE. Exit code 1 where that ends without routes, by a crash or by a kill.

    With --fewest: find the fewest UAVs that fly all tasks within --limit, and which. With --what-if: solve also with
    one more UAV at each depot and one more battery (twice the endurance) for each UAV, and tell what that is worth.

    UAVs are numbered from 0, as their depots are, on the screen and in files; the format .sol, which is of others,
    numbers routes from 1: its Route #1 is flown by UAV 0.

    \b
    Examples:
      workbench solve a.json --time-limit 30 --out a.sol --plot a.svg
      workbench solve a.json --solver ga --option population=100 --json
      workbench solve a.json --fewest --limit 3600
    """
    from instances.errors import InputError
    from instances.files import ROUTES, read_instance, read_routes
    from workbench.jobs.job import Job, folder_of
    from workbench.jobs.study import checked_entry
    from workbench.problems.routing import ROUTING
    from workbench.settings import check_target, key_values

    _refuse_mixed(fewest=fewest, limit=limit, what_if=what_if, pictured=bool(start or plot), written=out is not None)
    if risk is not None and (fewest or what_if or start or plot):
        raise InputError("--risk goes without --fewest, --what-if, --start and --plot")
    chosen = key_values(options, "--option")
    limits = {"time_limits": (time_limit,), "threads": threads, "iterations": iterations}
    entry = checked_entry(ROUTING, solver, chosen, seeds=(seed,), **limits)
    instance = read_instance(instance_file)
    begin = read_routes(start, instance) if start else None
    for path, endings in ((out, ROUTES), (plot, (".svg",))):
        check_target(path, endings)
    job = Job(folder_of(instance), solver, entry.options, seed, time_limit, threads, iterations)
    if limit is not None:
        from workbench.commands.solve_fewest import run_fewest

        found = run_fewest(instance, limit, job, as_json=as_json, out=out)
    elif what_if:
        from workbench.commands.solve_what_if import run_what_if

        found = run_what_if(instance, job, as_json=as_json)
    elif risk is not None:
        from workbench.commands.solve_risk import run_by_risk

        found = run_by_risk(instance, job, risk, as_json=as_json, out=out, beside=instance_file)
    else:
        found = _solve(instance, job, begin, as_json=as_json, out=out, plot=plot, beside=instance_file)
    context.exit(0 if found else 1)


def _refuse_mixed(*, fewest: bool, limit: float | None, what_if: bool, pictured: bool, written: bool) -> None:
    """Raise InputError for flags that do not go together."""
    from instances.errors import InputError

    if fewest == (limit is None) or (fewest and pictured):
        raise InputError("--fewest needs --limit, --limit goes with --fewest alone, and --start and --plot do not")
    if what_if and (fewest or pictured or written):
        raise InputError("--what-if goes without --fewest, --start, --plot and --out")


def _solve(
    instance: Instance,
    job: Job,
    begin: Routes | None,
    *,
    as_json: bool,
    out: Path | None,
    plot: Path | None,
    beside: Path,
) -> bool:
    """Run the job, print and write what was asked for, and return whether it ended with routes."""
    from instances.files import write_routes
    from workbench.commands.solve_told import as_object, as_text
    from workbench.jobs.runner import run
    from workbench.problems.routing import ROUTING
    from workbench.tours import planned_beside, said_of

    planned = planned_beside(beside, instance)
    result = run(ROUTING, job, instance, start=begin, observe=_tell)
    routes = result.own["routes"]
    if out and routes is not None:
        write_routes(routes, instance, out)
    if plot and routes is not None:
        from reports.figures.routes import draw_routes  # here: matplotlib takes its time
        from reports.figures.svg import save_figure

        save_figure(draw_routes(instance, routes, *planned), plot)
    spread = planned.spread(instance, routes) if routes is not None else None
    if as_json:
        click.echo(json.dumps(as_object(result, instance) | ({"ensemble": spread.to_json()} if spread else {})))
    else:
        flown = planned.tours(instance, routes) if routes is not None else []
        lines = [as_text(result, instance), *(said_of(tour) for tour in flown if tour.tasks)]
        say_lines("\n".join([*lines, *([spread.words] if spread else [])]))
    return routes is not None and result.status in ("OPTIMAL", "FEASIBLE")


def _tell(elapsed: float, objective: float | None, bound: float | None) -> None:
    told, low = ("-" if value is None else f"{value:.6g} s" for value in (objective, bound))
    say(f"{elapsed:8.2f} s  longest tour {told}  bound {low}", err=True)
