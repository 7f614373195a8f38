"""`workbench solve --risk`: routes chosen, and searched for, by what they take over an ensemble of forecasts.

Solvers know the one forecast that the costs are of. Their routes for `SEEDS` seeds are flown in every member, and from
those of the least mean, conditional value at risk or greatest makespan a search goes on that knows all members
(`formulations.routing.clocked.risk`), in the time that is left. What it finds is flown as well, by other means than its
own, and taken where that is less. Nothing is proved about others.
"""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path

import click

from formulations.limits import Limits
from formulations.moving_cost.ensemble import member_costs
from formulations.routing.clocked.risk import routes_of_less_risk
from formulations.routing.solver import Status
from instances import Instance, Routes, check_routes, makespan
from instances.environment.wind_forecast import Forecast
from instances.errors import InputError
from instances.files import write_routes
from instances.paths import Paths
from instances.wind_ensemble import WORST, Spread, spread
from reports.record import Run
from workbench.commands.solve_told import as_object, as_text
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.problems.routing import ROUTING
from workbench.terminal import say, say_lines
from workbench.tours import planned_beside

SEEDS = 5
SHARE = 0.1
"""Share of the time limit that each seed gets; the rest is for the search."""
WORST_SHARES = {"mean": 1.0, "cvar": WORST, "worst": 0.0}
"""Risk → share of the members that count, the worst ones."""
REACH = 1.1
"""How far departures reach that the search knows, in greatest makespans of the routes begun with."""


def run_by_risk(instance: Instance, job: Job, risk: str, *, as_json: bool, out: Path | None, beside: Path) -> bool:
    """Run the job for several seeds, search on, print and write the routes of least risk; return whether there are any.

    The job's time limit is that of all.
    """
    if "window" in instance.axes:
        raise InputError(f"{beside}: --risk flies members from take-off at once, and travel.window lets UAVs wait")
    paths, wind, speed = _ensemble(instance, beside)
    found, left = list[tuple[Run, Spread]](), job.time_limit
    for seed in range(job.seed, job.seed + SEEDS):
        result = run(ROUTING, replace(job, seed=seed, time_limit=SHARE * job.time_limit), instance)
        left -= result.elapsed
        if result.own["routes"] is not None:
            over = spread(paths, result.own["routes"], instance.n_tasks, wind, speed)
            assert over is not None
            say(f"seed {seed}: longest tour {result.objective:.6g} s, {risk} {getattr(over, risk):.6g} s", err=True)
            found.append((result, over))
    if not found:
        say("no routes were found")
        return False
    chosen = min(found, key=lambda each: getattr(each[1], risk))
    best, over = _searched(instance, chosen, risk, paths, wind, speed, replace(job, time_limit=left))
    if out:
        write_routes(best.own["routes"], instance, out)
    if as_json:
        click.echo(json.dumps(as_object(best, instance) | {"ensemble": over.to_json(), "chosen": chosen[1].to_json()}))
    else:
        first = f"of {len(found)} seeds the least {risk}: {getattr(chosen[1], risk):.6g} s; with the search "
        say_lines("\n".join([as_text(best, instance), f"{first}{getattr(over, risk):.6g} s: {over.words}"]))
    return True


def _ensemble(instance: Instance, beside: Path) -> tuple[Paths, Forecast, float]:
    """Return the paths beside an instance, their wind that has members, and the speed [m/s]; InputError without."""
    paths, scenario = planned_beside(beside, instance)
    wind = scenario.wind if scenario is not None and scenario.fleet.alike else None
    if paths is None or scenario is None or not isinstance(wind, Forecast) or not wind.members:
        raise InputError(f"{beside}: --risk needs an ensemble: a scenario beside it whose [wind] has members")
    return paths, wind, scenario.speed


def _searched(
    instance: Instance, chosen: tuple[Run, Spread], risk: str, paths: Paths, wind: Forecast, speed: float, job: Job
) -> tuple[Run, Spread]:
    """Return `chosen`, or what a search from there found that is less by the spread; the job's limits are its own."""
    began, (result, least) = time.perf_counter(), chosen
    knots, costs = member_costs(paths, wind, speed, REACH * least.worst)
    left = job.time_limit - (time.perf_counter() - began)
    if left <= 0:
        say("no time was left to search over the ensemble", err=True)
        return chosen
    limits = Limits(time=left, iterations=job.iterations)
    routes: Routes = result.own["routes"]
    share = WORST_SHARES[risk]
    for each in routes_of_less_risk(instance, knots, costs, share, routes, limits=limits, seed=job.seed):
        flyable = not check_routes(instance, each)
        over = spread(paths, each, instance.n_tasks, wind, speed) if flyable else None
        if over is not None and getattr(over, risk) < getattr(least, risk):
            least, own, words = over, ROUTING.own_columns(instance, each), "searched over the ensemble"
            status, objective = Status.FEASIBLE.value, makespan(instance, each)
            result = replace(chosen[0], status=status, objective=objective, message=words, own=own)
    return result, least
