"""Moving costs: speed and excess of `refined` over the best known feasible paths, beside the other methods.

Setting (50 tasks, 3 depots, 2756 ordered pairs): a 20 km square with five polygons as no-fly zones, wind from the
north-east with four vortices, v0 = 100 and 20 m/s. Best known: the cheapest of `refined` itself, of two much heavier
runs of it (finer lattice, more homotopy classes, tighter polyline), and of Dijkstra on 50 000 random samples with
twice the radius. Everything is re-evaluated independently.

    python tests/benchmarks/moving_cost.py [--quick]
"""

import argparse
import sys
import time
from dataclasses import replace

import numpy as np

from formulations.moving_cost.costing import query_of
from formulations.moving_cost.method import MovingCostMethod, MovingCosts, Query
from formulations.moving_cost.registry import make_method
from instances.families import make_scenario
from instances.paths import check_paths

REFINED = make_method("refined")
HEAVY = [
    make_method("refined", {"samples": 20_000, "slack": 0.1, "candidates": 12, "precision": 1e-8}),
    make_method("refined", {"samples": 6_000, "slack": 0.15, "candidates": 16, "precision": 1e-8}),
    make_method("dijkstra", {"samples": 50_000, "radius_factor": 2.0}),
]
OTHERS = {
    "fmt-star, 2 000 samples": make_method("fmt-star", {"samples": 2_000}),
    "fmt-star, 10 000": make_method("fmt-star", {"samples": 10_000}),
    "fmt-star, 10 000, twice the radius": make_method("fmt-star", {"samples": 10_000, "radius_factor": 2.0}),
    "dijkstra, 10 000": make_method("dijkstra", {"samples": 10_000}),
    "dijkstra, 10 000, twice the radius": make_method("dijkstra", {"samples": 10_000, "radius_factor": 2.0}),
}
FAILED: list[str] = []


def bar(what: str, figure: float, limit: float, unit: str = "") -> None:
    """Print a measured figure beside its bar, and remember where it is missed."""
    kept = figure <= limit
    print(f"  {'ok  ' if kept else 'MISS'} {what}: {figure:.3g}{unit} (bar {limit:g}{unit})", flush=True)
    if not kept:
        FAILED.append(what)


def timed(method: MovingCostMethod, query: Query, repeats: int = 1) -> tuple[MovingCosts, float]:
    """Return the result, confirmed, and its CPU seconds, the least of `repeats`."""
    cpu = np.inf
    for _ in range(repeats):
        began = time.process_time()
        found = method.solve(query)
        cpu = min(cpu, time.process_time() - began)
    faults = check_paths(found.paths, found.cost, query.terminals, query.region, query.wind, query.v0)
    if faults:
        sys.exit(f"refuted: {faults}")
    return found, cpu


def setting(v0: float, n_tasks: int = 50, seed: int = 1) -> Query:
    """Return the notes' setting at ground speed `v0`."""
    scenario = make_scenario(
        "wind-vortices", n_tasks, 3, seed, wind_speed=8.0, vortex_speed=4.0, ground_speed=max(v0, 20.0)
    )
    return query_of(replace(scenario, speed=v0))


def excess_table(v0: float, seed: int, others: bool) -> None:
    """Print every method's CPU time and excess over the best known, and the bars of `refined`."""
    query = setting(v0, seed=seed)
    off = ~np.eye(len(query.terminals), dtype=bool)
    runs = {"refined": timed(REFINED, query)}
    if others:
        runs |= {name: timed(method, query) for name, method in OTHERS.items()}
    best = np.min([found.cost for found, _ in [*runs.values(), *(timed(m, query) for m in HEAVY)]], axis=0)
    print(f"v0 = {v0:g} m/s, seed {seed}: {off.sum()} pairs")
    for name, (found, cpu) in runs.items():
        e = found.cost[off] / best[off] - 1
        print(f"  {name:36s} {cpu:6.2f} s CPU  mean {e.mean():.1e}  95 % {np.quantile(e, 0.95):.1e}  max {e.max():.1e}")
    found, cpu = runs["refined"]
    e = found.cost[off] / best[off] - 1
    bar("CPU, all pairs", cpu, 2.0, " s")
    bar("mean excess", e.mean(), 1e-4 if v0 >= 100 else 3e-4)
    if v0 >= 100:
        bar("95 % of pairs within", float(np.quantile(e, 0.95)), 5e-4)
        bar("largest excess", e.max(), 1e-2)


def scaling(v0: float, counts: list[int]) -> None:
    """The paper's claims: n problems instead of n², and shared edges; cost against the number of starts."""
    print("FMT*, 3 000 samples: n² single queries, n multi-query problems without and with shared edges [CPU s]")
    names = ("n_squared", "unshared", "shared", "refined")
    cpu: dict[str, list[float]] = {name: [] for name in names}
    planning: list[float] = []
    for n in counts:
        query = setting(v0, n_tasks=n - 3)
        options = {"samples": 3_000}
        one = replace(query, terminals=query.terminals[:2])
        alone = make_method("fmt-star", options | {"share": False})
        cpu["n_squared"].append(timed(alone, one, 5)[1] / 2 * n * (n - 1))  # two starts, each with its own edges
        cpu["unshared"].append(timed(alone, query, 2)[1])
        runs = [timed(make_method("fmt-star", options), query) for _ in range(5)]
        cpu["shared"].append(min(seconds for _, seconds in runs))
        planning.append(min(found.statistics["planning_cpu"] for found, _ in runs))
        cpu["refined"].append(timed(REFINED, query)[1])
        row = "  ".join(f"{name} {cpu[name][-1]:8.2f}" for name in names)
        print(f"  {n:4d} starts: {row}   sharing saves {cpu['unshared'][-1] / cpu['shared'][-1]:.1f}×", flush=True)
    n = np.array(counts, dtype=float)
    slope, every = (np.polyfit(np.log(n[-3:]), np.log(v[-3:]), 1)[0] for v in (planning, cpu["shared"]))
    bar("exponent of planning time in the number of starts, shared (linear is 1)", slope, 1.0)
    print(f"  with all n² paths read off and re-evaluated: exponent {every:.2f}")
    pairs = np.polyfit(np.log(n[-3:]), np.log(cpu["refined"][-3:]), 1)[0]
    print(f"  refined polishes every pair: exponent {pairs:.2f} in the number of starts")
    bar("shared over unshared time", cpu["shared"][-1] / cpu["unshared"][-1], 0.5)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer settings and starts")
    quick = parser.parse_args().quick
    timed(REFINED, setting(100.0, n_tasks=5))
    for method in OTHERS.values():
        timed(method, setting(100.0, n_tasks=5))
    for v0 in (100.0, 20.0):
        for seed in (1,) if quick else (1, 2, 3):
            excess_table(v0, seed, others=seed == 1)
    scaling(100.0, [13, 26, 53] if quick else [13, 26, 53, 103, 203])
    sys.exit(f"missed: {FAILED}" if FAILED else 0)


if __name__ == "__main__":
    main()
