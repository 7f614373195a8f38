"""`workbench generate`: make instances of a family."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.completing import FAMILY
from workbench.options import COUNT, JSON, SEED
from workbench.terminal import print_json

if TYPE_CHECKING:
    from instances import Instance
    from instances.scenario import Scenario

FORECAST_CELLS = 40
"""Of the grid of a forecast, along the longer side of the region."""


@click.command("generate")
@click.argument("family", shell_complete=FAMILY)
@click.option("--tasks", type=COUNT, default=20, show_default=True, help="Number of tasks n.")
@click.option("--depots", "--uavs", type=COUNT, default=3, show_default=True, help="Number of UAVs m, a depot each.")
@click.option("--count", type=COUNT, default=1, show_default=True, help="How many instances, with consecutive seeds.")
@click.option("--seed", type=SEED, default=0, show_default=True, help="Seed of the first.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="A parameter of the family; repeatable.")
@click.option("--out", type=click.Path(path_type=Path), default=Path(), show_default="this folder", help="Folder.")
@click.option(
    "--forecast",
    type=click.FloatRange(min=1e-3),
    metavar="SECONDS",
    help="Write the scenario, too, in a folder with its changing wind as a forecast: a frame every so many seconds.",
)
@JSON
def command(
    family: str,
    tasks: int,
    depots: int,
    count: int,
    seed: int,
    settings: tuple[str, ...],
    out: Path,
    forecast: float | None,
    as_json: bool,
) -> None:
    """Make instances of FAMILY, one file each, and print their paths (workbench families lists families).

    Where legs lead around walls or through a wind without closed form their costs are planned; the scenario and the
    paths then lie beside the instance.

    \b
    Examples:
      workbench generate uniform --tasks 20 --uavs 3 --out instances
      workbench generate corridor --tasks 12 --count 5 --set wind=shear
      workbench generate wind-vortices --set vortices=2 --json
      workbench generate wind-front --tasks 12 --forecast 600
    """
    from formulations.moving_cost.families import costed
    from instances.families import FAMILIES, check_family, make_scenario
    from instances.files import write_instance
    from instances.scenario import write_scenario
    from workbench.settings import key_values, make_folder

    parameters = key_values(settings, "--set")
    check_family(family, parameters)
    made = []
    for number in range(seed, seed + count):
        scenario = make_scenario(family, tasks, depots, number, **parameters)
        instance, paths = costed(scenario, FAMILIES.load(family).legs)
        path = make_folder(out) / f"{instance.name}.json"
        if paths is None:
            write_instance(instance, path)
        else:
            from workbench.planning import require_confirmed, write_plan  # here: numba takes its time

            require_confirmed(instance, paths, scenario)
            write_scenario(scenario, path.with_suffix(".toml"))
            write_plan(instance, paths, path, path.with_suffix(".toml"))
        files = {"file": path}
        if forecast is not None:
            files["scenario"] = _as_forecast(scenario, instance, forecast, path.with_suffix(""))
        made.append({"seed": number, **files, **instance.about()})
        if not as_json:
            click.echo(str(path))
    if as_json:
        print_json({"family": family, "parameters": parameters, "instances": made})


def _as_forecast(scenario: Scenario, instance: Instance, step: float, folder: Path) -> Path:
    """Write the scenario with its wind as a forecast, as far as the instance's clock reaches, and return its file."""
    import numpy as np  # here: click must not wait for it

    from instances.environment.wind_changing import ChangingWind
    from instances.environment.wind_forecast import sampled
    from instances.errors import InputError
    from instances.scenario import write_scenario
    from workbench.settings import make_folder

    if instance.travel is None or not isinstance(scenario.wind, ChangingWind):
        raise InputError(f"--forecast: the wind of {scenario.name} does not change with time")
    times = np.arange(0.0, float(instance.travel.departures[-1]) + step, step)
    path = make_folder(folder) / "scenario.toml"
    write_scenario(replace(scenario, wind=sampled(scenario.wind, scenario.region, times, FORECAST_CELLS)), path)
    return path
