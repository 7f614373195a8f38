"""`workbench place`: choose task locations of most information."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from instances.errors import InputError
from workbench.completing import PLACEMENT_METHOD
from workbench.options import (
    COLUMNS,
    COUNT,
    JSON,
    LENGTH_SCALE,
    METHOD_OPTION,
    NOISE_SD,
    POSITIVE,
    SECONDS,
    SEED,
    SIGNAL_SD,
    TESTS,
)
from workbench.terminal import say, say_lines

if TYPE_CHECKING:
    from formulations.task_location.variance_reduction import Goal
    from instances.environment.region import Region
    from workbench.commands.place_how_many import Asked


@click.command("place")
@click.argument(
    "region_file", metavar="[REGION.geojson | SCENARIO.toml]", required=False, type=click.Path(path_type=Path)
)
@click.option("--tasks", type=COUNT, default=40, show_default=True, help="How many tasks, n.")
@click.option(
    "--method",
    default="nlp",
    show_default=True,
    shell_complete=PLACEMENT_METHOD,
    help="nlp, l-bfgs-b, slsqp, greedy-swap, greedy, ...",
)
@METHOD_OPTION
@TESTS
@SIGNAL_SD
@LENGTH_SCALE
@NOISE_SD
@click.option("--test-noise-sd", type=POSITIVE, help="σ_o of a reading at a test point, criterion b.  [default: σ_n]")
@click.option(
    "--criterion",
    default="b",
    show_default=True,
    help="b both noisy, a latent tests, ig information gain, j weighted mean variance.",
)
@click.option("--weights", type=click.Path(path_type=Path), help="How much places count: GeoTIFF, polygons or CSV.")
@click.option("--prior-sd", type=click.Path(path_type=Path), help="A map of σ_f: GeoTIFF, polygons or CSV.")
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.option("--time-limit", type=SECONDS, help="Seconds of wall clock.  [default: none]")
@click.option("--certificate/--no-certificate", default=True, help="Also compute the upper bound.  [default: yes]")
@click.option("--study", metavar="n=A..B[:STEP]", help="How many tasks? Try every n from A to B.")
@click.option(
    "--sd-limit", type=POSITIVE, default=3.0, show_default=True, help="--study: a place with a larger sd is uncovered."
)
@click.option("--max-sd", type=POSITIVE, help="Fewest tasks that leave a posterior sd of at most this everywhere.")
@click.option("--polish", is_flag=True, help="Route the tasks of a scenario or mission file, and move its waypoints.")
@COLUMNS
@JSON
@click.option("--out", type=click.Path(path_type=Path), help="Write .geojson, .json or .csv; with --study a folder.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw a picture (.svg).")
def command(
    region_file: Path | None,
    tasks: int,
    method: str,
    options: tuple[str, ...],
    seed: int,
    time_limit: float | None,
    certificate: bool,
    study: str | None,
    sd_limit: float,
    max_sd: float | None,
    columns: list[str],
    as_json: bool,
    out: Path | None,
    plot: Path | None,
    weights: Path | None,
    prior_sd: Path | None,
    polish: bool,
    **setting: Any,
) -> None:
    """Choose task locations of most information in REGION, by default a 20 km square.

    REGION is GeoJSON, KML, KMZ, GeoPackage or a Shapefile, in degrees or metres; what is printed is in metres of the
    local plane at its centre, a GeoJSON written in degrees.

    \b
    Examples:
      workbench place --tasks 12 --plot tasks.svg
      workbench place area.geojson --tasks 40 --method nlp --out tasks.geojson
      workbench place area.geojson --criterion j --weights roads.geojson
      workbench place --study n=5..40:5 --out study
      workbench place --polish mission.toml --out waypoints.csv
    """
    if polish:
        _refuse_beside_polish()
        from workbench.commands.place_polish import run_polish

        run_polish(region_file, out, as_json)
        return
    from formulations.limits import Limits
    from formulations.task_location.placement_files import ENDINGS
    from formulations.task_location.registry import make_method
    from formulations.task_location.setting import goal_of, site_of
    from instances.value_maps import read_value_map
    from workbench.commands.place_how_many import Asked, run_fewest, run_study
    from workbench.settings import check_target, key_values

    if study is not None and max_sd is not None:
        raise InputError("place: --study and --max-sd answer different questions; give one of them")
    _refuse_unused(study is not None, max_sd is not None)
    if study is None:
        check_target(out, ENDINGS)
        check_target(plot, (".svg",))
    chosen = make_method(method, key_values(options, "--option"))
    site = site_of(region_file)
    region = site.region
    setting["weights"] = None if weights is None else read_value_map(weights, site, 1.0)
    setting["prior_sd"] = None if prior_sd is None else read_value_map(prior_sd, site, setting["signal_sd"])
    criterion = goal_of(region, **setting)
    limits = Limits(time=float("inf") if time_limit is None else time_limit)
    asked = Asked(seed, as_json, out, plot, site.plane, columns)
    if study is not None:
        run_study(region, criterion, study, method, chosen, sd_limit, asked)
    elif max_sd is not None:
        run_fewest(region, criterion, max_sd, asked)
    else:
        _place(region, criterion, tasks, method, chosen, limits, certificate, asked)


def _refuse_beside_polish() -> None:
    """InputError where a flag is typed whose answer stands in the file that is polished."""
    context = click.get_current_context()
    for name in set(context.params) - {"polish", "region_file", "out", "as_json"}:
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE:
            flag = {"options": "--option"}.get(name, f"--{name.replace('_', '-')}")
            raise InputError(f"{flag}: cannot be given with --polish, which takes its settings from the file")


def _refuse_unused(study: bool, fewest: bool) -> None:
    """InputError where a flag is typed that what is asked for would not look at."""
    only = {"sd_limit": "--sd-limit", "columns": "--columns"}
    unused = {name: f"{flag}: only says something with --study" for name, flag in only.items() if not study}
    if study or fewest:
        mode = "--study" if study else "--max-sd"
        searching = () if study else ("method", "options", "criterion", "weights")
        for name in ("tasks", "time_limit", "certificate", *searching):
            flag = "--option" if name == "options" else f"--{name.replace('_', '-')}"
            unused[name] = f"{flag}: cannot be given with {mode}, which does not use it"
    for name, sentence in unused.items():
        if click.get_current_context().get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE:
            raise InputError(sentence)


def _place(
    region: Region, criterion: Goal, tasks: int, name: str, method: Any, limits: Any, certified: bool, asked: Asked
) -> None:
    from formulations.task_location.certificate import certificate
    from formulations.task_location.criterion import Convention
    from formulations.task_location.placement import PlacementProblem, place
    from workbench.commands.place_how_many import write_and_draw

    problem = PlacementProblem(region, criterion, tasks)
    bound = certificate(criterion.under(Convention.BOTH_NOISY), region, tasks) if certified else None
    placement = place(
        problem,
        method,
        name,
        seed=asked.seed,
        limits=limits,
        certificate=None if bound is None else bound.bound,
        observe=lambda elapsed, value, _: say(f"{elapsed:8.2f} s  {value:.4f} nats", err=True),
    )
    write_and_draw(problem, placement, asked)
    if asked.as_json:
        kind = None if bound is None else bound.kind
        plane = {} if asked.plane is None else {"origin": [asked.plane.latitude, asked.plane.longitude]}
        click.echo(json.dumps({**placement.as_dict(), "certificate_kind": kind, **plane}))
    else:
        worth = ", ".join(f"({name}) {value:.4f}" for name, value in placement.information.items())
        say_lines(f"{placement.summary()}\ninformation [nats]: {worth}")
