"""Annealing for an ensemble of forecasts: routes whose makespan over the members has the least mean, CVaR or maximum.

With C_max^s the makespan in member s, sorted from the greatest, all three are one weighted sum,

    ρ = Σ_r w_r C_max^(r),   w_r = min(1, max(0, αM − r)) / αM,   r = 0, 1, …

α = 1 for the mean, 0.2 for the CVaR, 1/M or less for the greatest. What is annealed is ρ + ε · mean of C_k^s over
members and tours, since ρ alone is flat. A step exchanges two segments, either of which may be empty or all the rest,
of two tours (relocation, swap, 2-opt*), or moves or reverses a segment, or all, of one, so that a task comes beside a
near one; the one or two tours changed are flown anew in every member. Nothing is proved, and what the routes take is
for others to say (`instances.wind_ensemble`).

Source: R. T. Rockafellar, S. Uryasev, J. Risk 2 (2000) 21–41 (CVaR); É. Taillard et al., Transp. Sci. 31 (1997)
170–186 (exchange of segments).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.limits import Limits
from formulations.routing.clocks import Clocks, clocks_at, leg_at
from formulations.routing.recorder import Recorder
from formulations.routing.search.budget import Budget, BudgetParameters
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.randomness import Rng, below, seeded, uniform
from formulations.routing.solver import ignore
from instances import Instance, Routes
from instances.arrays import Floats, Ints
from instances.kernels import njit

ANNEALINGS = 4
"""Runs that share the limit, each from the best routes so far."""
FIRST, LAST = 0.08, 2e-5
"""Temperatures, as shares of the risk of the routes begun with: runs of 10⁶ steps (36 tasks, 3 UAVs, 5 members) that
began at 0.02 ended up to 4 % higher."""
EVEN = 0.5, 1e-2
"""Share ε of the mean tour at the first temperature and at the last."""
WIDTH = 12
"""Near tasks that a task may come beside."""
DEPOTS, WHOLE = 0.1, 0.02
"""Shares of steps that bring a task to a depot, and that turn a tour round."""
TURNED = 0.25
"""Share of segments that are reversed as they are put elsewhere."""
LONGEST = 3
"""Tasks of a segment that does not reach its tour's end."""


class Ensemble(NamedTuple):
    """Clocks, whose class 0 is the forecast planned with and 1..M the members; w (M,); endurance (m,) [s]; near tasks
    (n, width) of each task.
    """

    clocks: Clocks
    weights: Floats
    endurance: Floats
    near: Nodes


class Plan(NamedTuple):
    """Tours: order (m, n) of their tasks, size (m,), times (m, 1 + M) [s]; of each task its tour and place (n,)."""

    order: Nodes
    size: Ints
    times: Floats
    tour: Ints
    place: Ints


@njit(cache=True, nogil=True)
def _fly(clocks: Clocks, depot: int, order: Nodes, size: int, times: Floats) -> None:
    """Set `times` (1 + M,) [s] to what the first `size` tasks of `order` take from and to `depot`."""
    for s in range(times.size):
        time, here = 0.0, depot
        for p in range(size):
            time += leg_at(clocks, s, here, order[p], time)
            here = order[p]
        times[s] = time + leg_at(clocks, s, here, depot, time) if size else 0.0


@njit(cache=True, nogil=True)
def _risk(weights: Floats, plan: Plan, trial: Plan, a: int, b: int, spans: Floats) -> tuple[float, float]:
    """Return ρ and the mean over members and tours [s] where tours a and b are those of `trial`."""
    m, total = plan.size.size, 0.0
    for s in range(weights.size):
        span = 0.0
        for k in range(m):
            time = trial.times[0, s + 1] if k == a else trial.times[1, s + 1] if k == b else plan.times[k, s + 1]
            span = max(span, time)
            total += time
        r = s
        while r > 0 and spans[r - 1] < span:
            spans[r] = spans[r - 1]
            r -= 1
        spans[r] = span
    risk = 0.0
    for s in range(weights.size):
        risk += weights[s] * spans[s]
    return risk, total / (m * weights.size)


@njit(cache=True, nogil=True)
def _put(source: Nodes, begin: int, end: int, turned: bool, target: Nodes, size: int) -> int:
    """Write source[begin:end], `turned` or not, to target[size:]; return the size then."""
    for p in range(begin, end):
        target[size] = source[begin + end - 1 - p] if turned else source[p]
        size += 1
    return size


