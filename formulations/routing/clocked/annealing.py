"""Annealed ruin-and-recreate by the clock, the loop inside `ruin-recreate` and `memetic` where costs change with time.

Ruins and moves of long segments go by the costs of half time. A move that these let pass is booked exactly and judged
again; so is a whole tour turned round, which no static search need try.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.routing.clocked.bookings import Bookings, Eras, book_all, book_tour, fly_tour, reverse
from formulations.routing.clocked.recreate import recreate
from formulations.routing.clocks import Clocks
from formulations.routing.search.annealing import AnnealingParameters
from formulations.routing.search.costs import Costs
from formulations.routing.search.energy import Measure, Objective, energy, fitness
from formulations.routing.search.moves import MoveParameters, Workspace, empty_workspace, move
from formulations.routing.search.problem_data import Nodes, ProblemData
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import GUIDES, shuffle
from formulations.routing.search.ruin import Removed, remove_adjacent, remove_strings, restore
from formulations.routing.search.tours import Tours, copy_tours, longest, unlink
from instances.arrays import Bools, Floats
from instances.kernels import njit

TURNS = 0.02
"""Share of steps that turn a tour round."""


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
def _ruin_and_recreate(
    search: Search, rng: Rng, now: float, temperature: float, objective: Objective, parameters: AnnealingParameters
) -> float:
    """Take tasks out and insert them again where that is accepted; return the energy then [s]."""
    clocks, eras, data, tours, bookings, room = search
    costs, removed, queue, sizes, touched = data.costs, room.removed, room.queue, room.sizes, room.touched
    times, marks, rows, row_marks, costs_before = bookings.times, bookings.marks, room.rows, room.marks, room.costs
    for k in range(sizes.size):
        sizes[k], costs_before[k] = tours.size[k], tours.cost[k]
    if uniform(rng) < parameters.strings:
        count = remove_strings(costs, data.near.tasks, tours, removed, rng)
    else:
        count = remove_adjacent(costs, data.near.tasks, tours, removed, rng)
    for k in range(sizes.size):
        touched[k] = tours.size[k] != sizes[k]
    for i in range(count):
        v = removed.tasks[i]
        queue[i] = v
        for c in range(rows.shape[1]):
            rows[i, c] = times[v, c]
        row_marks[i, 0], row_marks[i, 1] = marks[v, 0], marks[v, 1]
    shuffle(queue, count, rng)
    guide = GUIDES[below(rng, parameters.guides)]
    recreate(clocks, eras, costs, data.near, tours, bookings, queue, count, guide, parameters.recreate, rng, touched)
    for k in range(sizes.size):
        if touched[k]:
            fly_tour(clocks, tours, bookings, k)
    then = energy(tours.cost, objective)
    if then < now - temperature * math.log(1.0 - uniform(rng)):
        _book_touched(clocks, eras, tours, bookings, touched)
        return then
    for i in range(count):
        v = removed.tasks[i]
        unlink(costs, tours, v)
        for c in range(rows.shape[1]):
            times[v, c] = rows[i, c]
        marks[v, 0], marks[v, 1] = row_marks[i, 0], row_marks[i, 1]
    restore(costs, tours, count, removed)
    for k in range(sizes.size):
        tours.cost[k] = costs_before[k]
    return now


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
    tours = search.tours
    book_all(search.clocks, search.eras, tours, search.bookings)
    now = energy(tours.cost, objective)
    lowest = fitness(fittest.cost, measure)
    for _ in range(steps):
        draw = uniform(rng)
        if draw < TURNS:
            then = _turn_round(search, rng, now, temperature, objective)
        elif draw < TURNS + parameters.moves:
            then = _move_segments(search, rng, now, temperature, objective, parameters.move)
        else:
            then = _ruin_and_recreate(search, rng, now, temperature, objective, parameters)
        if then != now:
            now = then
            lowest = _keep(tours, best, fittest, lowest, measure)
