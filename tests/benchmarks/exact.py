"""Bars of the exact methods: measured figure beside bar.

    python tests/benchmarks/exact.py [--quick] [--tasks 40] [--uavs 3] [--first 10] [--seconds 120] [--solver exact]
        [--benchmarks DIR] [--instances a,b] [SECTION...]

Sections: subset (subset-dp, n = 20 and 22), proofs (by branch-and-price or --solver, n = 40 to 100), long (exact,
m = 2), gaps (certified where no proof is in reach), bounds (of 200 tasks, without a tree), public (eil51, berlin52,
eil76), agreement (300 random instances against subset-dp), ratio (exact against circuit and branch-and-cut), fleets
(UAVs of several speeds, 30 to 100 tasks), threads (branch-and-price by one thread and by two).
Times are CPU seconds of the process (children included) unless called wall.

Instances: the family square-wind (a 20 km square, airspeed 20 m/s, wind (4, −2) m/s plus a rotation of 5 m/s at the
edge); seeds count from 0. Fleets: the same places and winds, the paper's cost at each UAV's own speed.
"""

from __future__ import annotations

import argparse
import os
import resource
import time
from functools import partial
from statistics import geometric_mean, median

import numpy as np
import public_sets

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.arc_tree import ArcTree
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.capped_total import capped_total
from formulations.routing.columns.destructive import destructive_bounds
from formulations.routing.registry import make_solver
from formulations.routing.solver import Result, Solver, Status
from formulations.routing.subset_dp import SubsetDp
from formulations.routing.total import total
from instances import Instance, Routes, Travel, check_routes

KNOWN = {  # proved optima [s] of seeds 0, 1, 2
    (20, 2): (2295.084, 2048.518, 1979.242),
    (20, 3): (1578.891, 1603.418, 1697.514),
    (20, 4): (1173.440, 1288.910, 1235.960),
    (30, 2): (2299.984, 2194.440, 2385.230),
    (30, 3): (1820.611, 1678.482, 1868.150),
    (30, 4): (1315.000, 1639.341, 1723.179),
    (40, 2): (2616.011, 2509.269, 2621.851),
    (40, 3): (1868.924, 1795.758, 1773.941),
    (40, 4): (1433.316, 1485.499, 1456.734),
    (50, 3): (2058.511, 2052.582, 2211.421),
    (50, 4): (1709.777, 1608.736, 1541.500),
    (60, 4): (1708.692, 1650.808, 1627.962),
    (60, 5): (1467.725, 1425.594, 1324.873),
    (60, 6): (1314.149, 1125.559, 1314.846),
    (80, 8): (1069.405, 1166.750, 1261.873),
    (100, 10): (958.748, 1020.009, 1034.000),
}
PROOFS = (  # n, m, CPU seconds, how many of ten
    (40, 3, 15.0, 10),
    (40, 4, 15.0, 10),
    (50, 3, 60.0, 10),
    (50, 4, 60.0, 9),
    (50, 5, 60.0, 9),
    (60, 3, 300.0, 8),
    (60, 4, 300.0, 8),
    (60, 5, 300.0, 8),
    (60, 6, 300.0, 8),
    (80, 8, 40.0, 10),
    (100, 10, 90.0, 10),
)
FLEETS = (  # tasks, speeds [m/s], CPU seconds, how many of ten
    (30, (20, 25, 30), 5.0, 8),
    (30, (20, 20, 30), 5.0, 8),
    (40, (15, 20, 25, 30), 10.0, 8),
)
KNOWN_FLEETS = {  # proved optima [s] of seeds from 0
    (30, (20, 25, 30)): (1454.373717,),
    (30, (20, 20, 30)): (1534.109435,),
    (40, (15, 20, 25, 30)): (1334.456866, 1299.068506),
}
TEN = (15, 15, 20, 20, 20, 25, 25, 25, 30, 30)
CLASSICS = (
    *("eil51_2", "eil51_3", "eil51_5", "berlin52_2", "berlin52_3", "berlin52_5"),
    *("eil76_2", "eil76_5", "eil76_7", "rat99_2"),
)


def wind_instance(n: int, m: int, seed: int) -> Instance:
    """The random instance described at the top."""
    return generate("square-wind", n, m, seed)