@njit(cache=True, nogil=True)
def _segment(rng: Rng, shortest: int, at: int, behind: bool, size: int) -> tuple[int, int]:
    """Return begin and end of a segment of a tour that begins at gap `at`, or ends there unless `behind`."""
    left, drawn = size - at if behind else at, shortest + below(rng, LONGEST + 2 - shortest)
    length = left if drawn > LONGEST else min(drawn, left)
    return (at, at + length) if behind else (at - length, at)


@njit(cache=True, nogil=True)
def _propose(plan: Plan, near: Nodes, rng: Rng, trial: Plan) -> tuple[int, int]:
    """Write one or two changed tours to `trial`; return their numbers, −1 for none."""
    v = below(rng, plan.tour.size)
    a, i, ahead, turned = plan.tour[v], plan.place[v], uniform(rng) < 0.5, uniform(rng) < TURNED
    one, size, new = plan.order[a], plan.size[a], trial.order[0]
    if uniform(rng) < WHOLE:
        trial.size[0] = _put(one, 0, size, True, new, 0)
        return a, -1
    if near.shape[1] == 0 or uniform(rng) < DEPOTS:
        b = below(rng, plan.size.size)
        gap = plan.size[b] if ahead else 0
    else:
        u = near[v, below(rng, near.shape[1])]
        b = plan.tour[u]
        gap = plan.place[u] + (0 if ahead else 1)  # v comes ahead of the near task u, or behind it
    if a == b and uniform(rng) < 0.5:  # what lies between is reversed
        beyond = i if ahead else i + 1
        begin, end = (beyond, gap) if gap > i else (gap, beyond)
        to = _put(one, begin, end, True, new, _put(one, 0, begin, False, new, 0))
        trial.size[0] = _put(one, end, size, False, new, to)
        return (a if end > begin + 1 else -1), -1
    behind = ahead == turned
    begin, end = _segment(rng, 1, i if behind else i + 1, behind, size)
    if a == b:
        if begin <= gap <= end:
            return -1, -1
        to = _put(one, 0, min(gap, begin), False, new, 0)
        to = _put(one, end, gap, False, new, to)  # nothing where the gap is before the segment
        to = _put(one, begin, end, turned, new, to)
        to = _put(one, gap, begin, False, new, to)
        trial.size[0] = _put(one, max(gap, end), size, False, new, to)
        return a, -1
    two, other = plan.order[b], trial.order[1]
    first, last = _segment(rng, 0, gap, not ahead, plan.size[b])
    to = _put(two, first, last, turned, new, _put(one, 0, begin, False, new, 0))
    trial.size[0] = _put(one, end, size, False, new, to)
    to = _put(one, begin, end, turned, other, _put(two, 0, first, False, other, 0))
    trial.size[1] = _put(two, last, plan.size[b], False, other, to)
    return a, b


@njit(cache=True, nogil=True)
def _take(plan: Plan, k: int, trial: Plan, row: int) -> None:
    """Let tour k be row `row` of `trial`."""
    plan.size[k] = trial.size[row]
    for p in range(trial.size[row]):
        v = trial.order[row, p]
        plan.order[k, p], plan.tour[v], plan.place[v] = v, k, p
    for s in range(trial.times.shape[1]):
        plan.times[k, s] = trial.times[row, s]


@njit(cache=True, nogil=True)
def anneal_for_risk(
    ensemble: Ensemble, plan: Plan, best: Plan, lowest: float, rng: Rng, steps: int, temperature: float, even: float,
    trial: Plan,
) -> float:  # fmt: skip
    """Take steps at one temperature [s]; keep in `best` what is below its risk `lowest` [s], and return that then.

    even : share ε; trial : room for two tours.
    """
    clocks, weights, n, m = ensemble.clocks, ensemble.weights, plan.tour.size, plan.size.size
    spans = np.empty(weights.size)
    risk, mean = _risk(weights, plan, trial, -1, -1, spans)
    now = risk + even * mean
    for _ in range(steps):
        a, b = _propose(plan, ensemble.near, rng, trial)
        if a < 0:
            continue
        _fly(clocks, n + a, trial.order[0], trial.size[0], trial.times[0])
        flown = trial.times[0, 0] <= ensemble.endurance[a]
        if b >= 0:
            _fly(clocks, n + b, trial.order[1], trial.size[1], trial.times[1])
            flown = flown and trial.times[1, 0] <= ensemble.endurance[b]
        risk, mean = _risk(weights, plan, trial, a, b, spans)
        then = risk + even * mean
        if not flown or then >= now - temperature * math.log(1.0 - uniform(rng)):
            continue
        now = then
        _take(plan, a, trial, 0)
        if b >= 0:
            _take(plan, b, trial, 1)
        if risk < lowest:
            lowest = risk
            for k in range(m):
                _take(best, k, plan, k)
    return lowest


