"""`workbench solve`: solve one instance in a killable process of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.completing import SOLVER
from workbench.options import ITERATIONS, SECONDS, SEED, THREADS

if TYPE_CHECKING:
    from reports.record import Run


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
@click.option("--start", type=click.Path(path_type=Path), help="Routes (.sol) to begin from.")
@click.option("--fewest", is_flag=True, help="How many UAVs does a makespan of --limit take? With proof.")
@click.option("--limit", type=SECONDS, help="The makespan [s] for --fewest.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
@click.option("--out", type=click.Path(path_type=Path), help="Write the routes (.sol).")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the routes (.svg).")
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
    as_json: bool,
    out: Path | None,
    plot: Path | None,
) -> None:
    """Solve INSTANCE. Exit code 1 where that ends without routes, by a crash or by a kill.

    With --fewest: find the fewest UAVs that fly all tasks within --limit, and which.
    """
    from instances.errors import InputError
    from instances.files import read_instance, read_routes, write_routes
    from instances.paths import paths_file, read_paths
    from workbench.jobs.job import Job, folder_of
    from workbench.jobs.runner import run
    from workbench.jobs.study import checked_entry
    from workbench.problems.routing import ROUTING
    from workbench.settings import check_target, key_values
    from workbench.tours import said_of, tours_beside

    if fewest == (limit is None) or (fewest and (start or plot)):
        raise InputError("--fewest needs --limit, --limit goes with --fewest alone, and --start and --plot do not")
    chosen = key_values(options, "--option")
    limits = {"time_limits": (time_limit,), "threads": threads, "iterations": iterations}
    entry = checked_entry(ROUTING, solver, chosen, seeds=(seed,), **limits)
    instance = read_instance(instance_file)
    begin = read_routes(start, instance) if start else None
    for path, endings in ((out, (".sol",)), (plot, (".svg",))):
        check_target(path, endings)
    if limit is not None:
        from formulations.limits import Limits
        from workbench.commands.solve_fewest import run_fewest

        within, method = Limits(time_limit, threads, iterations), (solver, entry.options)
        found = run_fewest(instance, limit, method, within, seed, as_json=as_json, out=out)
        context.exit(0 if found else 1)
    beside = paths_file(instance_file)
    paths = read_paths(beside, instance) if plot and beside.exists() else None
    job = Job(folder_of(instance), solver, entry.options, seed, time_limit, threads, iterations)
    result = run(ROUTING, job, instance, start=begin, observe=_tell)
    routes = result.own["routes"]
    if out and routes is not None:
        write_routes(routes, instance, out)
    if plot and routes is not None:
        from reports.figures.routes import draw_routes  # here: matplotlib takes its time
        from reports.figures.svg import save_figure

        save_figure(draw_routes(instance, routes, paths), plot)
    click.echo(json.dumps(_object(result)) if as_json else _text(result))
    if routes is not None and not as_json:
        for tour in filter(lambda tour: tour.tasks, tours_beside(instance_file, instance, routes)):
            click.echo(said_of(tour))
    context.exit(0 if routes is not None and result.status in ("OPTIMAL", "FEASIBLE") else 1)


def _tell(elapsed: float, objective: float | None, bound: float | None) -> None:
    told, low = ("-" if value is None else f"{value:.6g} s" for value in (objective, bound))
    click.echo(f"{elapsed:8.2f} s  longest tour {told}  bound {low}", err=True)


def _object(run: Run) -> dict[str, object]:
    named = ("solver", "status", "objective", "bound", "gap", "elapsed", "routes", "stopped_by", "message", "trace")
    more = ("options", "seed", "time_limit", "threads", "tolerance", "tour_costs", "statistics", "cpu_seconds")
    rest = ("prepare_elapsed", "peak_memory", "code", "revision", "log")
    flat = run.flat()
    return {"instance": run.instance["name"], "digest": run.instance["digest"]} | {
        name: flat[name] for name in (*named, *more, *rest)
    }


def _text(run: Run) -> str:
    value = "no routes" if run.objective is None else f"longest tour {run.objective:.6g} s"
    bound = "" if run.bound is None or run.gap is None else f", bound {run.bound:.6g} s (gap {run.gap:.2%})"
    lines = [f"{run.status}: {value}{bound}, {run.elapsed:.2f} s, stopped by {run.stopped_by or 'nothing'}"]
    lines += [run.message] if run.message else []
    costs = zip(run.own["routes"] or (), run.own["tour_costs"] or (), strict=False)
    lines += [
        f"UAV {k}: {cost:.6g} s, tasks {' '.join(map(str, route)) or '-'}" for k, (route, cost) in enumerate(costs)
    ]
    return "\n".join(lines)
