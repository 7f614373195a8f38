"""Routes chosen, and searched for, by what they take over an ensemble of forecasts.

Solvers know the one forecast that the costs are of. Their routes for `SEEDS` seeds are flown in every member, and from
those of the least mean, conditional value at risk or greatest makespan a search goes on that knows all members
(`formulations.routing.clocked.risk`), in the time that is left. What it finds is flown as well, by other means than its
own, and taken where that is less. Nothing is proved about others.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from formulations.limits import Limits
from formulations.moving_cost.ensemble import member_costs
from formulations.routing.clocked.risk import routes_of_less_risk
from formulations.routing.solver import Status
from instances import Instance, Routes, check_routes, makespan
from instances.wind_ensemble import WORST, Ensemble, Spread
from reports.record import Run
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.problems.routing import ROUTING

SEEDS = 5
SHARE = 0.1
"""Share of the time limit that each seed gets; the rest is for the search."""
WORST_SHARES = {"mean": 1.0, "cvar": WORST, "worst": 0.0}
"""Risk → share of the members that count, the worst ones."""
REACH = 1.1
"""How far departures reach that the search knows, in greatest makespans of the routes begun with."""

Flown = tuple[Run, Spread]
"""A run with routes, and what its longest tour takes over the members."""


@dataclass(frozen=True)
class LeastRisk:
    """What was found: `best` in the end, `chosen` among the seeds, `alone` the seed best in the forecast itself."""

    best: Flown
    chosen: Flown
    alone: Flown
    seeds: int


def least_risk(
    instance: Instance, job: Job, risk: str, ensemble: Ensemble, tell: Callable[[str], None]
) -> LeastRisk | None:
    """Run the job for several seeds and search on; None where no seed found routes. The job's limit is that of all."""
    found, left = list[Flown](), job.time_limit
    for seed in range(job.seed, job.seed + SEEDS):
        result = run(ROUTING, replace(job, seed=seed, time_limit=SHARE * job.time_limit), instance)
        left -= result.elapsed
        if result.own["routes"] is not None:
            over = ensemble.flown(instance, result.own["routes"])
            tell(f"seed {seed}: longest tour {result.objective:.6g} s, {risk} {getattr(over, risk):.6g} s")
            found.append((result, over))
    if not found:
        return None
    chosen = min(found, key=lambda each: getattr(each[1], risk))
    best = _searched(instance, chosen, risk, ensemble, replace(job, time_limit=left), tell)
    return LeastRisk(best, chosen, min(found, key=lambda each: each[0].objective or 0.0), len(found))


def _searched(
    instance: Instance, chosen: Flown, risk: str, ensemble: Ensemble, job: Job, tell: Callable[[str], None]
) -> Flown:
    """Return `chosen`, or what a search from there found that is less by the spread; the job's limits are its own."""
    began, (result, least) = time.perf_counter(), chosen
    knots, costs = member_costs(ensemble.paths, ensemble.wind, ensemble.speed, REACH * least.worst)
    left = job.time_limit - (time.perf_counter() - began)
    if left <= 0:
        tell("no time was left to search over the ensemble")
        return chosen
    limits = Limits(time=left, iterations=job.iterations)
    routes: Routes = result.own["routes"]
    share = WORST_SHARES[risk]
    for each in routes_of_less_risk(instance, knots, costs, share, routes, limits=limits, seed=job.seed):
        over = None if check_routes(instance, each) else ensemble.flown(instance, each)
        if over is not None and getattr(over, risk) < getattr(least, risk):
            least, own, words = over, ROUTING.own_columns(instance, each), "searched over the ensemble"
            status, objective = Status.FEASIBLE.value, makespan(instance, each)
            result = replace(chosen[0], status=status, objective=objective, message=words, own=own)
    return result, least
