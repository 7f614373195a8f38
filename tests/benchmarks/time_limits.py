"""Are time limits kept? Every solver, and every placement method, on one core that another process keeps busy.

    python tests/benchmarks/time_limits.py [--sizes 500 5000] [--depots 5] [--limit 5] [--only TEXT] [--markdown]
    python tests/benchmarks/time_limits.py --problem placement [--sizes 40 200]

Runs go through the runner, as those of a study do: the clock is not the solver's own, peak memory is that of the
child. Routing: tasks in a 20 km square in a sheared wind. Placement: the 20 km square with 20 × 20 test points. Moving
costs have no row: their methods are given no limit, a run that takes longer is ended from outside.

Prints a row for each run; exit code 1 where one ended more than a second after its limit, or badly.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
from collections.abc import Callable
from typing import Any

from shapely.geometry import mapping

from formulations.moving_cost.families import generate
from formulations.task_location.setting import region_of
from reports.record import Run
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.problems.placement import PLACEMENT, PlacementItem
from workbench.problems.routing import ROUTING

LATE = 1.0
"""Seconds after its limit that a run may end."""
BAD = ("KILLED", "ERROR")
HEADINGS = ("method", "n", "limit", "elapsed", "overrun", "status", "cost", "peak MB", "")
ALIGNED = "{:16} {:>5} {:>5} {:>7} {:>7} {:11} {:>10} {:>7}  {}"
MARKDOWN = "| " + " | ".join(["{}"] * len(HEADINGS)) + " |"


def busy() -> None:
    """Keep a core busy."""
    while True:
        pass


def routing_item(n: int, depots: int) -> Any:
    """Return an instance of n tasks."""
    return generate("uniform", n, depots, 0, wind="shear")


def placement_item(n: int, depots: int) -> Any:
    """Return a placement problem of n tasks; it has no depots."""
    polygon = json.loads(json.dumps(mapping(region_of(None).polygon)))
    return PlacementItem(f"square-n{n}", polygon, {"tests": "20x20"}, n)


PROBLEMS: dict[str, tuple[Any, Callable[[int, int], Any], list[int]]] = {
    "routing": (ROUTING, routing_item, [500, 5000]),
    "placement": (PLACEMENT, placement_item, [40, 200]),
}
"""Name → problem, how an item of n tasks is made, sizes."""


def row(found: Run, n: int) -> tuple[str, ...]:
    """Return the cells of one run; a run that was declined has neither time nor cost."""
    if found.stopped_by == "declined":
        return (found.solver, str(n), f"{found.time_limit:g}", "", "", "declined", "", "", found.message)
    cost = "" if found.objective is None else f"{found.objective:.6g}"
    times = f"{found.elapsed:.2f}", f"{max(0.0, found.elapsed - found.time_limit):.2f}"
    ended = found.message if found.status in BAD else found.stopped_by
    peak = f"{found.peak_memory / 1e6:.0f}"
    return (found.solver, str(n), f"{found.time_limit:g}", *times, found.status, cost, peak, ended)


def main() -> None:
    """Run every method on every size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problem", choices=PROBLEMS, default="routing")
    parser.add_argument("--sizes", type=int, nargs="+")
    parser.add_argument("--depots", type=int, default=5)
    parser.add_argument("--limit", type=float, default=5.0)
    parser.add_argument("--only", default="")
    parser.add_argument("--markdown", action="store_true")
    chosen = parser.parse_args()
    problem, item_of, sizes = PROBLEMS[chosen.problem]
    core = min(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})  # what is started from here inherits it
    rival = multiprocessing.get_context("spawn").Process(target=busy, daemon=True)
    rival.start()
    line = MARKDOWN if chosen.markdown else ALIGNED
    print(line.format(*HEADINGS))
    if chosen.markdown:
        print(line.format(*["---"] * len(HEADINGS)))
    late = 0
    try:
        for n in chosen.sizes or sizes:
            item = item_of(n, chosen.depots)
            for name in (name for name in problem.methods.targets() if chosen.only in name):
                found = run(problem, Job("given", name, time_limit=chosen.limit), item)
                print(line.format(*row(found, n)), flush=True)
                late += found.elapsed > found.time_limit + LATE or found.status in BAD
    finally:
        rival.kill()
    sys.exit(late > 0)


if __name__ == "__main__":
    main()
