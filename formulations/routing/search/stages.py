"""Stages: between windows populations of all threads share their best tours, end stages and eras, and begin others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from formulations.routing.search.population import Population
from formulations.routing.search.tours import Tours, copy_tours, duplicate, reprice


def share_best(populations: Sequence[Population]) -> None:
    """Give all populations the best tours of any; where endurances then have another reference price all tours anew."""
    first = min(populations, key=lambda population: population.incumbent)
    for population in populations:
        if population.incumbent > first.incumbent:
            copy_tours(first.best, population.best)
    if first.endurance.follow(first.best.cost):
        family = first.family
        under_way = (tours for population in populations for tours in population.priced)
        for tours in (*family.members, *family.eras.champions, *under_way):
            reprice(first.data.costs, tours)


def next_stages(populations: Sequence[Population], now: float, run: Callable[..., Iterator[object]] = map) -> None:
    """End the stages of populations whose end has come, take their newcomers in and begin the next, always in order.

    Where an era ends with them the stages of all end. run: `map`, or that of a pool of threads.
    """
    ended = [population for population in populations if now >= population.end]
    if not ended:
        return
    list(run(Population.grow_up, ended))
    share_best(populations)
    for population in ended:
        population.take_in()
    if _next_era(populations, now):
        ended = list(populations)
    for i, population in enumerate(ended, len(populations) - len(ended)):
        population.begin(now, others=i)


def _next_era(populations: Sequence[Population], now: float) -> bool:
    """Begin the next era of a family that packs, or let the best of all meet, if it is time; return whether one began.

    Tours that wait to be told of stay the best until they are.
    """
    first, family = populations[0], populations[0].family
    how, eras = first.strategy.packing, family.eras
    if how is None or first.chains:
        return False
    eras.note(first.incumbent, now, how.eras)
    if eras.champions and now >= how.eras.meeting:
        _meet(populations)
    untold = any(population.improved for population in populations)
    if untold or first.packing is None or not eras.is_over(now, family.founder, how.eras):
        return False
    eras.begin(duplicate(first.best), now)
    family.begin_anew()
    _search_from(populations, first.constructed())
    return True


def _meet(populations: Sequence[Population]) -> None:
    """Make the best tours of all eras members, and the best of them the best of all populations."""
    first, champions = populations[0], populations[0].family.eras.champions
    best = (duplicate(first.best), *champions)
    champions.clear()
    _search_from(populations, min(best, key=lambda tours: float(tours.cost.max())))
    for tours in best:
        first.select(tours)


def _search_from(populations: Sequence[Population], best: Tours) -> None:
    """Make `best` the best tours of all populations."""
    for population in populations:
        copy_tours(best, population.best)
