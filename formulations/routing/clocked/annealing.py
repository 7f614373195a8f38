"""Annealed ruin-and-recreate by the clock, the loop inside `ruin-recreate` and `memetic` where costs change with time.

A ruin and recreation is priced to first order (`bookings.py`) and flown exactly only where it may be accepted; half of
them put every task back where it was, and are not priced at all. Moves of long segments go by the costs of half time:
one that these let pass is booked exactly and judged again; so is a whole tour turned round, which no static search need
try.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from formulations.routing.clocked.bookings import (
    DEPARTS,
    KNOT,
    SENSE,
    SINCE,
    Bookings,
    Eras,
    book_all,
    book_tour,
    fly_tour,
    reverse,
)
from formulations.routing.clocked.recreate import recreate
from formulations.routing.clocks import Clocks
from formulations.routing.search.annealing import AnnealingParameters, undo
from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Measure, Objective, energy, fitness
from formulations.routing.search.moves import MoveParameters, Workspace, empty_workspace, move
from formulations.routing.search.problem_data import Nodes, ProblemData
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import GUIDES, shuffle
from formulations.routing.search.ruin import Removed, remove_adjacent, remove_strings
from formulations.routing.search.tours import Tours, copy_tours, longest
from instances.arrays import Bools, Floats
from instances.kernels import njit

TURNS = 0.02
"""Share of steps that turn a tour round."""
DOUBT = 4.0
"""How many mean errors a step's energy to first order may be above what would be accepted, and is still flown."""
LEARNING = 0.02
"""Share of that mean which the last step flown makes."""


@njit(cache=True, nogil=True)
def _keep(tours: Tours, best: Tours, fittest: Tours, lowest: float, measure: Measure) -> float:
    """Copy `tours` to `best` where their longest is shorter, to `fittest` where fitness is below `lowest` [s]."""
    now = longest(tours.cost)
    if now < longest(best.cost):
        copy_tours(tours, best)
    if now - measure.cap < lowest:
        value = fitness(tours.cost, measure)
        if value < lowest:
            copy_tours(tours, fittest)
            return value
    return lowest


@njit(cache=True, nogil=True)
def _book_touched(clocks: Clocks, eras: Eras, tours: Tours, bookings: Bookings, touched: Bools) -> None:
    for k in range(touched.size):
        if touched[k]:
            book_tour(clocks, eras, tours, bookings, k)


@njit(cache=True, nogil=True)
def _flown(
    clocks: Clocks, tours: Tours, bookings: Bookings, touched: Bools, objective: Objective, limit: float, doubt: float
) -> tuple[float, float]:
    """Return the energy [s] flown exactly, +inf where it is far above `limit` to first order, and the mean error."""
    guess = energy(tours.cost, objective)
    if guess >= limit + DOUBT * doubt:
        return np.inf, doubt
    for k in range(touched.size):
        if touched[k]:
            fly_tour(clocks, tours, bookings, k)
    flown = energy(tours.cost, objective)
    return flown, doubt + LEARNING * (abs(flown - guess) - doubt)


@njit(cache=True, nogil=True)
def _mark_changed(tours: Tours, spare: Tours, touched: Bools) -> bool:
    """Mark the tours that differ from `spare`; return whether any does."""
    changed = False
    for k in range(touched.size):
        touched[k] = False
    for u in range(tours.after.size):
        if tours.after[u] != spare.after[u]:
            touched[tours.tour[u]] = changed = True
            touched[spare.tour[u]] = True
    return changed


class Room(NamedTuple):
    """What steps write to.

    Removed tasks, their queue, their bookings (rows and marks) before; sizes and costs (m,) before, tours touched (m,);
    spare tours and segments.
    """

    removed: Removed
    queue: Nodes
    rows: Floats
    marks: Nodes
    sizes: Nodes
    costs: Floats
    touched: Bools
    spare: Tours
    workspace: Workspace


class Search(NamedTuple):
    """What steps work on. clocks: finite costs; data: of the costs of half time; tours: booked in `bookings`."""

    clocks: Clocks
    eras: Eras
    data: ProblemData
    tours: Tours
    bookings: Bookings
    room: Room


