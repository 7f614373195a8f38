"""What a search by the clock works on, made from an instance: clocks, the costs of half time, endurance, tours."""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.annealing import Search, empty_room
from formulations.routing.clocked.bookings import book_all, empty_bookings, eras_of
from formulations.routing.clocked.waiting import WINDOW, Waits
from formulations.routing.clocks import Clocks, clocks_of, lines_of
from formulations.routing.greedy import greedy_routes
from formulations.routing.search.costs import FleetCosts, search_costs
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.problem_data import NeighbourhoodParameters, ProblemData, problem_data
from formulations.routing.search.tours import Tours, duplicate, empty_tours, from_routes
from instances import Instance, Routes, makespan
from instances.frozen import frozen, guiding


class ClockedProblem:
    """An instance whose costs change with time, as searches see it.

    clocks : finite costs by departure; data : the costs of half time, with which legs, neighbourhoods and moves of long
    segments are priced; endurance : whose scales the bookings share; waits : who may wait before take-off, in whose
    place endurance is then kept.
    """

    def __init__(self, instance: Instance, parameters: NeighbourhoodParameters) -> None:
        half = half_time(instance)
        still = guiding(instance, half)
        self.instance, self.clocks = instance, search_clocks(instance)
        self.waits = Waits(instance, 2 * half)
        self.eras = eras_of(self.clocks, 2 * half + float(self.waits.table[:, WINDOW].max()))
        self.endurance = Endurance(still, search_costs(still))
        self.data: ProblemData = problem_data(self.endurance.costs, instance.n_tasks, parameters)
        costs = self.endurance.costs
        self.scale = costs.scale if isinstance(costs, FleetCosts) else np.ones(instance.n_depots)

    def search(self, tours: Tours, removals: int) -> Search:
        """Return a search that begins with `tours`, which it books."""
        bookings = empty_bookings(self.instance.n_nodes, self.scale, self.waits.table)
        book_all(self.clocks, self.eras, tours, bookings)
        room = empty_room(self.data.costs, duplicate(tours), removals)
        return Search(self.clocks, self.eras, self.data, tours, bookings, room)

    def tours(self, routes: Routes | None = None) -> Tours:
        """Return `routes` as tours that are booked, or empty ones."""
        if routes is None:
            return empty_tours(*self.data.size)
        tours = from_routes(self.data.costs, routes)
        self.book(tours)
        return tours

    def book(self, *all_tours: Tours) -> None:
        """Set the costs of tours to what they take by the clock."""
        bookings = empty_bookings(self.instance.n_nodes, self.scale, self.waits.table)
        for tours in all_tours:
            book_all(self.clocks, self.eras, tours, bookings)

    def follow(self, best: Tours, *others: Tours) -> None:
        """Let the reference of the endurances follow the best tours; all are booked anew where it fell."""
        if self.endurance.follow(best.cost) or self.waits.follow(float(best.cost.max())):
            self.book(best, *others)


def half_time(instance: Instance) -> float:
    """Return half of what the longest of greedy tours at take-off takes [s]."""
    plain = at_take_off(instance)
    return 0.5 * makespan(plain, greedy_routes(plain))


def at_take_off(instance: Instance) -> Instance:
    """Return the instance of the costs of take-off of UAVs that are alike, take the least of all, and fly for ever."""
    still = frozen(instance)
    return Instance(still.name, still.cost, still.n_tasks, still.n_depots)


def search_clocks(instance: Instance) -> Clocks:
    """Return the clocks of an instance, legs that cannot be flown taking longer than any tour without them."""
    clocks, travel = clocks_of(instance), instance.travel
    assert travel is not None
    if np.isfinite(travel.cost).all():
        return clocks
    never = 2.0 * (instance.n_tasks + 1) * float(travel.cost[np.isfinite(travel.cost)].max()) or 1.0
    lines = lines_of(np.where(np.isfinite(travel.cost), travel.cost, never), travel.departures).copy()
    ending = np.isinf(travel.cost[:, 1:]) & np.isfinite(travel.cost[:, :-1])  # from one knot to the next
    g, q, i, j = np.nonzero(ending)
    lines[g, i, j, q] = never, 0.0
    lines.setflags(write=False)
    return clocks._replace(lines=lines)
