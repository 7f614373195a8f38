"""`workbench warmup`: compile the kernels now, so that nothing later waits for it."""

from __future__ import annotations

import time

import click

from workbench.completing import WARM
from workbench.options import JSON
from workbench.terminal import print_json, say


@click.command("warmup")
@click.argument("names", nargs=-1, shell_complete=WARM)
@JSON
def command(names: tuple[str, ...], as_json: bool) -> None:
    """Compile the kernels of NAMES, once for this version of the code.

    NAMES are solvers, moving-cost methods, costs (all of these), select and
    map; by default all of these. fleets, clocks and states, which must be
    named, are the kernels of all solvers for UAVs that differ, for winds that
    change and for turns between headings. What is compiled lies in your cache
    folder; a method that is not warm compiles when it is first used, before
    its clock starts.

    \b
    Examples:
      workbench warmup
      workbench warmup memetic exact costs
    """
    from rich.console import Console
    from rich.progress import track

    from instances.compilation import WORDS, told_to
    from workbench.warming import warmers

    wanted = warmers(names)
    began = time.perf_counter()
    with told_to(lambda begins: None):  # the bar says it
        for warm in track(list(wanted.values()), console=Console(stderr=True), description=WORDS, transient=True):
            warm()
    elapsed = time.perf_counter() - began
    if as_json:
        print_json({"ready": list(wanted), "elapsed": elapsed})
    else:
        say(f"{', '.join(wanted)}: ready after {elapsed:.0f} s")