@njit(cache=True, nogil=True)
def empty_room(costs: Costs, spare: Tours, removals: int) -> Room:
    """Return room for so many removals; `spare` is a copy of the tours."""
    m = spare.cost.size
    removed = Removed(np.empty(removals, np.int32), np.empty(removals, np.int32), np.zeros(m, np.bool_))
    workspace = empty_workspace(costs, spare.after.size - m)
    queue, rows, marks = np.empty(removals, np.int32), np.empty((removals, 4)), np.empty((removals, 2), np.int32)
    sizes, touched = np.empty(m, np.int32), np.zeros(m, np.bool_)
    return Room(removed, queue, rows, marks, sizes, np.empty(m), touched, spare, workspace)


@njit(cache=True, nogil=True)
def _turn_round(search: Search, rng: Rng, now: float, temperature: float, objective: Objective) -> float:
    """Turn a random tour round where that is accepted; return the energy then [s]."""
    tours, k = search.tours, below(rng, search.tours.cost.size)
    reverse(tours, k)
    book_tour(search.clocks, search.eras, tours, search.bookings, k)
    then = energy(tours.cost, objective)
    if then < now - temperature * math.log(1.0 - uniform(rng)):
        return then
    reverse(tours, k)
    book_tour(search.clocks, search.eras, tours, search.bookings, k)
    return now


@njit(cache=True, nogil=True)
def _move_segments(
    search: Search, rng: Rng, now: float, temperature: float, objective: Objective, parameters: MoveParameters
) -> float:
    """Make a move that half time lets pass where the clock accepts it; return the energy then [s]."""
    clocks, tours, room = search.clocks, search.tours, search.room
    copy_tours(tours, room.spare)
    nearest = search.data.near.tasks
    move(search.data.costs, nearest, tours, room.workspace, rng, now, temperature, objective, parameters)
    if not _mark_changed(tours, room.spare, room.touched):
        return now
    _book_touched(clocks, search.eras, tours, search.bookings, room.touched)
    then = energy(tours.cost, objective)
    if then < now - parameters.temperature * temperature * math.log(1.0 - uniform(rng)):
        return then
    copy_tours(room.spare, tours)
    _book_touched(clocks, search.eras, tours, search.bookings, room.touched)
    return now


@njit(cache=True, nogil=True)
def _turn_or_move(
    search: Search,
    turns: bool,
    rng: Rng,
    now: float,
    temperature: float,
    objective: Objective,
    parameters: MoveParameters,
) -> float:
    """Turn a tour round or make a move; return the energy then [s]."""
    if turns:
        return _turn_round(search, rng, now, temperature, objective)
    return _move_segments(search, rng, now, temperature, objective, parameters)


@njit(cache=True, nogil=True)
def _copy(source: Any, target: Any) -> None:
    """Copy an array; a slice would take many times as long, these being short."""
    for i in range(source.size):
        target[i] = source[i]


@njit(cache=True, nogil=True)
def _ruin(costs: Costs, nearest: Nodes, tours: Tours, removed: Removed, strings: float, rng: Rng) -> int:
    """Take tasks out, strings of them or neighbours; return how many."""
    if uniform(rng) < strings:
        return remove_strings(costs, nearest, tours, removed, rng)
    return remove_adjacent(costs, nearest, tours, removed, rng)


@njit(cache=True, nogil=True)
def _close_gaps(
    clocks: Clocks,
    tours: Tours,
    bookings: Bookings,
    removed: Removed,
    count: int,
    was: Nodes,
    sizes: Nodes,
    costs: Floats,
    touched: Bools,
) -> None:
    """Mark the tours that tasks were taken from, and take what they save, to first order, from their `costs` before.

    was (n+m,), sizes (m,) : the nodes after each and the sizes of the tours, before. A gap behind a node that is left
    saves (A_w − A'_w)·S_w at the next node w.
    """
    lines, classes, times, marks, scales = clocks.lines, clocks.classes, bookings.times, bookings.marks, bookings.scale
    tour, after, cost, size, tasks, behind = tours.tour, tours.after, tours.cost, tours.size, *removed[:2]
    n = after.size - cost.size
    for k in range(cost.size):
        cost[k], touched[k] = costs[k], size[k] != sizes[k]
    for i in range(count):
        u = behind[i]
        k = tour[u]
        if k < 0 or was[u] != tasks[i]:  # taken out itself, or the gap behind it begins with another task
            continue
        w, q, g, scale = after[u], marks[u, KNOT], classes[k], scales[k]
        there = lines[g, u, w, q, 0] + lines[g, u, w, q, 1] * times[u, SINCE] if u != w else 0.0
        arrival, sense = (costs[k], 1.0) if w >= n else (times[w, DEPARTS] * scale, times[w, SENSE])
        cost[k] += ((times[u, DEPARTS] + there) * scale - arrival) * sense