def fleet(n: int, speeds: tuple[int, ...], seed: int) -> Instance:
    """UAVs that fly straight legs at these speeds [m/s]: c_ijk = ℓ_ij/v_k − W_ij/v_k², W the wind's circulation."""
    m = len(speeds)
    points = np.random.default_rng(1000 * n + 100 * m + seed).uniform(0, 20000, (n + m, 2))
    d, (x, y) = points[None] - points[:, None], (points - 10000).T
    wind = 4 * d[..., 0] - 2 * d[..., 1] + 5e-4 * (np.outer(x, y) - np.outer(y, x))
    costs = [np.maximum(np.hypot(d[..., 0], d[..., 1]) / v - wind / v**2, 0.0) for v in speeds]
    return Instance.of_travel(f"fleet-{n}-{m}-s{seed}", Travel.of_uavs(costs), n, coordinates=points)


def cpu() -> float:
    """CPU seconds of this process and its ended children."""
    t = os.times()
    return t.user + t.system + t.children_user + t.children_system


def peak_memory() -> float:
    """Most memory this process held so far [GiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2


def run(solver: Solver, instance: Instance, limit: float, threads: int = 1) -> tuple[Result, float, float]:
    """Solve; return the result, CPU and wall seconds. Wrong routes or a wrong optimum stop the script."""
    began, wall = cpu(), time.perf_counter()
    result = solver.solve(instance, limits=Limits(time=limit, threads=threads))
    spent, lasted = cpu() - began, time.perf_counter() - wall
    assert result.routes is not None, instance.name
    assert not check_routes(instance, result.routes), instance.name
    known = KNOWN.get((instance.n_tasks, instance.n_depots), ())
    seed = int(instance.name.rpartition("-s")[2]) if instance.name.startswith("square-wind") else 99
    if seed < len(known):
        assert result.bound is None or result.bound <= known[seed] + 2e-3, instance.name
        if result.status is Status.OPTIMAL:
            assert abs(result.objective - known[seed]) < 2e-3 + result.tolerance, instance.name
    return result, spent, lasted


def subset(asked: argparse.Namespace) -> None:
    """How long subset programming takes: it depends on the size alone."""
    print("subset-dp: n m | status | CPU s")
    solver = SubsetDp()
    for n, m in ((20, 2), (20, 3), (20, 4), (22, 3), (22, 4)):
        if asked.tasks in (None, n):
            solver.prepare(wind_instance(n, m, 0))
            result, spent, _ = run(solver, wind_instance(n, m, 0), 600.0)
            print(f"{n:4d} {m:3d} | {result.status} | {spent:.2f}", flush=True)


def proofs(asked: argparse.Namespace) -> None:
    """Every size: how many seeds are proved within the bar."""
    print(f"proofs by {asked.solver}: n m | proved within the bar | median, greatest CPU s | worst gap | memory | each")
    solver = make_solver(asked.solver)
    solver.prepare(wind_instance(17, 3, 0))
    for n, m, bar, of_ten in PROOFS:
        if asked.tasks not in (None, n) or asked.uavs not in (None, m):
            continue
        seeds = range(asked.first, asked.first + (2 if asked.quick else 10))
        limit = asked.seconds or 3 * bar  # the bar counts CPU seconds; a busy machine may need more by the clock
        runs = [run(solver, wind_instance(n, m, seed), limit) for seed in seeds]
        good = [spent for result, spent, _ in runs if result.status is Status.OPTIMAL and spent <= bar]
        gaps = [result.gap or 0.0 for result, _, _ in runs]
        each = " ".join(f"{spent:.1f}" if result.status is Status.OPTIMAL else "–" for result, spent, _ in runs)
        middle = f"median {median(good):6.2f}, greatest {max(good):6.2f} CPU s" if good else "none"
        late = max(lasted for _, _, lasted in runs) - limit
        print(
            f"{n:4d} {m:3d} | {len(good)} of {len(runs)} (bar {of_ten} of 10 in {bar:.0f} s) | {middle} | "
            f"worst gap {max(gaps):.2%} | peak memory so far {peak_memory():.1f} GiB (bar 4) | {each}"
            + (f" | {late:.1f} s over the limit" if late > 2 else ""),
            flush=True,
        )


def long_tours(asked: argparse.Namespace) -> None:
    """Two UAVs: the portfolio on two threads."""
    print("exact on two threads, m = 2: n | proved | wall s of each | by")
    solver = make_solver("exact")
    solver.prepare(wind_instance(20, 2, 0))
    for n, limit, of_ten in ((40, 120.0, 8), (50, 180.0, 6), (60, 180.0, 6), (80, 180.0, 8), (100, 300.0, 8)):
        if asked.tasks not in (None, n):
            continue
        runs = [run(solver, wind_instance(n, 2, seed), limit, 2) for seed in range(2 if asked.quick else 10)]
        good = [lasted for result, _, lasted in runs if result.status is Status.OPTIMAL]
        names = [str(result.statistics["proved_by"]) for result, _, _ in runs]
        by = ", ".join(f"{name} {names.count(name)}" for name in sorted(set(names)))
        print(f"{n:4d} | {len(good)} of {len(runs)} (bar {of_ten} of 10 in {limit:.0f} s) | "
              f"{' '.join(f'{t:.1f}' for t in good)} | {by}", flush=True)  # fmt: skip


def gaps(asked: argparse.Namespace) -> None:
    """Where proofs are out of reach: the certified gap."""
    print("certified gaps of branch-and-price: n m | gap | bound | routes | wall s")
    solver = BranchAndPrice()
    solver.prepare(wind_instance(10, 2, 0))
    for n, m, bar in ((100, 5, "2 % in 300 s"), (100, 3, "as small as possible"), (200, 10, "as small as possible")):
        if asked.tasks not in (None, n) or asked.uavs not in (None, m):
            continue
        instance = wind_instance(n, m, asked.first)
        result, _, lasted = run(solver, instance, asked.seconds or (60.0 if asked.quick else 600.0))
        gap = "none" if result.gap is None else f"{result.gap:.2%}"
        print(f"{n:4d} {m:3d} | {gap} (bar {bar}) | {result.bound} | {result.objective:.3f} | {lasted:.1f}", flush=True)


def bounds(asked: argparse.Namespace) -> None:
    """Lower bounds without a tree, as `workbench bound` makes them, beside routes of half a minute."""
    print(
        "lower bounds: n m | routes | gap of total | of capped total | of capped tours, and as the cap is bisected | "
        "CPU s of each"
    )
    search = make_solver("memetic")
    search.prepare(wind_instance(10, 2, 0))
    BranchAndPrice().prepare(wind_instance(10, 2, 0))
    for n, m, bar in ((200, 3, "10 %"), (200, 10, "5 %")):
        if asked.tasks not in (None, n):
            continue
        instance = wind_instance(n, m, 0)
        upper = run(search, instance, 30.0)[0].objective
        assert upper is not None
        began, end = cpu(), time.perf_counter() + (asked.seconds or (60.0 if asked.quick else 300.0))
        found = total(instance, upper, end - time.perf_counter())
        values, spent = [found.bound], [cpu() - began]
        values.append(capped_total(instance, upper, end - time.perf_counter()).bound)
        spent.append(cpu() - began)
        for value in destructive_bounds(instance, 0.0, upper, partial(_left, end), price=found.price):
            values.append(value)
            spent.append(cpu() - began)
        gaps_, times = " ".join(f"{1 - v / upper:.2%}" for v in values), " ".join(f"{t:.1f}" for t in spent)
        late = time.perf_counter() - end
        print(f"{n:4d} {m:3d} | {upper:.3f} | {gaps_} (bar {bar}) | {times}"
              + (f" | {late:.1f} s over the limit" if late > 0.5 else ""), flush=True)  # fmt: skip


def _left(end: float) -> float:
    return end - time.perf_counter()


def fleets(asked: argparse.Namespace) -> None:
    """UAVs of several speeds: proofs within the bar, and the certified gap of a hundred tasks."""
    print("fleets by branch-and-price: n speeds | proved within the bar | CPU s of each")
    solver = BranchAndPrice()
    solver.prepare(fleet(10, (20, 30), 0))
    for n, speeds, bar, of_ten in FLEETS:
        if asked.tasks not in (None, n):
            continue
        each, good = [], 0
        for seed in range(2 if asked.quick else 10):
            result, spent, _ = run(solver, fleet(n, speeds, seed), asked.seconds or 6 * bar)
            proved = result.status is Status.OPTIMAL
            if proved and seed < len(known := KNOWN_FLEETS[n, speeds]):
                assert abs(result.objective - known[seed]) < result.tolerance + 1e-6, (n, speeds, seed)
            good += proved and spent <= bar
            each.append(f"{spent:.1f}" if proved else "–")
        print(
            f"{n:4d} {speeds} | {good} of {len(each)} (bar {of_ten} of 10 in {bar:.0f} s) | {' '.join(each)}",
            flush=True,
        )
    if asked.tasks in (None, 100):
        print(f"fleet of 100 tasks at {TEN} m/s (bar 1 % in 300 s, 5 of 10): seed | gap | bound | routes | CPU s")
        for seed in range(1 if asked.quick else 10):
            result, spent, _ = run(solver, fleet(100, TEN, seed), asked.seconds or (60.0 if asked.quick else 300.0))
            print(
                f"{seed:4d} | {result.gap:.2%} | {result.bound:.3f} | {result.objective:.3f} | {spent:.0f}", flush=True
            )


def public(asked: argparse.Namespace) -> None:
    """The classics of mTSPLib, one depot."""
    if not asked.benchmarks.is_dir():
        print(f"public: skipped, the public instances are not there ({asked.benchmarks}; --benchmarks DIR)")
        return
    print("public instances by exact on two threads: name | status | routes | bound | gap | wall s")
    solver = make_solver("exact")
    only = tuple(filter(None, asked.instances.split(","))) or CLASSICS
    for instance, _ in public_sets.public(asked.benchmarks, "single_mtsplib", only=only):
        solver.prepare(instance)
        result, _, lasted = run(solver, instance, asked.seconds or (20.0 if asked.quick else 120.0), 2)
        bound = "none" if result.bound is None else f"{result.bound:.3f}"
        print(
            f"{instance.name} | {result.status} | {result.objective:.3f} | {bound} | {result.gap or 0:.2%} | "
            f"{lasted:.1f}",
            flush=True,
        )


def agreement(asked: argparse.Namespace) -> None:
    """Random instances against subset-dp, with loose starts, permutations and tiny bins."""
    count, wrong, open_ = 60 if asked.quick else 300, 0, 0
    for seed in range(count):
        rng = np.random.default_rng(seed)
        n, m = int(rng.integers(1, 15)), int(rng.integers(1, 6))
        cost = rng.uniform(0, 100, (n + m, n + m)) if seed % 2 else rng.integers(0, 9, (n + m, n + m)).astype(float)
        np.fill_diagonal(cost, 0.0)
        instance = wind_instance(n, m, seed) if seed % 3 == 0 else Instance("any", cost, n, m)
        oracle = SubsetDp().solve(instance, limits=Limits(time=600.0))
        order = np.concatenate([rng.permutation(n), n + rng.permutation(m)])
        permuted = Instance("permuted", instance.cost[np.ix_(order, order)], n, m)
        worst: Routes = (tuple(range(n)), *[()] * (m - 1))
        bins = int(rng.integers(1, 12))
        for solver, given, start in (
            (BranchAndPrice(starts=1), instance, None),
            (BranchAndPrice(starts=0), permuted, worst),
            (BranchAndPrice(starts=0, bins=bins, tours=300), instance, loosened(oracle.routes or worst, n, rng)),
            (ArcTree(starts=0), permuted, worst),
        ):
            result = solver.solve(given, limits=Limits(time=60.0), start=start)
            best = oracle.objective or 0.0
            faults = check_routes(given, result.routes or ())
            open_ += result.status is not Status.OPTIMAL
            claimed = (
                result.status is Status.OPTIMAL and abs((result.objective or 0.0) - best) > result.tolerance + 1e-9
            )
            wrong += bool(faults) or claimed or (result.bound or 0.0) > best + 1e-9
    print(f"agreement: {count} instances of n ≤ 14, four ways each: {wrong} wrong (bar 0), {open_} not proved in 60 s")


def loosened(routes: Routes, n: int, rng: np.random.Generator) -> Routes:
    """The same routes with three tasks thrown onto the ends of any tours: a loose upper bound."""
    tours = [list(route) for route in routes]
    for task in rng.integers(n, size=3):
        for tour in tours:
            if task in tour:
                tour.remove(int(task))
        tours[rng.integers(len(tours))].append(int(task))
    return tuple(tuple(tour) for tour in tours)


def ratio(asked: argparse.Namespace) -> None:
    """Exact against circuit and branch-and-cut, one thread each, in one run."""
    limit = 20.0 if asked.quick else 60.0
    names = ("exact", "circuit", "branch-and-cut")
    print(f"CPU s to proof, limit {limit:.0f} s wall (– not proved): n m | " + " | ".join(names))
    solvers = {name: make_solver(name) for name in names}
    against: dict[str, list[float]] = {"circuit": [], "branch-and-cut": []}
    for n, m in ((20, 2), (20, 3), (20, 4), (30, 3), (40, 2), (40, 4), (60, 6)):
        if asked.tasks not in (None, n):
            continue
        instance = wind_instance(n, m, 0)
        times: dict[str, float | None] = {}
        for name, solver in solvers.items():
            if solver.accepts(instance) is None:
                solver.prepare(instance)
                result, spent, _ = run(solver, instance, limit)
                times[name] = spent if result.status is Status.OPTIMAL else None
        print(
            f"{n:4d} {m:3d} | " + " | ".join("–" if times.get(x) is None else f"{times[x]:.2f}" for x in names),
            flush=True,
        )
        for name, ratios in against.items():
            if times["exact"] is not None and (times.get(name) is None or (times[name] or 0) > 5):
                ratios.append((times.get(name) or limit) / times["exact"])
    for name, ratios in against.items():
        if ratios:
            print(f"{name} / exact, geometric mean where it needs over 5 s (unproved counted at the limit): "
                  f"{geometric_mean(ratios):.1f} (bar 5)")  # fmt: skip


def threads(asked: argparse.Namespace) -> None:
    """The same proof by one thread and by two, one after the other: nothing else may run beside it."""
    print("branch-and-price by one thread and by two: n m | wall s of one / of two")
    solver, ratios = BranchAndPrice(), []
    solver.prepare(wind_instance(10, 2, 0))
    for n, m in ((60, 4), (60, 5), (80, 8), (100, 10)):
        if asked.tasks not in (None, n):
            continue
        times = []
        for seed in range(asked.first, asked.first + (1 if asked.quick else 3)):
            pair = [run(solver, wind_instance(n, m, seed), asked.seconds or 200.0, count) for count in (1, 2)]
            if all(result.status is Status.OPTIMAL for result, _, _ in pair):
                assert pair[0][0].statistics == pair[1][0].statistics, (n, m, seed)
                times.append([lasted for _, _, lasted in pair])
        ratios += [one / two for one, two in times]
        print(f"{n:4d} {m:3d} | " + ", ".join(f"{one:.1f} / {two:.1f}" for one, two in times), flush=True)
    if ratios:
        print(f"ratio {geometric_mean(ratios):.2f}, of {len(ratios)} proofs")


SECTIONS = {
    "subset": subset,
    "proofs": proofs,
    "long": long_tours,
    "gaps": gaps,
    "bounds": bounds,
    "public": public,
    "agreement": agreement,
    "ratio": ratio,
    "fleets": fleets,
    "threads": threads,
}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", choices=[[], *SECTIONS], metavar="SECTION")
    parser.add_argument("--quick", action="store_true", help="fewer seeds, shorter limits")
    parser.add_argument("--tasks", type=int, help="only this many tasks, in proofs, long, gaps, bounds and ratio")
    parser.add_argument("--uavs", type=int, help="only this many UAVs, in proofs and gaps")
    parser.add_argument("--solver", default="branch-and-price", help="whose proofs, in proofs")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="first seed, in proofs, gaps and threads")
    parser.add_argument("--seconds", type=float, help="limit of a run by the clock, in proofs, gaps, bounds and public")
    parser.add_argument("--instances", default="", help="only these, separated by commas, in public")
    public_sets.add_option(parser)
    asked = parser.parse_args()
    for section in asked.sections or SECTIONS:
        SECTIONS[section](asked)
