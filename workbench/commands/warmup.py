"""`workbench warmup`: compile the kernels now, so that nothing later waits for it."""

from __future__ import annotations

import time

import click

from workbench.completing import SOLVER
from workbench.options import JSON
from workbench.terminal import print_json, say


@click.command("warmup")
@click.argument("solvers", nargs=-1, shell_complete=SOLVER)
@JSON
def command(solvers: tuple[str, ...], as_json: bool) -> None:
    """Compile the kernels of SOLVERS (by default of all that are there), once for this version of the code.

    What is compiled lies in your cache folder; a method that is not warm compiles when it is first used, before its
    clock starts.

    \b
    Examples:
      workbench warmup
      workbench warmup memetic exact
    """
    from rich.console import Console
    from rich.progress import track

    from formulations.moving_cost.families import generate
    from formulations.routing.registry import SOLVERS, make_solver
    from formulations.routing.solver import refusal

    names = list(solvers) or [name for name in SOLVERS.built_in if SOLVERS.why_unavailable(name) is None]
    methods = {name: make_solver(name) for name in names}
    instance = generate("uniform", 6, 2, 0)
    began = time.perf_counter()
    for solver in track(
        list(methods.values()), console=Console(stderr=True), description="compiling kernels, once", transient=True
    ):
        if refusal(solver, instance) is None:
            solver.prepare(instance)
    elapsed = time.perf_counter() - began
    if as_json:
        print_json({"ready": names, "elapsed": elapsed})
    else:
        say(f"{', '.join(names)}: ready after {elapsed:.0f} s")
