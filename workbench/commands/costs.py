"""`workbench costs`: moving costs of a scenario in wind."""

from __future__ import annotations

import time
from pathlib import Path

import click


@click.command("costs")
@click.argument("scenario_file", metavar="SCENARIO.toml", type=click.Path(path_type=Path))
@click.option("--method", default="refined", show_default=True, help="refined, fmt-star or dijkstra.")
@click.option("--option", "options", multiple=True, metavar="KEY=VALUE", help="An option of the method; repeatable.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Instance file (.json, .json.gz, .atsp).")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw wind, tasks and the paths from one start (.svg).")
@click.option("--report", type=click.Path(path_type=Path), help="Compare all methods here; write a page (.html).")
def command(
    scenario_file: Path, method: str, options: tuple[str, ...], out: Path, plot: Path | None, report: Path | None
) -> None:
    """Compute the moving cost and path between every pair of nodes of SCENARIO.toml.

    Writes the instance, and the paths beside it (NAME.paths.json.gz); prints how much the wind matters.
    """
    from formulations.moving_cost.effect import WindEffect
    from formulations.moving_cost.registry import make_method
    from instances.errors import InputError
    from instances.files import WRITERS
    from instances.scenario import read_scenario
    from workbench.planning import plan, write_plan
    from workbench.settings import key_values

    chosen = key_values(options, "--option")
    make_method(method, chosen)
    if not out.name.endswith(tuple(WRITERS)):
        raise InputError(f"{out}: must end in {', '.join(WRITERS)}")
    for path in (out, plot, report):
        if path is not None and not path.parent.is_dir():
            raise InputError(f"{path}: there is no folder {path.parent}")
    scenario = read_scenario(scenario_file)
    began = time.perf_counter()
    instance, paths = plan(scenario, method, chosen, _tell)
    elapsed = time.perf_counter() - began
    write_plan(instance, paths, out, scenario_file)
    if plot:
        from reports.figures.paths import save_paths  # here: matplotlib takes its time

        save_paths(scenario, paths, plot)
    effect = WindEffect(**instance.provenance["wind_effect"]).summary()
    if report:
        from formulations.moving_cost.costing import query_of
        from reports.moving_cost_page import write_moving_cost_page
        from workbench.costs_study import compare_methods, measure_claim

        query = query_of(scenario)
        methods, claim = compare_methods(query, _tell), measure_claim(query, _tell)
        write_moving_cost_page(scenario, paths, methods, claim, effect, report)
    n = paths.n_nodes
    click.echo(f"{instance.summary()}; {n * (n - 1)} paths by {method} in {elapsed:.1f} s, all confirmed")
    click.echo(effect)


def _tell(fraction: float, words: str) -> None:
    click.echo(f"{fraction:4.0%}  {words}", err=True)
