"""Routes as ``.sol`` files of VRPLIB: ``Route #k: customer customer ...``, then ``Cost C_max``.

Numbering: customers as VRPLIB numbers them (`formats.numbering`), so that vrplib's routes index its own arrays of the
``.vrp`` that is written of the instance; a remark says which tasks they are. Route #k is flown from the k-th depot. The
route of a UAV that stays home is written with no customer; a route number that is left out means the same. Lines that
begin with # are remarks.

Read are also files whose remark says that tasks are numbered from 0, which all of ours once were. Where no remark says
it, the numbers do: the first numbering of customers, tasks from 0, and 1 to n that has just these numbers, or else all
of them.

(vrplib reads these files too; it is not used here because it drops the route numbers, and with them the depots.)
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from instances.disk import read_text, write_aside
from instances.errors import InputError, naming, shown
from instances.formats.numbering import customers
from instances.instance import Instance
from instances.routes import Routes, as_routes, check_routes, makespan

_ROUTE = re.compile(r"route\s*#?\s*(\d{1,9})\s*:(.*)", re.IGNORECASE)
_COST = re.compile(r"cost\s*:?\s*(\S+)", re.IGNORECASE)
_CUSTOMERS = re.compile(r"#.*\bcustomers ([0-9,-]+) are the tasks\b.*")
_SPAN = r"\d{1,9}(-\d{1,9})?"
_FROM_0 = re.compile(r"#.*\btasks are numbered from 0\b.*")


def read_solution(path: Path, instance: Instance, *, all_tasks: bool = True) -> tuple[Routes, float | None]:
    """Return the routes for `instance` in the file, and the cost [s] it claims (None where it claims none).

    Raises InputError where it is not a ``.sol``, or its routes do not visit every task of `instance` exactly once;
    without `all_tasks` some may be left out.
    """
    text = read_text(path)
    with naming(path):
        routes, claimed = parse_solution(text, instance)
        faults = check_routes(instance, routes, all_tasks=all_tasks)
        if faults:
            more = f" (and {len(faults) - 1} more faults)" if len(faults) > 1 else ""
            numbers = _numbers(text, instance, _parse(text, instance.n_depots)[0])
            which = "" if numbers == list(instance.tasks) else f"; tasks from 0 are here customers {_spans(numbers)}"
            raise InputError(faults[0].rstrip(".") + more + which)
        return routes, claimed


def parse_solution(text: str, instance: Instance) -> tuple[Routes, float | None]:
    """Return the routes in `text`, as our tasks, and the cost [s] it claims; whether they are feasible is not asked."""
    found, claimed = _parse(text, instance.n_depots)
    numbers = _numbers(text, instance, found)
    task = {number: each for each, number in enumerate(numbers)}
    for k, route in found.items():
        for number in route:
            if number not in task and numbers != list(instance.tasks):
                raise InputError(f"route #{k} holds {number}, which is none of the customers {_spans(numbers)}")
    return as_routes([task.get(c, c) for c in found.get(k, [])] for k in range(1, instance.n_depots + 1)), claimed


def write_solution(routes: Sequence[Sequence[int]], instance: Instance, path: Path, *, all_tasks: bool = True) -> None:
    """Write `routes` of `instance` with their cost C_max [s], recomputed here; InputError where they are infeasible."""
    with naming(path):
        faults = check_routes(instance, routes, all_tasks=all_tasks)
        if faults:
            raise InputError(faults[0].rstrip("."))
    numbers = customers(instance)
    name = instance.name.replace("Route", "route")  # vrplib takes every line with "Route" for one
    lines = [
        f"# {name}, digest {instance.digest}: Cost is that of the longest route [s]",
        f"# customers {_spans(numbers)} are the tasks, in order",
        "# route #1 is that of UAV 0, route #k that of UAV k - 1: the format numbers routes from 1",
        *(
            f"Route #{k}: {' '.join(str(numbers[task]) for task in route)}".rstrip()
            for k, route in enumerate(routes, 1)
        ),
        f"Cost {makespan(instance, routes)!r}",
    ]
    write_aside(path, "\n".join(lines) + "\n")


def _parse(text: str, n_depots: int) -> tuple[dict[int, list[int]], float | None]:
    """Return the numbers on each route, and the cost claimed."""
    found: dict[int, list[int]] = {}
    claimed: float | None = None
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.strip()
        if not line or line.startswith("#"):
            continue
        if route := _ROUTE.fullmatch(line):
            k = int(route[1])
            if not 1 <= k <= n_depots:
                raise InputError(f"line {number}: route #{k}, but the depots are 1 to {n_depots}")
            if k in found:
                raise InputError(f"line {number}: route #{k} is given twice")
            found[k] = [_task(word, number, k) for word in route[2].split()]
        elif cost := _COST.fullmatch(line):
            claimed = _number(cost[1], number)
        else:
            raise InputError(f"line {number} must read 'Route #k: tasks' or 'Cost value', got {shown(line)}")
    if not found:
        raise InputError("there is no line 'Route #k: tasks'")
    return found, claimed


def _numbers(text: str, instance: Instance, found: Mapping[int, list[int]]) -> list[int]:
    """Return the number that each task has in the file."""
    return _stated(text, instance.n_tasks) or _guessed(found, instance)


def _stated(text: str, n_tasks: int) -> list[int] | None:
    """Return the number of each task that a remark states, None where none does."""
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.strip()
        if _FROM_0.fullmatch(line):
            return list(range(n_tasks))
        if said := _CUSTOMERS.fullmatch(line):
            spans = [tuple(map(int, span.split("-"))) for span in said[1].split(",") if re.fullmatch(_SPAN, span)]
            lengths = [span[-1] - span[0] + 1 for span in spans]
            if min(lengths, default=0) > 0 and sum(lengths) == n_tasks:
                return [customer for span in spans for customer in range(span[0], span[-1] + 1)]
            raise InputError(f"line {number}: {shown(said[1])} are not the numbers of {n_tasks} customers")
    return None


def _guessed(found: Mapping[int, list[int]], instance: Instance) -> list[int]:
    """Return the number of each task in a file that does not state it."""
    there = {number for route in found.values() for number in route}
    known = [customers(instance), list(instance.tasks), list(range(1, instance.n_tasks + 1))]
    same = [numbers for numbers in known if there == set(numbers)]
    holding = [numbers for numbers in known if there <= set(numbers)]
    return [*same, *holding, known[1 if 0 in there else 0]][0]


def _spans(numbers: Sequence[int]) -> str:
    """Return rising `numbers` as "1-3,5-9"."""
    spans: list[list[int]] = []
    for number in numbers:
        if spans and number == spans[-1][-1] + 1:
            spans[-1] = [spans[-1][0], number]
        else:
            spans.append([number])
    return ",".join("-".join(map(str, span)) for span in spans)


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
