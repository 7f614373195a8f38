"""The search beside the tree: routes are wanted as much as bounds, and each helps the other.

It begins afresh from new seeds, and goes on in parts (`search_in_parts.py`), as long as a gap is left, with a tenth of
the work or less where that is narrow, and more where it is wide: labels grow exponentially with it, and shorter routes
are what narrows it most. Of that extra work every search that finds none takes half.
A relaxation that loses labels may go on and on: the search goes on meanwhile, by the labels that were made in vain.
Where a relaxation is nearly as long as the routes known, some of its tours may well be tours of the best routes, and
ones the memetic search does not light on by itself: then one is kept and the other UAVs are searched for. First comes
the longest of each UAV that makes the relaxation as long as it is, then come tours drawn by their weights: fewer, the
more of these searches find nothing, as the routes may be the best.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from formulations.limits import Limits
from formulations.routing.columns.node import Hint
from formulations.routing.columns.pricing import Column
from formulations.routing.recorder import Recorder
from formulations.routing.search.memetic import Memetic
from formulations.routing.search_in_parts import improve_in_parts, search_of_part
from formulations.routing.solver import ignore, refusal

STEPS = 125
"""Steps of a search, for each pair of tasks."""
_STEPS_AROUND = 50  # the same, of a search around a given tour
_STEPS_A_ROUND = 50  # of the search while a narrow gap is left, for each task and round of column generation
_NARROW, _MOST = 0.005, 8.0  # gap, as a share of the routes, up to which it is narrow; times as many steps at most
_NEAR = 0.01  # gap, as a share of the routes, above which relaxations say nothing of tours
_STEPS_A_LABEL = 0.05  # and for each label made in vain
_ROUNDS_A_RELAXATION, _ROUNDS_A_LIST = 25, 200  # as which a relaxation that is near, and a list in vain then, count
_LONG = 2.0  # as many first searches one takes at least where no relaxation is near: short ones end in the same traps
_IN_VAIN = 5  # searches around tours drawn that find nothing, after which that counts half
_AFRESH = 5  # one in so many searches around tours drawn is around none


class Search:
    """The search that goes on, as many steps as the work done in the tree deserves.

    counts : the tree's counters; run : how many searches there were; tolerance : share by which routes must be better.
    """

    def __init__(self, recorder: Recorder, counts: Counter[str], seed: int, run: int, tolerance: float) -> None:
        self.recorder, self.counts, self.seed, self.run, self.tolerance = recorder, counts, seed, run, tolerance
        self._steps, self._due, self._work, self._lists, self._barren, self._in_vain = 0, 0.0, 0.0, 0, 0, 0
        self._tried: set[tuple[int, frozenset[int]]] = set()
        self._rng = np.random.default_rng(seed)

    def better(self, hint: Hint) -> bool:
        """Search on where that is due; return whether there are better routes. Counts work, not time: repeatable.

        Where the relaxation is near, around the first of its long tours that is new before that is due, by one search
        at most; else around tours drawn.
        """
        n, before = self.recorder.instance.n_tasks, self.recorder.objective
        near, new = bool(hint.used) and hint.level >= (1 - _NEAR) * before, self._new(hint)
        self._count_work(hint, near)
        due = self._due - self._steps
        if near and new is not None and due > -STEPS * n**2:
            self._tried.add(_key(new))
            self._around(new, self.seed)
        elif near:
            for _ in range(int(due / (_STEPS_AROUND * n**2))):
                self._around_drawn(hint)
                self._in_vain += 1
                if self.recorder.objective < before:
                    self._in_vain = 0
                    break
        elif due >= _LONG * STEPS * n**2:
            self._on(int(due), afresh=True)
            self._barren = 0 if self.recorder.objective < before else self._barren + 1
        return self.recorder.objective < before * (1 - self.tolerance)

    def _count_work(self, hint: Hint, near: bool) -> None:
        """Count the steps that are due for what was done in the tree since the last time."""
        n, lists = self.recorder.instance.n_tasks, self.counts["lists in vain"]
        work = _STEPS_A_ROUND * n * self.counts["rounds"] + _STEPS_A_LABEL * self.counts["labels in vain"]
        level = max(hint.level, self.recorder.bound)  # trees under lower caps know of more than their relaxations
        wide = min((1 - level / self.recorder.objective) / _NARROW, _MOST)
        self._due += (work - self._work) * max(1.0, wide / 2**self._barren)
        if near:
            also = _ROUNDS_A_RELAXATION + _ROUNDS_A_LIST * (lists - self._lists)
            self._due += _STEPS_A_ROUND * n * also / (1 + self._in_vain / _IN_VAIN)
        self._work, self._lists = work, lists

    def _new(self, hint: Hint) -> Column | None:
        """Return the first long tour that was not searched around, None where there is none."""
        return next((tour for tour in hint.long if _key(tour) not in self._tried), None)

    def _around_drawn(self, hint: Hint) -> None:
        """Search around a tour drawn by its weight, or, every so often, on from the best routes."""
        if self.run % _AFRESH == 0:
            self._on(_STEPS_AROUND * self.recorder.instance.n_tasks**2)
            return
        weight = np.array([share for _, share in hint.used])
        self._around(hint.used[self._rng.choice(weight.size, p=weight / weight.sum())][0], self.seed + self.run)

    def _on(self, steps: int, *, afresh: bool = False) -> None:
        """Search on from the best routes, or afresh: what a short search found may be a trap for the next."""
        self._steps += search(self.recorder, steps, self.seed, self.run, self.recorder.remaining / 3, afresh=afresh)
        self.run += 1

    def _around(self, tour: Column, seed: int) -> None:
        """Search around a tour."""
        steps = _STEPS_AROUND * self.recorder.instance.n_tasks**2
        self._steps += steps
        search_around(self.recorder, tour, steps, seed, self.recorder.remaining / 3)
        self.run += 1


def _key(tour: Column) -> tuple[int, frozenset[int]]:
    """Return what tells tours apart: the UAV and its tasks."""
    return tour.uav, frozenset(tour.tasks)


def first_routes(recorder: Recorder, seed: int, runs: int) -> None:
    """Look for routes: search `runs` times, from different seeds, for a third of the time left.

    There are some afterwards, however poor, unless UAVs cannot fly them.
    """
    instance = recorder.instance
    recorder.incumbent((tuple(instance.tasks), *((),) * (instance.n_depots - 1)))
    for run in range(runs):
        share = recorder.remaining / (3 * (runs - run))
        search(recorder, STEPS * instance.n_tasks**2, seed, run, share)


def search(recorder: Recorder, steps: int, seed: int, run: int, time: float, *, afresh: bool = False) -> int:
    """Run the memetic search for the `run`-th time, then in parts; return the steps made, none where it cannot.

    After the first time from the best routes known, which are one member of its first population; not if `afresh`.
    """
    memetic, instance = Memetic(), recorder.instance
    if time <= 0 or refusal(memetic, instance) is not None:
        return 0
    found = Recorder(instance, Limits(time=time), ignore)
    limits, start = Limits(time=time, iterations=steps), None if afresh or run == 0 else recorder.routes
    routes = memetic.solve(instance, limits=limits, seed=seed + run, start=start).routes
    if routes is None:
        return steps
    recorder.incumbent(routes)
    found.incumbent(routes)
    made = improve_in_parts(found, seed + run)
    recorder.incumbent(found.routes or routes)
    return steps + made


def search_around(recorder: Recorder, tour: Column, steps: int, seed: int, time: float) -> None:
    """Search for routes that contain `tour`: for tours of the other UAVs over the other tasks."""
    m = recorder.instance.n_depots
    others, alone = [k for k in range(m) if k != tour.uav], tuple(tour.tasks if k == tour.uav else () for k in range(m))
    if time > 0:
        limits = Limits(time=time, iterations=steps)
        routes = search_of_part(recorder.instance, alone, others, limits, seed, goes_on=False)
        if routes is not None:
            recorder.incumbent(routes)
