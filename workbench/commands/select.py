"""`workbench select`: the tasks worth flying within endurance, with an upper bound."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from instances.errors import InputError, shown
from workbench.completing import SELECTION_METHOD
from workbench.options import (
    ITERATIONS,
    JSON,
    LENGTH_SCALE,
    METHOD_OPTION,
    NOISE_SD,
    SECONDS,
    SEED,
    SIGNAL_SD,
    TESTS,
)
from workbench.terminal import say, say_lines

if TYPE_CHECKING:
    from formulations.selection.selection import Selection
    from formulations.selection.worth import Worth
    from instances import Instance
    from instances.arrays import Floats

EXAMPLES = """
Examples:

\b
  a team-orienteering file, its prizes and its tmax; a CSV of task, prize;
  what tasks tell of a field; and a check from scratch:
  workbench select p1.2.b.txt
  workbench select a.json --endurance 1200 --prizes p.csv
  workbench select a.json --endurance 1200,1500 --information --out s.json
  workbench check a.json s.json
"""


@click.command("select", epilog=EXAMPLES)
@click.argument("instance_file", metavar="INSTANCE", type=click.Path(path_type=Path))
@click.option("--endurance", metavar="L[,L...]", help="[s], for all UAVs or each.  [default: the instance's]")
@click.option("--prizes", type=click.Path(path_type=Path), help="CSV: task, prize.  [default: the instance's]")
@click.option("--information", is_flag=True, help="What the tasks tell of the field, in nats, instead of prizes.")
@click.option(
    "--method",
    default="exact",
    show_default=True,
    shell_complete=SELECTION_METHOD,
    help="exact, subset-dp, branch-and-price, ruin-recreate.",
)
@METHOD_OPTION
@click.option("--criterion", default="ig", show_default=True, help="ig information gain, b both noisy, a latent tests.")
@SIGNAL_SD
@LENGTH_SCALE
@NOISE_SD
@click.option("--region", type=click.Path(path_type=Path), help="Of the tests, a and b.  [default: a 20 km square]")
@TESTS
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.option("--time-limit", type=SECONDS, default=60.0, show_default=True, help="Seconds of wall clock.")
@click.option("--iterations", type=ITERATIONS, help="Limit on the method's own iterations.")
@JSON
@click.option("--out", type=click.Path(path_type=Path), help="Write the selection (.json).")
def command(
    instance_file: Path,
    endurance: str | None,
    prizes: Path | None,
    information: bool,
    method: str,
    options: tuple[str, ...],
    seed: int,
    time_limit: float,
    iterations: int | None,
    as_json: bool,
    out: Path | None,
    **setting: Any,
) -> None:
    """Choose the tasks of INSTANCE that fit within the UAVs' endurance and are worth most, and route them.

    Worth is the sum of prizes (team orienteering) or, with --information, what readings at the tasks tell. Every answer
    has an upper bound that no selection exceeds. Under criteria b and a more tasks always tell more, but what a task
    adds may grow with what is there: only what holds is claimed.
    """
    from formulations.limits import Limits
    from formulations.selection.registry import make_method
    from formulations.selection.selection import SelectionProblem, select
    from formulations.selection.selection_files import limited, write_selection
    from instances.files import read_instance
    from workbench.settings import check_target, key_values

    if prizes is not None and information:
        raise InputError("select: --prizes and --information answer different questions; give one of them")
    _refuse_unused(information)
    check_target(out, (".json",))
    chosen = make_method(method, key_values(options, "--option"))
    instance = read_instance(instance_file)
    if endurance is not None:
        instance = limited(instance, _endurance(endurance, instance.n_depots))
    worth = _information(instance, instance_file, setting) if information else _prizes(instance, instance_file, prizes)
    problem = SelectionProblem(instance, worth)
    limits = Limits(time=time_limit, iterations=iterations)
    selection = select(problem, chosen, method, seed=seed, limits=limits, observe=_tell)
    if out is not None:
        write_selection(selection, out)
    if as_json:
        click.echo(json.dumps(selection.as_dict()))
    else:
        say_lines(_text(selection))


def _refuse_unused(information: bool) -> None:
    """InputError where a flag is typed that only says something with --information."""
    for name in () if information else ("criterion", "signal_sd", "length_scale", "noise_sd", "region", "tests"):
        if click.get_current_context().get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE:
            raise InputError(f"--{name.replace('_', '-')}: only says something with --information")


def _endurance(text: str, n_uavs: int) -> Floats:
    import numpy as np

    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, n_uavs) or not all(0 < number < math.inf for number in numbers):
        raise InputError(
            f"--endurance: must be one positive number or {n_uavs} of them, L,L,... [s], got {shown(text)}"
        )
    return np.broadcast_to(numbers, n_uavs).astype(float)


def _prizes(instance: Instance, path: Path, prizes: Path | None) -> Worth:
    from formulations.selection.selection_files import own_prizes, read_prizes
    from formulations.selection.worth import worth_of

    own = own_prizes(instance) if prizes is None else read_prizes(prizes, instance.n_tasks).tolist()
    if own is None:
        raise InputError(f"{path}: has no prizes; give --prizes FILE.csv, or --information")
    return worth_of({"prizes": own}, instance.n_tasks, instance.coordinates)


def _information(instance: Instance, path: Path, setting: dict[str, Any]) -> Worth:
    from formulations.selection.worth import Worth
    from formulations.task_location.setting import criterion_of, region_of

    if instance.coordinates is None:
        raise InputError(f"{path}: has no coordinates, so information cannot be told; give --prizes")
    region = region_of(setting.pop("region"))
    return Worth.of_information(criterion_of(region, **setting), instance.coordinates[: instance.n_tasks])


def _tell(elapsed: float, worth: float, bound: float) -> None:
    say(f"{elapsed:8.2f} s  worth {worth:.6g}  bound {bound:.6g}", err=True)


def _text(selection: Selection) -> str:
    lines = [selection.summary()]
    costs = selection.as_dict()["tour_costs"]
    limits = selection.problem.instance.limits
    for k, (route, cost) in enumerate(zip(selection.routes, costs, strict=True)):
        tasks = " ".join(map(str, route)) or "-"
        lines.append(f"UAV {k}: {cost:.6g} of {limits[k]:.6g} s, tasks {tasks}")
    lines.append(f"left out: {' '.join(map(str, selection.left_out)) or '-'}")
    return "\n".join(lines)
