"""Plans that know no clock against plans that do, and the speed of the searches by the clock.

    python tests/benchmarks/clocks.py [--seconds 10] [--seeds 4] [loss speed optima proofs walls windows risk]

Sections: loss (40 tasks, 3 UAVs at the paper's depots, winds that turn: what the plan for the wind of take-off
promised, what it takes, what it takes with every tour in its better direction, what `memetic` by the clock finds; of
static plans that promise the same that of several seeds which takes least in its better directions;
losses against the latter, beside those once measured), speed (steps a second of the annealing by the clock and of the
static one), optima (`memetic` against `subset-dp`), proofs (`branch-and-price` in turning winds), walls
(what costs by departure around walls take: wall clock, CPU and peak memory of this process; what paths planned by the
clock save), windows (what a take-off within half an hour saves where endurance is 95 % of the least makespan, and how
often searches find it), risk (36 tasks, 3 UAVs, five members: best of five seeds of `memetic`, a tenth of the seconds
each, against the search over members from there in half of them, the members' costs left out). One thread but for
walls, which plans on two; seconds are those of each search.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import math
import resource
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from shapely.geometry import box

from formulations.limits import Limits
from formulations.moving_cost.clocked import clocked_instance
from formulations.moving_cost.costing import instance_of
from formulations.moving_cost.departures import PLANS as MOMENTS
from formulations.moving_cost.departures import PathClock
from formulations.moving_cost.ensemble import member_costs
from formulations.moving_cost.families import generate
from formulations.routing.clocked.annealing import anneal_by_clock
from formulations.routing.clocked.problem import ClockedProblem
from formulations.routing.clocked.risk import routes_of_less_risk
from formulations.routing.greedy import greedy_routes
from formulations.routing.registry import make_solver
from formulations.routing.search.annealing import anneal
from formulations.routing.search.energy import p_norm
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.randomness import seeded
from formulations.routing.search.schedule import Schedule
from formulations.routing.search.tours import duplicate, sum_costs
from formulations.routing.solver import Status
from instances import Instance, Routes, makespan
from instances.environment.region import Region
from instances.environment.wind_changing import Turning
from instances.environment.wind_forecast import Forecast, sampled
from instances.families import make_scenario
from instances.frozen import frozen, judged
from instances.moving_cost import CostKind
from instances.paths import Paths
from instances.scenario import Scenario
from instances.wind_ensemble import spread
from workbench.risk import REACH, WORST_SHARES

Case = tuple[float, float, float]
LOSSES: dict[Case, tuple[tuple[float, ...], tuple[float, ...]]] = {
    (20, 10, 90): ((4.8, 4.7, 5.7, 8.0), (2.3, 4.7, 0.2, 3.0)),
    (20, 5, 90): ((2.9,), (1.8,)),
    (30, 10, 90): ((3.2,), (2.2,)),
    (20, 10, 360): ((49.0,), (28.0,)),
    (100, 10, 90): ((0.007,), (0.0,)),
}
"""Airspeed, wind [m/s], turning [degree/h] → losses [%] once measured, as planned and in the better directions."""

PLANS = 4
"""Static plans of different seeds: the longest tour leaves the others free, so that optima are many."""

WALLS = ((4500, 2000, 5000, 11000), (9800, 8000, 10300, 18000), (14500, 3000, 15000, 12000))
"""Corners [m] of no-fly zones, x₀, y₀, x₁, y₁."""


def of_case(case: Case, seed: int) -> Instance:
    """Return the instance: wind from the north-east, paper depots."""
    airspeed, wind, turning = case
    more = {"airspeed": airspeed, "wind_speed": wind, "turning": turning, "wind_direction": 225, "depots": "paper"}
    return generate("wind-turning", 40, 3, seed, **more)


def searched(instance: Instance, seconds: float, seed: int) -> Routes:
    """Return the routes memetic finds."""
    solver = make_solver("memetic")
    solver.prepare(instance)
    routes = solver.solve(instance, limits=Limits(time=seconds), seed=seed).routes
    assert routes is not None
    return routes


def loss(args: argparse.Namespace) -> None:
    """Print a line for each case and seed."""
    print("airspeed wind turning seed | promised taken directed clocked [s] | promise off, loss, directed [%] | once")
    for case, (once, once_directed) in LOSSES.items():
        for seed in range(min(args.seeds, len(once))):
            instance = of_case(case, seed)
            plans = [judged(instance, searched(frozen(instance), args.seconds, s)) for s in range(PLANS)]
            least = min(plan.promised for plan in plans)
            equals = [plan for plan in plans if plan.promised <= least * (1 + 1e-6)]
            plan = min(equals, key=lambda plan: plan.directed)
            clocked = min(makespan(instance, searched(instance, args.seconds, s)) for s in range(2))
            lost, lost_directed = (100 * (value / clocked - 1) for value in (plan.taken, plan.directed))
            wrong = 100 * (plan.taken / plan.promised - 1)
            values = f"{plan.promised:.1f} {plan.taken:.1f} {plan.directed:.1f} {clocked:.1f}"
            then = f"{once[seed]}, {once_directed[seed]}"
            print(*case, seed, "|", values, "|", f"{wrong:.2f}, {lost:.3f}, {lost_directed:.3f}", "|", then, flush=True)


def speed(args: argparse.Namespace) -> None:
    """Steps a second at the same temperatures from the same tours."""
    for n, m in ((40, 3), (100, 5)):
        instance = generate("wind-turning", n, m, 0)
        static, clocked = (steps_a_second(instance, by_clock) for by_clock in (False, True))
        print(
            f"{n} tasks, {m} UAVs: {static:.0f} static, {clocked:.0f} by the clock, {clocked / static:.0%}, bar: 60 %"
        )


def steps_a_second(instance: Instance, by_clock: bool, steps: int = 50_000, levels: int = 100) -> float:
    """Return the steps a CPU second of one annealing, compiled before."""
    parameters = SearchParameters()
    problem = ClockedProblem(instance, parameters.neighbourhood)
    tours = problem.tours(greedy_routes(frozen(instance)))
    if not by_clock:
        sum_costs(tours)
    rng, how, schedule = seeded(0), parameters.annealing, parameters.schedule
    best, fittest, search = duplicate(tours), duplicate(tours), problem.search(duplicate(tours), how.removals)
    course, spent = Schedule(schedule.founder, schedule.softness[0], schedule.final), 0.0
    for level in range(-1, levels):
        temperature, objective = course.at(max(level, 0) / levels, best, float(best.cost.max()), schedule)
        began, count = time.process_time(), steps // levels if level >= 0 else 10
        if by_clock:
            anneal_by_clock(search, best, fittest, rng, count, temperature, objective, p_norm(128), how)
        else:
            anneal(problem.data, tours, best, fittest, rng, count, temperature, objective, p_norm(128), how)
        spent += time.process_time() - began if level >= 0 else 0.0
    return steps / spent


def optima(args: argparse.Namespace) -> None:
    """Count how often memetic finds what subset-dp proves."""
    hits = 0
    for seed in range(20):
        rng = np.random.default_rng([3, seed])
        n, m = int(rng.integers(8, 15)), int(rng.integers(2, 4))
        instance = generate("wind-turning", n, m, seed, turning=(90, 360)[seed % 2])
        best = make_solver("subset-dp").solve(instance, limits=Limits(time=60)).objective
        assert best is not None
        hits += makespan(instance, searched(instance, min(args.seconds, 5.0), seed)) <= best * (1 + 1e-9)
    print(f"optimum found in {hits} of 20, bar: 20")


def proofs(args: argparse.Namespace) -> None:
    """Print what branch-and-price takes to a proof, 60 s at most."""
    for n, m in ((20, 2), (20, 3), (20, 4), (30, 3), (40, 3)):
        seconds, proved = [], 0
        for seed in range(max(args.seeds, 10)):
            instance, solver = generate("wind-turning", n, m, seed), make_solver("branch-and-price")
            solver.prepare(instance)
            began = time.process_time()
            result = solver.solve(instance, limits=Limits(time=60), seed=0)
            seconds.append(time.process_time() - began)
            proved += result.status is Status.OPTIMAL
        shown = f"{np.median(seconds):.1f} s of CPU in the middle, {max(seconds):.1f} at most"
        print(f"{n} tasks, {m} UAVs: {proved} of {len(seconds)} proved, {shown}", flush=True)


def walls(args: argparse.Namespace) -> None:
    """Print what costs of 53 nodes by departure take, among drifting vortices and three walls."""
    for tasks in (3, 50):  # the few compile
        scenario = make_scenario("wind-drifting", tasks, 3, 0)
        scenario = replace(scenario, no_fly=[box(*corners) for corners in WALLS])
        wall, cpu = time.perf_counter(), time.process_time()
        instance, paths = instance_of(scenario)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6  # kB, on Linux
    assert instance.travel is not None
    knots, error = len(instance.travel.departures), instance.provenance["clock"]["error"]
    print(f"{len(scenario.points)} nodes, {knots} knots, off by {error:.2f} s between them at most: ", end="")
    print(f"{wall:.0f} s, bar: 60; {cpu:.0f} s of CPU; {memory:.2f} GB, bar: 2", flush=True)
    print(f"sum of all costs {instance.travel.cost.sum():.9e} s, which a change for speed must leave as it is")
    staying = replace(paths, later=paths.later[: MOMENTS - 1], departures=paths.departures[: MOMENTS - 1])
    both, alone = (PathClock(scenario, [each]).at(instance.travel.departures)[0] for each in (paths, staying))
    saved, legs = 1 - both[alone > 0] / alone[alone > 0], 1 - both.sum() / alone.sum()
    some = ", ".join(f"{(saved > share).mean():.1%} more than {share:.0%}" for share in (0.01, 0.05, 0.1))
    print(f"planned by the clock as well: {legs:.2%} of all time saved, {saved.max():.1%} of a leg's at most; {some}")
    print(f"least saved of a leg's: {saved.min():.1e}, bar: 0")


def windows(args: argparse.Namespace) -> None:
    """Print how many fleets of too little endurance fly all tasks where they may wait, and what searches find of it."""
    solver, limits, names = make_solver("subset-dp"), Limits(time=120), ("memetic", "ruin-recreate", "ga", "greedy")
    for n, m in ((8, 2), (10, 3), (12, 3)):
        seconds, longer, hits = [], [], dict.fromkeys(names, 0)
        for seed in range(max(args.seeds, 10)):
            instance = generate("wind-turning", n, m, seed)
            assert instance.travel is not None
            solver.prepare(instance)
            least = solver.solve(instance, limits=limits).objective or 0.0
            travel = replace(instance.travel, window=1800.0)
            waiting = replace(instance, travel=travel, endurance=np.full(m, 0.95 * least))
            solver.prepare(waiting)
            began = time.process_time()
            result = solver.solve(waiting, limits=limits)
            seconds.append(time.process_time() - began)
            assert result.status in (Status.OPTIMAL, Status.INFEASIBLE)
            longer += [] if result.objective is None else [result.objective / least - 1]
            for name in names if result.objective is not None else ():
                search = make_solver(name)
                search.prepare(waiting)
                found = search.solve(waiting, limits=Limits(time=args.seconds), seed=0).objective or math.inf
                hits[name] += found <= (result.objective or 0.0) * (1 + 1e-6)
        shown = ", ".join(f"{share:.1%}" for share in sorted(longer))
        words = f"{len(longer)} of {len(seconds)} flyable with waiting, none at once; they land later by {shown or '-'}"
        print(f"{n} tasks, {m} UAVs: {words}; at most {max(seconds):.2f} s of CPU", flush=True)
        print("    of these optimal: " + ", ".join(f"{hits[name]} by {name}" for name in names), flush=True)


def of_members(seed: int, n: int = 36, members: int = 5) -> tuple[Scenario, Forecast]:
    """Return a scenario in open country and its forecast, of winds that turn by 0° to 180° an hour at 7 to 13 m/s."""
    rng, side = np.random.default_rng(seed), 20e3
    region, frames = Region.rectangle(side, side), np.arange(0.0, 7201.0, 600.0)

    def forecast(turning: float, speed: float, towards: float) -> Forecast:
        angle = np.radians(towards)
        wind = Turning((speed * math.cos(angle), speed * math.sin(angle)), math.radians(turning) / 3600)
        return sampled(wind, region, frames, 4)

    drawn = (rng.uniform(0, 180, members), rng.uniform(7, 13, members), rng.uniform(195, 255, members))
    others = tuple(forecast(*each) for each in zip(*drawn, strict=True))
    wind, depots, tasks = replace(forecast(90, 10, 225), members=others), rng.uniform(0, side, (3, 2)), (n, 2)
    return Scenario("ensemble", region, depots, 20.0, wind, rng.uniform(0, side, tasks), cost=CostKind.TIME), wind


def risk(args: argparse.Namespace) -> None:
    """Print what choosing among seeds gives and what searching over the members gives, for every risk."""
    print("seed risk | of the seeds' routes [s] | chosen searched [s] gain [%]")
    for seed in range(args.seeds):
        scenario, wind = of_members(seed)
        instance, points = clocked_instance(scenario), scenario.points
        n, legs = instance.n_tasks, itertools.product(points, repeat=2)
        paths = Paths.of(len(points), [np.array([a, b]) if a is not b else np.empty((0, 2)) for a, b in legs])
        judge = functools.partial(spread, paths, n_tasks=n, wind=wind, speed=scenario.speed)
        all_routes = [searched(instance, 0.1 * args.seconds, s) for s in range(5)]
        spreads = [each for routes in all_routes if (each := judge(routes)) is not None]
        began = time.process_time()
        knots, costs = member_costs(paths, wind, scenario.speed, REACH * max(each.worst for each in spreads))
        print(f"{seed} costs of members: {time.process_time() - began:.1f} s of CPU")
        limits = Limits(time=0.5 * args.seconds)
        for name, share in WORST_SHARES.items():
            values = [getattr(each, name) for each in spreads]
            first = int(np.argmin(values))
            found = routes_of_less_risk(instance, knots, costs, share, all_routes[first], limits=limits, seed=0)
            least = min(values[first], *(getattr(judge(each), name) for each in found))
            gain = 100 * (1 - least / values[first])
            told = " ".join(f"{value:.1f}" for value in values)
            print(seed, name, "|", told, "|", f"{values[first]:.1f} {least:.1f} {gain:.2f}", flush=True)


SECTIONS: dict[str, Callable[[argparse.Namespace], None]] = {
    "loss": loss,
    "speed": speed,
    "optima": optima,
    "proofs": proofs,
    "walls": walls,
    "windows": windows,
    "risk": risk,
}


def main() -> None:
    """Run the sections asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", choices=[*SECTIONS, []], help="all, if none is named")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each search")
    args = parser.parse_args()
    for name in args.sections or SECTIONS:
        SECTIONS[name](args)


if __name__ == "__main__":
    main()
