"""`workbench bound`: lower bounds on the longest tour, each with its time and its gap to the best routes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.options import JSON, SECONDS, SEED
from workbench.terminal import TextTable, print_table, say

if TYPE_CHECKING:
    from formulations.routing.bounds import Bound
    from instances import Instance


@click.command("bound")
@click.argument("instance_file", metavar="INSTANCE", type=click.Path(path_type=Path))
@click.option("--routes", type=click.Path(path_type=Path), help="Routes (.sol) to measure the gaps from.")
@JSON
@click.option(
    "--time-limit", type=SECONDS, default=60.0, show_default=True, help="Seconds of wall clock for each bound."
)
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.pass_context
def command(
    context: click.Context, instance_file: Path, routes: Path | None, as_json: bool, time_limit: float, seed: int
) -> None:
    """Print lower bounds of INSTANCE: no routes have a shorter longest tour.

    Gaps are to the ROUTES given, else to the best value known of this instance, else to those of a short search. Where
    that finds no routes (UAVs may not be able to fly all tasks) there are no gaps. Exit code 1 where a bound
    contradicts that value.

    \b
    Examples:
      workbench bound a.json
      workbench bound a.json --routes a.sol --time-limit 10 --json
    """
    from formulations.limits import Limits
    from formulations.routing.bounds import lower_bounds
    from instances.files import read_instance

    limits = Limits(time=time_limit)  # refuses nonsense before anything is read
    instance = read_instance(instance_file)
    best, source, slack = _best(instance, routes, seed)
    found = []
    for bound in lower_bounds(instance, time_limit=limits.time, seed=seed):
        found.append(bound)
        say(f"{bound.name}: {bound.value:.6g} s", err=True)
    highest = max((bound.value for bound in found), default=0.0)
    described = [_described(bound, best) for bound in found]
    if as_json:
        report = {"instance": instance.name, "digest": instance.digest, "best": best, "best_from": source}
        click.echo(json.dumps(report | {"bound": highest, "gap": _gap(highest, best), "bounds": described}))
    else:
        _print(instance, best, source, found)
    contradicted = best is not None and highest > best + slack
    if contradicted:
        say(f"{instance.name}: a bound of {highest!r} s contradicts {best!r} s ({source})", err=True)
    context.exit(1 if contradicted else 0)


def _best(instance: Instance, routes: Path | None, seed: int) -> tuple[float | None, str, float]:
    """Return the cost to measure from [s], where it comes from, and what it may have been rounded down by [s]."""
    from formulations.limits import Limits
    from formulations.routing.registry import make_solver
    from formulations.routing.solver import refusal
    from instances import makespan
    from instances.best_known import best_known
    from instances.files import read_routes

    if routes is not None:
        return makespan(instance, read_routes(routes, instance)), str(routes), 0.0
    known = best_known(instance.digest)
    if known is not None:
        return known.best_known, f"best known, {known.source}", 5e-4 + 1e-6 * known.best_known
    search = make_solver("memetic")
    if reason := refusal(search, instance):
        return None, f"memetic: {reason}", 0.0
    search.prepare(instance)
    found = search.solve(instance, limits=Limits(time=SEARCH), seed=seed)
    return found.objective, f"a search of {SEARCH:g} s", 0.0


SEARCH = 5.0
"""Seconds of search where no routes are given or known."""


def _gap(bound: float, best: float | None) -> float | None:
    if best is None:
        return None
    return (best - bound) / best if best > 0 else 0.0


def _described(bound: Bound, best: float | None) -> dict[str, object]:
    about = {"name": bound.name, "bound": bound.value, "gap": _gap(bound.value, best)}
    return about | {"elapsed": bound.elapsed, "message": bound.message}


def _print(instance: Instance, best: float | None, source: str, found: list[Bound]) -> None:
    say(instance.summary())
    say(f"{'no routes known' if best is None else f'best routes {best:.6g} s'} ({source})")
    rows = []
    for bound in found:
        share = _gap(bound.value, best)
        gap = "–" if share is None else f"{100 * share:.2f}"
        rows.append([bound.name, f"{bound.value:.6g}", gap, f"{bound.elapsed:.2f}"])
    print_table(TextTable(["name", "bound", "gap", "elapsed"], ["Bound", "Value [s]", "Gap [%]", "Time [s]"], rows))
    for bound in found:
        if bound.message:
            say(f"{bound.name}: {bound.message}")