def risk_weights(members: int, share: float) -> Floats:
    """Return w (members,) of the mean over the worst `share` α of them, from 0, the worst alone, to 1."""
    worst = max(share * members, 1.0)
    return np.clip(worst - np.arange(members), 0.0, 1.0) / worst


def routes_of_less_risk(
    instance: Instance, knots: Floats, costs: Floats, share: float, routes: Routes, *, limits: Limits, seed: int
) -> list[Routes]:
    """Return what each of several annealings from `routes` ends with, the later ones of no more risk by these costs.

    Parameters
    ----------
    instance
        Whose UAVs are alike; its endurance is kept in the forecast planned with.
    knots, costs
        Shapes (Q,) and (1 + M, Q, N, N) [s]: of legs by departure in that forecast and in M members.
    share
        α of the members that count, the worst ones.
    routes
        To begin with.
    limits
        Wall clock; or steps, of which the result is then a function, with `seed`.
    """
    n, m, members = instance.n_tasks, instance.n_depots, len(costs) - 1
    clocks = clocks_at(costs, knots, np.arange(members + 1))
    endurance = np.full(m, np.inf) if instance.endurance is None else np.asarray(instance.endurance, dtype=np.float64)
    ensemble = Ensemble(clocks, risk_weights(members, share), endurance, _near(costs.mean(axis=(0, 1))[:n, :n]))
    best, plan, trial = (_plan(clocks, n, given) for given in (routes, routes, ((), ())))
    scale = lowest = _risk(ensemble.weights, best, trial, -1, -1, np.empty(members))[0]
    rng, parameters, found = seeded(seed), BudgetParameters(), list[Routes]()
    anneal_for_risk(ensemble, plan, best, lowest, rng, 0, scale, 0.0, trial)  # compiles
    budget = Budget(Recorder(instance, limits, ignore), parameters)
    while not budget.stopped_by:
        number, done = divmod(ANNEALINGS * budget.fraction, 1.0)
        if number > len(found):
            found.append(_routes(best))
            plan = _plan(clocks, n, found[-1])
        temperature, even = (high * (low / high) ** done for high, low in ((FIRST, LAST), EVEN))
        steps = budget.next_steps(parameters.level)
        lowest = anneal_for_risk(ensemble, plan, best, lowest, rng, steps, scale * temperature, even, trial)
        budget.took(steps)
    return [*found, _routes(best)]


def _near(costs: Floats) -> Nodes:
    """Return the nearest tasks of each, (n, width), by `costs` (n, n) [s] in the cheaper direction."""
    either = np.minimum(costs, costs.T)
    np.fill_diagonal(either, np.inf)
    return np.argsort(either, axis=1, kind="stable")[:, : min(WIDTH, len(costs) - 1)].astype(np.int32)


def _plan(clocks: Clocks, n: int, routes: Routes) -> Plan:
    """Return `routes` past n tasks as a Plan, flown."""
    rows, tour, place = len(routes), np.zeros(n, np.int64), np.zeros(n, np.int64)
    plan = Plan(
        np.zeros((rows, n), np.int32), np.zeros(rows, np.int64), np.zeros((rows, len(clocks.classes))), tour, place
    )
    for k, route in enumerate(routes):
        tasks = list(route)
        plan.order[k, : len(tasks)], plan.size[k] = tasks, len(tasks)
        tour[tasks], place[tasks] = k, np.arange(len(tasks))
        _fly(clocks, n + k, plan.order[k], len(tasks), plan.times[k])
    return plan


def _routes(plan: Plan) -> Routes:
    return tuple(tuple(row[:size].tolist()) for row, size in zip(plan.order, plan.size, strict=True))
