"""Team-orienteering files (.txt), as Chao, Golden & Wasil (EJOR 88, 1996) and those after them publish their sets.

    n 32          nodes, start and end among them
    m 2           UAVs
    tmax 5.0      what each may fly
    x  y  score   a node a line: first the start, last the end, both of score 0

Costs are Euclidean distances, not rounded. All m UAVs take off at the start and land at the end: they are m depots at
the start, and the way home from a task is its way to the end. tmax is the endurance; nodes that nobody can reach
within it are left in. What a task scores is kept as ``provenance["prizes"]``, where `workbench select` finds it.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from instances.arrays import Floats
from instances.disk import read_text
from instances.errors import InputError, naming, shown
from instances.formats.format import Format
from instances.instance import Instance, check_size

_HEADS = ("n", "m", "tmax")


def read_team_orienteering(path: Path) -> Instance:
    """Read a team-orienteering file; InputError names the file, the line and the value that cannot be used."""
    text = read_text(path)
    with naming(path):
        lines = [(number, line.split()) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
        if len(lines) < len(_HEADS):
            raise InputError("must begin with the lines 'n', 'm' and 'tmax'")
        heads = [_head(name, *line) for name, line in zip(_HEADS, lines[: len(_HEADS)], strict=True)]
        for name, value in zip(_HEADS[:2], heads, strict=False):
            if value != int(value) or value < 1:
                raise InputError(f"{name} must be a whole number of at least 1, got {value:g}")
        n_nodes, n_uavs = int(heads[0]), int(heads[1])
        nodes = lines[len(_HEADS) :]
        if n_nodes < 3:
            raise InputError(f"n is {n_nodes}: beside start and end there is no task")
        if len(nodes) != n_nodes:
            raise InputError(f"has {len(nodes)} lines 'x y score', must have n = {n_nodes}")
        check_size(n_nodes - 2, n_uavs)
        rows = np.array([_node(*line) for line in nodes])
        return _instance(path.name[: -len(".txt")], rows, n_uavs, heads[2])


def _instance(name: str, rows: Floats, n_uavs: int, tmax: float) -> Instance:
    """Return the instance of rows (x, y, score), start first, end last."""
    points, prizes = rows[:, :2], rows[:, 2]
    for which, at in (("start", 0), ("end", -1)):
        if prizes[at] != 0:
            raise InputError(f"the {which} scores {prizes[at]:g}, must score 0")
    tasks, start, end = points[1:-1], points[0], points[-1]
    n = len(tasks)
    cost = np.zeros((n + n_uavs, n + n_uavs))
    with np.errstate(over="ignore"):  # Instance names what is too far
        cost[:n, :n] = np.hypot(*(tasks[:, None] - tasks).transpose(2, 0, 1))
        cost[n:, :n] = np.hypot(*(tasks - start).T)
        cost[:n, n:] = np.hypot(*(tasks - end).T)[:, None]
    provenance = {"format": "team orienteering", "prizes": prizes[1:-1].tolist(), "end": end.tolist()}
    places = np.vstack([tasks, np.tile(start, (n_uavs, 1))])
    return Instance(name, cost, n, n_uavs, places, provenance, endurance=np.full(n_uavs, tmax))


def _head(name: str, number: int, words: list[str]) -> float:
    if len(words) != 2 or words[0].lower() != name:
        raise InputError(f"line {number} must read '{name} NUMBER', got {shown(' '.join(words))}")
    return _number(words[1], number, name)


def _node(number: int, words: list[str]) -> tuple[float, ...]:
    if len(words) != 3:
        raise InputError(f"line {number} must read 'x y score', got {shown(' '.join(words))}")
    x, y, score = (_number(word, number, name) for word, name in zip(words, ("x", "y", "score"), strict=True))
    if score < 0:
        raise InputError(f"line {number}: score must not be negative, got {score:g}")
    return x, y, score


def _number(word: str, line: int, name: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"line {line}: {name} must be a number, got {shown(word)}")
    return value


TEAM_ORIENTEERING = Format(read_team_orienteering)
