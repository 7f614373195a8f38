"""Routes as ``.sol`` files, in the style of CVRPLIB: ``Route #k: task task ...``, then ``Cost C_max``.

Numbering: tasks as everywhere here, from 0; route #1 is flown from the first depot (node n), route #k from node
n+k−1. The route of a UAV that stays home is written with no task; a route number that is left out means the same.
Lines that begin with # are remarks. (vrplib reads these files too; it is not used here because it drops the route
numbers, and with them the depots.)
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

from instances.disk import read_text, write_aside
from instances.errors import InputError, naming, shown
from instances.instance import Instance
from instances.routes import Routes, as_routes, check_routes, makespan

_ROUTE = re.compile(r"route\s*#?\s*(\d{1,9})\s*:(.*)", re.IGNORECASE)
_COST = re.compile(r"cost\s*:?\s*(\S+)", re.IGNORECASE)


def read_solution(path: Path, instance: Instance, *, all_tasks: bool = True) -> tuple[Routes, float | None]:
    """Return the routes for `instance` in the file, and the cost [s] it claims (None where it claims none).

    Raises InputError where it is not a ``.sol``, or its routes do not visit every task of `instance` exactly once;
    without `all_tasks` some may be left out.
    """
    text = read_text(path)
    with naming(path):
        routes, claimed = _parse(text, instance)
        faults = check_routes(instance, routes, all_tasks=all_tasks)
        if faults:
            more = f" (and {len(faults) - 1} more faults)" if len(faults) > 1 else ""
            raise InputError(faults[0].rstrip(".") + more)
        return routes, claimed


def write_solution(routes: Sequence[Sequence[int]], instance: Instance, path: Path, *, all_tasks: bool = True) -> None:
    """Write `routes` of `instance` with their cost C_max [s], recomputed here; InputError where they are infeasible."""
    with naming(path):
        faults = check_routes(instance, routes, all_tasks=all_tasks)
        if faults:
            raise InputError(faults[0].rstrip("."))
    lines = [
        f"# {instance.name}, digest {instance.digest}: tasks are numbered from 0, "
        f"route k starts and ends at node {instance.n_tasks - 1} + k",
        "# route #1 is that of UAV 0, route #k that of UAV k - 1: the format numbers routes from 1",
        *(" ".join([f"Route #{k}:", *map(str, route)]) for k, route in enumerate(as_routes(routes), 1)),
        f"Cost {makespan(instance, routes)!r}",
    ]
    write_aside(path, "\n".join(lines) + "\n")


def _parse(text: str, instance: Instance) -> tuple[Routes, float | None]:
    found: dict[int, list[int]] = {}
    claimed: float | None = None
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.strip()
        if not line or line.startswith("#"):
            continue
        if route := _ROUTE.fullmatch(line):
            k = int(route[1])
            if not 1 <= k <= instance.n_depots:
                raise InputError(f"line {number}: route #{k}, but the depots are 1 to {instance.n_depots}")
            if k in found:
                raise InputError(f"line {number}: route #{k} is given twice")
            found[k] = [_task(word, number, k) for word in route[2].split()]
        elif cost := _COST.fullmatch(line):
            claimed = _number(cost[1], number)
        else:
            raise InputError(f"line {number} must read 'Route #k: tasks' or 'Cost value', got {shown(line)}")
    if not found:
        raise InputError("there is no line 'Route #k: tasks'")
    return as_routes(found.get(k, []) for k in range(1, instance.n_depots + 1)), claimed


def _task(word: str, line: int, route: int) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 10):
        raise InputError(f"line {line}: route #{route} holds {shown(word)}, which is not a task number")
    return int(word)


def _number(word: str, line: int) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"line {line}: the cost must be a number, got {shown(word)}")
    return value
