"""`workbench costs`: moving costs of a scenario in wind."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from workbench.completing import COST_METHOD
from workbench.options import JSON, METHOD_OPTION
from workbench.terminal import print_json, say

if TYPE_CHECKING:
    from instances.scenario import Scenario
    from workbench.jobs.problem import Published, Source


@click.command("costs")
@click.argument("scenario_file", metavar="SCENARIO.toml", type=click.Path(path_type=Path))
@click.option(
    "--method",
    default="refined",
    show_default=True,
    shell_complete=COST_METHOD,
    help="refined, closed-form, fmt-star or dijkstra.",
)
@METHOD_OPTION
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Instance file (.json, .json.gz, .atsp).")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw wind, tasks and the paths from one start (.svg).")
@click.option("--report", type=click.Path(path_type=Path), help="Compare all methods here; write a page (.html).")
@JSON
def command(
    scenario_file: Path,
    method: str,
    options: tuple[str, ...],
    out: Path,
    plot: Path | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Compute the moving cost and path between every pair of nodes of SCENARIO.toml.

    The scenario says cost = "energy" (the paper's, the default, with a ground_speed [m/s] such as 20.0) or cost =
    "time" (flight time, with an airspeed [m/s]).

    Writes the instance, and the paths beside it (NAME.paths.json.gz); prints how much the wind matters.

    Where [[uav]] has a turning_radius, legs are Dubins paths between headings, in calm air or, with cost = "time", a
    uniform wind; --option uniform=16, sights=0, tangents=0 (headings a node) and depots=own or closed. No path method
    is used, and no paths are written.

    \b
    Examples:
      workbench costs scenario.toml --out a.json
      workbench costs scenario.toml --method dijkstra --out b.json
    """
    from formulations.moving_cost.effect import WindEffect
    from formulations.moving_cost.fleet import classes_of
    from formulations.moving_cost.registry import make_method
    from instances.errors import InputError, naming
    from instances.files import endings
    from instances.paths import paths_file
    from instances.scenario import read_scenario
    from workbench.planning import CONFIRMED, plan, write_plan
    from workbench.publish import tell, told
    from workbench.settings import check_target, key_values

    chosen = key_values(options, "--option")
    for path, known in ((out, endings(written=True)), (plot, (".svg",)), (report, (".html",))):
        check_target(path, known)
    scenario = read_scenario(scenario_file)
    if scenario.fleet.turning_radii is not None:
        from workbench.turning import write_turning_costs  # here: others need none of it

        if plot or report:
            raise InputError("--plot and --report show planned paths; legs between headings have none")
        write_turning_costs(scenario, chosen, scenario_file, out, as_json)
        return
    make_method(method, chosen)
    began = time.perf_counter()
    with naming(scenario_file):
        instance, paths = plan(scenario, method, chosen, _tell)
    elapsed = time.perf_counter() - began
    write_plan(instance, paths, out, scenario_file)
    if plot:
        from reports.figures.paths import draw_paths  # here: matplotlib takes its time
        from reports.figures.svg import save_figure

        save_figure(draw_paths(scenario, paths).figure, plot)
    effect = WindEffect(**instance.provenance["wind_effect"]).summary(scenario.cost)
    compared = _compare(scenario, report) if report else None
    speeds, _ = classes_of(scenario)
    count = paths.n_nodes * (paths.n_nodes - 1) * len(speeds)
    if as_json:
        about = {"instance": instance.name, "digest": instance.digest, "file": out, "paths_file": paths_file(out)}
        about |= {"method": method, "cost": scenario.cost, "paths": count, "elapsed": elapsed}
        about |= {"wind_effect": instance.provenance["wind_effect"]}
        print_json(about | ({"report": told(compared)} if compared else {}))
        return
    if compared:
        tell(compared)
    say(f"{instance.summary()}; {count} paths by {method} in {elapsed:.1f} s, {CONFIRMED}")
    for speed in speeds:
        say(f"cost: {scenario.cost.described(speed)}")
    say(effect)


def _compare(scenario: Scenario, page: Path) -> Published:
    """Run the shipped studies of moving costs on this scenario alone, write their page and return what it says."""
    from tempfile import TemporaryDirectory

    from workbench.jobs.backlog import Backlog
    from workbench.jobs.execute import jobs_of, run_locally
    from workbench.jobs.problem import Outputs
    from workbench.jobs.progress import StudyProgress
    from workbench.jobs.store import Store
    from workbench.jobs.study import load_tables, shipped_studies, study_from
    from workbench.problems.moving_cost import MOVING_COST, MovingCostItem

    most = len(scenario.points)
    starts: dict[str, list[int] | list[None]] = {
        "moving-cost": [None],
        "moving-cost-scaling": sorted({2, max(2, most // 4), max(2, most // 2), most}),
    }
    with TemporaryDirectory() as folder:
        store = Store(folder)
        for name, counts in starts.items():
            tables = load_tables(shipped_studies()[name])
            study = study_from(tables, MOVING_COST, name=scenario.name, base=Path())
            study = replace(study, sources=tuple(MovingCostItem(scenario, count) for count in counts))
            sources: dict[str, Source[Any]] = {}
            jobs = jobs_of(study, keep=sources.setdefault)
            store.keep_items(MOVING_COST, sources)
            with StudyProgress(jobs, 1, MOVING_COST.spell) as progress, Backlog(jobs, store) as backlog:
                run_locally(backlog, MOVING_COST, 1, progress)
        store.put_study({"name": scenario.name}, [])
        return MOVING_COST.publish([store.root], Outputs(page))


def _tell(fraction: float, words: str) -> None:
    say(f"{fraction:4.0%}  {words}", err=True)
