"""Routes as TSPLIB tours, ``.tour``: the tour of each UAV from its depot on, closed by −1, all of them by another −1.

Nodes are those of the ``.tsp``, ``.atsp``, ``.mtsp`` or ``.vrp`` that is written of the instance (`formats.numbering`).
In every tour that is read a depot begins the next route. So does, where all UAVs start at one, a number past those of
the nodes: LKH-3 writes one tour for all salesmen, with such copies of the depot.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from instances.disk import read_text, write_aside
from instances.errors import InputError, naming, shown
from instances.formats.numbering import file_nodes
from instances.instance import Instance
from instances.routes import Routes, as_routes, check_routes, makespan


def read_tour(path: Path, instance: Instance, *, all_tasks: bool = True) -> Routes:
    """Return the routes for `instance` in the file; InputError as `sol.read_solution` raises it."""
    text = read_text(path)
    with naming(path):
        nodes = file_nodes(instance)
        task = {node: each for each, node in enumerate(nodes[: instance.n_tasks])}
        free = list(enumerate(nodes[instance.n_tasks :]))
        routes: list[list[int]] = [[] for _ in free]
        for depot, stops in _routes(_tours(text), set(nodes[instance.n_tasks :]), len(set(nodes))):
            uav = next(((k, node) for k, node in free if node == depot), None)
            if uav is not None:
                free.remove(uav)
                routes[uav[0]] = [task[node] for node in stops]
            elif stops:
                raise InputError(f"TOUR_SECTION: more routes begin at node {depot} than UAVs start there")
        faults = check_routes(instance, routes, all_tasks=all_tasks)
        if faults:
            more = f" (and {len(faults) - 1} more faults)" if len(faults) > 1 else ""
            raise InputError(faults[0].rstrip(".") + more)
        return as_routes(routes)


def write_tour(routes: Sequence[Sequence[int]], instance: Instance, path: Path, *, all_tasks: bool = True) -> None:
    """Write `routes` of `instance`, with C_max [s] in the COMMENT; InputError where they are infeasible."""
    with naming(path):
        faults = check_routes(instance, routes, all_tasks=all_tasks)
        if faults:
            raise InputError(faults[0].rstrip("."))
    nodes = file_nodes(instance)
    tours = [[nodes[instance.n_tasks + k], *(nodes[task] for task in route)] for k, route in enumerate(routes)]
    lines = [
        f"NAME : {instance.name}",
        f"COMMENT : longest tour {makespan(instance, routes)!r} s; a tour for each UAV; digest {instance.digest}",
        "TYPE : TOUR",
        f"DIMENSION : {len(set(nodes))}",
        "TOUR_SECTION",
        *(f"{' '.join(map(str, tour))} -1" for tour in tours),
    ]
    write_aside(path, "\n".join([*lines, "-1", "EOF"]) + "\n")


def _tours(text: str) -> list[list[int]]:
    """Return the numbers of each tour."""
    lines = [line.strip() for line in text.splitlines()]
    start = next((i for i, line in enumerate(lines) if line.rstrip(" :") == "TOUR_SECTION"), None)
    if start is None:
        raise InputError("there is no TOUR_SECTION")
    tours: list[list[int]] = [[]]
    for number, line in enumerate(lines[start + 1 :], start + 2):
        if line == "EOF":
            break
        for word in line.split():
            if word == "-1":
                tours.append([])
            elif word.isascii() and word.isdigit() and len(word) < 10:
                tours[-1].append(int(word))
            else:
                raise InputError(f"line {number}: TOUR_SECTION must hold nodes and -1, got {shown(word)}")
    return [tour for tour in tours if tour]


def _routes(tours: list[list[int]], depots: set[int], size: int) -> Iterator[tuple[int, list[int]]]:
    """Return the depot and the other nodes of each route in the `tours` of a file of `size` nodes."""
    for tour in tours:
        numbers = [min(depots) if len(depots) == 1 and node > size else node for node in tour]
        for node in numbers:
            if not 1 <= node <= size:
                raise InputError(f"TOUR_SECTION holds node {node}, but the nodes are 1 to {size}")
        starts = [place for place, node in enumerate(numbers) if node in depots]
        if not starts:
            raise InputError(f"TOUR_SECTION: the tour that begins with node {tour[0]} visits no depot")
        turned = numbers[starts[0] :] + numbers[: starts[0]]
        ends = [place - starts[0] for place in starts[1:]] + [len(turned)]
        for start, end in zip([0, *ends], ends, strict=False):
            yield turned[start], turned[start + 1 : end]