@njit(cache=True, nogil=True)
def _remember(
    times: Floats, marks: Nodes, tasks: Nodes, count: int, queue: Nodes, rows: Floats, row_marks: Nodes
) -> None:
    """Queue the tasks taken out, and copy their bookings to `rows` and `row_marks`."""
    for i in range(count):
        v = tasks[i]
        queue[i] = v
        for c in range(rows.shape[1]):
            rows[i, c] = times[v, c]
        row_marks[i, 0], row_marks[i, 1] = marks[v, 0], marks[v, 1]


@njit(cache=True, nogil=True)
def _recall(times: Floats, marks: Nodes, tasks: Nodes, count: int, rows: Floats, row_marks: Nodes) -> None:
    """Copy the bookings of the tasks taken out back."""
    for i in range(count):
        v = tasks[i]
        for c in range(rows.shape[1]):
            times[v, c] = rows[i, c]
        marks[v, 0], marks[v, 1] = row_marks[i, 0], row_marks[i, 1]


@njit(cache=True, nogil=True)
def _all_back(tasks: Nodes, count: int, before: Nodes, after: Nodes, was: Nodes) -> bool:
    """Return whether all tasks taken out are back where they were, `was` being the nodes after each before."""
    for i in range(count):
        v = tasks[i]
        if after[v] != was[v] or was[before[v]] != v:
            return False
    return True


@njit(cache=True, nogil=True)
def anneal_by_clock(
    search: Search,
    best: Tours,
    fittest: Tours,
    rng: Rng,
    steps: int,
    temperature: float,
    objective: Objective,
    measure: Measure,
    parameters: AnnealingParameters,
) -> None:
    """Take `steps` steps from the tours of `search`, in place; `search.annealing.anneal` says what the others are."""
    clocks, eras, data, tours, bookings, room = search  # once: in the loop each access would count references
    costs, near, nearest, removed, queue, touched = data.costs, data.near, data.near.tasks, room[0], room[1], room[6]
    times, marks, rows, row_marks, sizes, costs_before = bookings.times, bookings.marks, *room[2:6]
    tasks, size, cost, before, after = removed.tasks, tours.size, tours.cost, tours.before, tours.after
    book_all(clocks, eras, tours, bookings)
    now, was, doubt = energy(cost, objective), after.copy(), 0.0
    lowest = fitness(fittest.cost, measure)
    for _ in range(steps):
        draw, then = uniform(rng), now
        if draw < TURNS + parameters.moves:
            turns = draw < TURNS
            then = _turn_or_move(search, turns, rng, now, temperature, objective, parameters.move)
            _copy(after, was)
        else:
            _copy(cost, costs_before)
            _copy(size, sizes)
            count = _ruin(costs, nearest, tours, removed, parameters.strings, rng)
            _close_gaps(clocks, tours, bookings, removed, count, was, sizes, costs_before, touched)
            _remember(times, marks, tasks, count, queue, rows, row_marks)
            shuffle(queue, count, rng)
            guide = GUIDES[below(rng, parameters.guides)]
            recreate(clocks, eras, costs, near, tours, bookings, queue, count, guide, parameters.recreate, rng, touched)
            if _all_back(tasks, count, before, after, was):
                _copy(costs_before, cost)
                _recall(times, marks, tasks, count, rows, row_marks)
                continue
            limit = now - temperature * math.log(1.0 - uniform(rng))
            flown, doubt = _flown(clocks, tours, bookings, touched, objective, limit, doubt)
            if flown < limit:
                _book_touched(clocks, eras, tours, bookings, touched)
                _copy(after, was)
                then = flown
            else:
                undo(costs, tours, count, removed, costs_before)
                _recall(times, marks, tasks, count, rows, row_marks)
        if then != now:
            now = then
            lowest = _keep(tours, best, fittest, lowest, measure)
