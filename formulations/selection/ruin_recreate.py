"""`ruin-recreate`: take some tasks out, put in what tells most for its time, keep what is better. For any size.

Ruin: random tasks, the chosen ones nearest to a place, a string of one tour, or a whole tour. Recreate: again and
again the task and place of most gain^a / time, with a and a noise on gains drawn anew each time, so that prize, time
and their ratio all lead at some time. Then tours are straightened and what now fits is put in. Accepted by threshold on
the worth (simulated annealing, cooling with the clock or the iterations), with ties to the shorter tours.

Ruin and recreate: Schrimpf et al., J. Comput. Phys. 159 (2000); gain by time as in Tsiligirides' heuristic for the
orienteering problem, J. Oper. Res. Soc. 35 (1984).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.routing.search.randomness import Rng, below, seeded, uniform
from formulations.selection.gains import Gains, choose, gain, restart
from formulations.selection.selection import Record, SelectionMethod, SelectionProblem
from formulations.selection.tours import Data, Tours, assign, best_place, insert, remove, straighten
from instances.arrays import Bools, Floats
from instances.kernels import njit

_ROUND = 500
"""Iterations between two looks at the clock."""
_HOT = 0.1
"""Threshold at the start, of the best worth: what an iteration may lose; it falls to nothing.

At 0.02 three of four runs of 4 s end 4 % below the optimum of Chao's p3.2.j (31 tasks), at 0.1 none does.
"""


@dataclass(frozen=True)
class RuinRecreate(SelectionMethod):
    """Ruin and recreate.

    seconds : of search at most [s], where the limits do not end it before (at least 0).
    """

    seconds: float = 10.0

    def prepare(self, problem: SelectionProblem) -> None:
        """Compile the kernels: one iteration on the problem itself."""
        _Search(problem, 0).run(1, 0.0)

    def search(self, problem: SelectionProblem, record: Record, seed: int) -> str:
        """Search; a limit of iterations makes it repeatable."""
        return self.improve(problem, record, seed, record.limits.iterations)

    def improve(self, problem: SelectionProblem, record: Record, seed: int, most: int | None) -> str:
        """Search for `seconds`, or `most` iterations where that is a number."""
        run = _Search(problem, seed)
        until = min(record.limits.time, record.elapsed + self.seconds)
        began, done = record.elapsed, 0
        while (most is None or done < most) and record.elapsed < until and not record.proved:
            share = done / most if most is not None else (record.elapsed - began) / (until - began)
            steps = _ROUND if most is None else min(_ROUND, most - done)
            run.run(steps, _HOT * (1 - share) ** 2)
            done += steps
            record.offer(run.best.routes())
        return "iterations" if most is not None and done >= most else "time"


class _Search:
    """The state of a search."""

    def __init__(self, problem: SelectionProblem, seed: int) -> None:
        self.data = Data.of(problem.instance, problem.worth)
        self.now = Tours.empty(problem.instance.n_tasks, problem.instance.n_depots)
        self.best, self.trial = self.now.copy(), self.now.copy()
        self.values = np.zeros(2)  # worth of `now`, of `best`
        self.gains = Gains.of(self.data)
        self.rng = seeded(seed)

    def run(self, steps: int, hot: float) -> None:
        """Make some iterations."""
        _iterate(self.data, self.gains, self.now, self.trial, self.best, self.values, steps, hot, self.rng)


@njit(cache=True)
def _iterate(
    data: Data,
    gains: Gains,
    now: Tours,
    trial: Tours,
    best: Tours,
    values: Floats,
    steps: int,
    hot: float,
    rng: Rng,
) -> None:
    leaving = np.zeros(data.prizes.size, np.bool_)
    for _ in range(steps):
        assign(trial, now)
        _ruin(data, trial, leaving, rng)
        remove(data, trial, leaving)
        restart(data, gains, trial.tour)
        _recreate(data, gains, trial, rng)
        for k in range(trial.size.size):
            straighten(data, trial, k)
        _recreate(data, gains, trial, rng)
        worth = gains.worth[0]
        level = values[0] + hot * values[1] * np.log(max(uniform(rng), 1e-300))
        if worth > level or (worth == values[0] and trial.cost.sum() <= now.cost.sum()):
            assign(now, trial)
            values[0] = worth
        if worth > values[1] * (1 + 1e-12) or (worth >= values[1] and trial.cost.sum() < best.cost.sum()):
            assign(best, trial)
            values[1] = worth


@njit(cache=True)
def _ruin(data: Data, tours: Tours, leaving: Bools, rng: Rng) -> None:
    """Mark the tasks that leave."""
    leaving[:] = False
    n = leaving.size
    chosen = np.flatnonzero(tours.tour >= 0)
    if chosen.size == 0:
        return
    kind = below(rng, 10)
    wanted = 1 + below(rng, max(3, chosen.size // 3))
    if kind < 3:
        for _ in range(wanted):
            leaving[chosen[below(rng, chosen.size)]] = True
    elif kind < 6:
        centre = below(rng, n)
        between = data.between[below(rng, data.between.shape[0])]
        distance = np.minimum(between[centre][chosen], between[:, centre][chosen])
        for a in np.argsort(distance)[:wanted]:
            leaving[chosen[a]] = True
    elif kind < 9:
        task = chosen[below(rng, chosen.size)]
        k = tours.tour[task]
        first = below(rng, tours.size[k])
        for a in range(first, min(first + wanted, tours.size[k])):
            leaving[tours.stops[k, a]] = True
    else:
        k = tours.tour[chosen[below(rng, chosen.size)]]
        for a in range(tours.size[k]):
            leaving[tours.stops[k, a]] = True


@njit(cache=True)
def _recreate(data: Data, gains: Gains, tours: Tours, rng: Rng) -> None:
    """Put in tasks, the best gain for its time first, while any fits."""
    n, m = data.prizes.size, tours.size.size
    weight = (0.0, 0.5, 1.0, 1.0, 2.0)[below(rng, 5)]
    noise = np.empty(n)
    for i in range(n):
        noise[i] = 0.7 + 0.6 * uniform(rng)
    dislike = np.ones(m)  # of UAVs, half of the time: the cheapest for a task may be the only one for another
    if uniform(rng) < 0.5:
        for k in range(m):
            dislike[k] += 4.0 * uniform(rng) ** 2
    more, place = np.empty((n, m)), np.empty((n, m), np.int64)
    for i in range(n):
        for k in range(m):
            more[i, k], place[i, k] = best_place(data, tours, k, i) if tours.tour[i] < 0 else (np.inf, 0)
    while True:
        task, uav, most = -1, -1, 0.0
        for i in range(n):
            if tours.tour[i] >= 0:
                continue
            k = int(np.argmin(more[i] * dislike))
            if more[i, k] < np.inf:
                worth = gain(data, gains, i) * noise[i]
                if worth <= 0.0:
                    continue
                score = worth**weight / (max(more[i, k], 0.0) + 1e-9 * data.cap[data.way[k]])
                if score > most:
                    task, uav, most = i, k, score
        if task < 0:
            return
        insert(data, tours, uav, task, place[task, uav])
        choose(data, gains, task)
        for i in range(n):
            if tours.tour[i] < 0:
                more[i, uav], place[i, uav] = best_place(data, tours, uav, i)
